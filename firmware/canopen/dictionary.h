/* dictionary.h - the object dictionary: a const table of entries, and the memory of its values.
 *
 * The table (written by tools/objects/generate) lies in read-only memory. A value has one of the homes below; only
 * TUMBLE_HOME_VARIABLES and TUMBLE_HOME_OTHER cost RAM, and that RAM is the caller's.
 * Values go in and out as little-endian bytes (bytes.h), whatever the machine.
 *
 * A second table may stand behind the first: the extension, for objects that only some computers have. It has limits,
 * constants and hooks of its own, and shares the rest. Places run on from the first table into it.
 *
 * A write is checked in this order, and the first refusal counts: exists, access, length, limits, hook; then it is
 * stored whole. Nothing here waits, allocates or keeps state. Not re-entrant on one set of values.
 */
#ifndef TUMBLE_CANOPEN_DICTIONARY_H
#define TUMBLE_CANOPEN_DICTIONARY_H

#include "canopen/abort.h"

#include <assert.h>
#include <stdint.h>

/* Longest value of an object, and so the SDO server's buffer. */
#define TUMBLE_MAX_OBJECT_BYTES 64

/* CiA 301 data type codes (table 44). */
#define TUMBLE_TYPE_BOOLEAN 0x01U
#define TUMBLE_TYPE_INTEGER8 0x02U
#define TUMBLE_TYPE_INTEGER16 0x03U
#define TUMBLE_TYPE_INTEGER32 0x04U
#define TUMBLE_TYPE_UNSIGNED8 0x05U
#define TUMBLE_TYPE_UNSIGNED16 0x06U
#define TUMBLE_TYPE_UNSIGNED32 0x07U
#define TUMBLE_TYPE_REAL32 0x08U
#define TUMBLE_TYPE_VISIBLE_STRING 0x09U
#define TUMBLE_TYPE_REAL64 0x11U
#define TUMBLE_TYPE_INTEGER64 0x15U
#define TUMBLE_TYPE_UNSIGNED64 0x1BU

/* tumble_entry_t.access */
#define TUMBLE_ACCESS_READ 0x01U
#define TUMBLE_ACCESS_WRITE 0x02U
#define TUMBLE_ACCESS_MAP_RECEIVE 0x04U  /* may be mapped into a receive PDO */
#define TUMBLE_ACCESS_MAP_TRANSMIT 0x08U /* may be mapped into a transmit PDO */
#define TUMBLE_ACCESS_SERVICE 0x10U      /* written from outside at service level only: the SDO server sees to it */
#define TUMBLE_ACCESS_EXTENSION 0x80U    /* of the extension: set in an entry that was found, not in its table */

/* tumble_entry_t.home: where the value lives. */
#define TUMBLE_HOME_IMMEDIATE 0U     /* the entry's offset is the value; a write (dummy mapping) goes nowhere */
#define TUMBLE_HOME_CONSTANT 1U      /* in the table's constants */
#define TUMBLE_HOME_VARIABLES 2U     /* in the caller's variables */
#define TUMBLE_HOME_OTHER 3U         /* in a second struct of the caller's, such as the mirror of a drive's objects */
#define TUMBLE_HOME_COMPUTED 4U      /* nowhere: the application's hooks make and take it */
#define TUMBLE_HOME_COMMUNICATION 5U /* inside canopen (1001h..1BFFh): the node's own hooks make and take it */

#define TUMBLE_MAX_OFFSET 0x7FFU

/* One entry, or in a table a run of them that are alike: subindices one after the other, whose values lie one after the
 * other in their home; objects one after the other of COMMUNICATION. Subindex 0 of an object with further ones needs no
 * entry where it is what CiA 301 wants there: the highest subindex, read only. */
typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t type : 5;  /* TUMBLE_TYPE_... */
    uint8_t home : 3;  /* TUMBLE_HOME_... */
    uint8_t access;    /* TUMBLE_ACCESS_... bits */
    uint8_t size;      /* bytes; of a string: the most it may have. 1 to TUMBLE_MAX_OBJECT_BYTES */
    uint8_t limit : 4; /* 0: none; else 1 + place in the table's limits */
    uint8_t more_objects : 4;
    uint8_t more_subindices;
    uint16_t offset : 11; /* bytes into its home; free for the hooks' use when COMPUTED or COMMUNICATION */
    uint16_t source : 5;  /* of COMPUTED: what the hooks take it from and give it to, by their own numbers */
} tumble_entry_t;

static_assert(sizeof(tumble_entry_t) == 10, "the dictionary table is the largest constant of a node");

/* Limits of a number, both included. Types up to 32 bits and reals; not for 64-bit integers. */
typedef struct {
    double low;
    double high;
} tumble_limit_t;

typedef struct {
    const tumble_entry_t *entries; /* none twice; those of one object in the order of their subindices */
    const tumble_limit_t *limits;
    const void *constants;
    uint8_t count;
} tumble_object_table_t;

/* The application's say. Every member may be null. `context` is the binding's. */
typedef struct {
    /* Make the value of a COMPUTED entry: put its bytes at `bytes` (room for TUMBLE_MAX_OBJECT_BYTES); `size` comes in
     * as the entry's size and may be made smaller for a string.
     * Returns TUMBLE_ABORT_NONE or the reason to refuse. Without this hook a COMPUTED entry reads as
     * TUMBLE_ABORT_NO_DATA. */
    tumble_abort_t (*read)(void *context, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size);

    /* A value that passed type, length and limits is about to be stored; for a COMPUTED entry this is the store.
     * Returns TUMBLE_ABORT_NONE to accept, else the reason to refuse; a refused value changes nothing. Called for SDO
     * and for receive PDOs alike. Without this hook a COMPUTED entry refuses with TUMBLE_ABORT_ACCESS. What takes its
     * time returns TUMBLE_ABORT_LATER, for a COMPUTED entry alone: see tumble_sdo_server_answer (sdo.h). */
    tumble_abort_t (*write)(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size);
} tumble_object_hooks_t;

typedef struct {
    const tumble_object_hooks_t *hooks; /* may be null */
    void *context;
} tumble_object_owner_t;

/* A second table: objects that the first does not have, whole; 255 entries together. */
typedef struct {
    const tumble_object_table_t *table;
    const tumble_object_hooks_t *hooks; /* may be null; their context is the application's */
} tumble_object_extension_t;

/* Tables bound to their memory. */
typedef struct {
    const tumble_object_table_t *table;
    const tumble_object_extension_t *extension; /* null: none */
    void *variables;                            /* may be null when no entry lives there; likewise `other` */
    void *other;
    tumble_object_owner_t application;
    tumble_object_owner_t communication; /* set by the node */
} tumble_dictionary_t;

/* The row of a table at a place that was found. */
const tumble_entry_t *tumble_dictionary_row(const tumble_dictionary_t *dictionary, uint8_t place);

/* Find the place in the tables where an object is described; searches all of them.
 * Returns TUMBLE_ABORT_NONE, TUMBLE_ABORT_NO_OBJECT or TUMBLE_ABORT_NO_SUBINDEX. */
tumble_abort_t tumble_dictionary_place(const tumble_dictionary_t *dictionary, uint16_t index, uint8_t subindex,
                                       uint8_t *place);

/* The entry of the object that was found at `place`; its `more_` members mean nothing. No search. */
tumble_entry_t tumble_dictionary_entry(const tumble_dictionary_t *dictionary, uint8_t place, uint16_t index,
                                       uint8_t subindex);

/* Both: on TUMBLE_ABORT_NONE `entry` is the object's, else it is left alone. */
tumble_abort_t tumble_dictionary_find(const tumble_dictionary_t *dictionary, uint16_t index, uint8_t subindex,
                                      tumble_entry_t *entry);

/* Read the value of an entry into `bytes` (room for TUMBLE_MAX_OBJECT_BYTES) and its length into `size`. A string comes
 * without its padding and may be empty.
 * Returns TUMBLE_ABORT_NONE, TUMBLE_ABORT_WRITE_ONLY, or what a hook says. */
tumble_abort_t tumble_dictionary_read(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry,
                                      uint8_t *bytes, uint8_t *size);

/* Write a value of `size` bytes.
 * Returns TUMBLE_ABORT_NONE, TUMBLE_ABORT_READ_ONLY, TUMBLE_ABORT_TOO_LONG, TUMBLE_ABORT_TOO_SHORT, TUMBLE_ABORT_VALUE
 * (not a number; a BOOLEAN beyond 1), TUMBLE_ABORT_TOO_HIGH, TUMBLE_ABORT_TOO_LOW, or what a hook says. */
tumble_abort_t tumble_dictionary_write(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry,
                                       const uint8_t *bytes, uint8_t size);

/* From a variable in the machine's own form to the entry's little-endian bytes, and its length; for hooks that have the
 * value in memory. `variable` must be of the entry's type, a string entry->size bytes. */
void tumble_dictionary_pack(const tumble_entry_t *entry, const void *variable, uint8_t *bytes, uint8_t *size);

/* The reverse, for a value that `write` has been given. */
void tumble_dictionary_unpack(const tumble_entry_t *entry, void *variable, const uint8_t *bytes, uint8_t size);

/* Could a value of `size` bytes be written, as far as access and length tell? For refusing a long transfer at its
 * start.
 * Returns TUMBLE_ABORT_NONE, TUMBLE_ABORT_READ_ONLY, TUMBLE_ABORT_TOO_LONG, TUMBLE_ABORT_TOO_SHORT. */
tumble_abort_t tumble_dictionary_accepts(const tumble_entry_t *entry, uint32_t size);

#endif
