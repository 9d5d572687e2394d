/* pdo.h - process data (CiA 301, 7.2.2): receive and transmit PDOs with mapping that can be written.
 *
 * Event-driven transmission (types 254 and 255), with inhibit time and event timer. The synchronous types and those on
 * remote request are refused with TUMBLE_ABORT_VALUE. A mapping is kept as places in the dictionary's table, so that a
 * PDO is filled and taken apart without a search.
 *
 * Writing order, by SDO or by the functions here: disable (bit 31 of the COB-ID), number of mapped objects 0, the
 * objects, their number, enable. Anything else is refused, and a refused write changes nothing.
 */
#ifndef TUMBLE_CANOPEN_PDO_H
#define TUMBLE_CANOPEN_PDO_H

#include "canopen/dictionary.h"
#include "canopen/link.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_MAX_RECEIVE_PDOS 2
#define TUMBLE_MAX_TRANSMIT_PDOS 5
#define TUMBLE_MAX_MAPPED 8

#define TUMBLE_PDO_INVALID 0x80000000U /* bit 31 of a COB-ID: the PDO does not exist */
#define TUMBLE_PDO_NO_RTR 0x40000000U  /* bit 30 of a transmit COB-ID: not on remote request; always so here */
#define TUMBLE_PDO_EVENT_MAKER 254U
#define TUMBLE_PDO_EVENT_PROFILE 255U

/* An object in a mapping, as 1600h and 1A00h hold it. */
#define TUMBLE_MAP(index, subindex, bits) (((uint32_t)(index) << 16) | ((uint32_t)(subindex) << 8) | (uint32_t)(bits))

/* All that is to be known about one PDO: the defaults of a node, or a drive profile's wishes. In a node's defaults an
 * identifier in use whose low seven bits are zero gets the node's number added (180h, 200h, ... predefined). */
typedef struct {
    uint32_t cob_id;        /* with the bits above */
    uint8_t type;           /* transmission type */
    uint8_t count;          /* mapped objects, 0 to TUMBLE_MAX_MAPPED */
    uint16_t inhibit_100us; /* transmit only */
    uint16_t event_ms;      /* transmit only; 0: no event timer */
    uint32_t map[TUMBLE_MAX_MAPPED];
} tumble_pdo_setup_t;

/* A value for an object: 1, 2 or 4 bytes. */
typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint32_t value;
} tumble_object_write_t;

/* What both directions have. `place` and `subindex` tell the mapped objects (tumble_dictionary_entry); the bits of
 * `written` say which of them are set, in use or not. */
typedef struct {
    uint32_t cob_id;
    uint8_t place[TUMBLE_MAX_MAPPED];
    uint8_t subindex[TUMBLE_MAX_MAPPED];
    uint8_t written;
    uint8_t count;  /* mapped objects in use; 0: mapping disabled */
    uint8_t length; /* bytes of the mapped objects */
    uint8_t type;   /* transmission type */
    bool fault;     /* receive: the last frame was too short */
    bool due;       /* transmit: to be sent */
} tumble_pdo_t;

typedef struct {
    tumble_pdo_t pdo;
    uint16_t inhibit_100us;
    uint16_t event_ms;
    uint64_t earliest_us; /* inhibit time: not before */
    uint64_t event_us;    /* event timer: not later; TUMBLE_NEVER: does not run */
} tumble_transmit_pdo_t;

typedef struct {
    tumble_pdo_t receive[TUMBLE_MAX_RECEIVE_PDOS];
    tumble_transmit_pdo_t transmit[TUMBLE_MAX_TRANSMIT_PDOS];
    uint16_t too_short; /* receive PDOs dropped: fewer bytes than mapped */
    uint16_t refused;   /* values of receive PDOs that the dictionary refused (limits, hook) */
} tumble_pdos_t;

typedef enum { TUMBLE_PDO_RECEIVE = 0, TUMBLE_PDO_TRANSMIT } tumble_pdo_direction_t;

/* What became of a received frame. */
typedef enum {
    TUMBLE_PDO_NOT_MINE = 0,
    TUMBLE_PDO_TAKEN,
    TUMBLE_PDO_TOO_SHORT /* fewer bytes than mapped: nothing was written; further bytes than mapped do no harm */
} tumble_pdo_outcome_t;

/* All PDOs invalid and without mapping, of type TUMBLE_PDO_EVENT_PROFILE. */
void tumble_pdo_init(tumble_pdos_t *pdos);

/* Setting up a PDO, ours or another node's, takes so many steps, in the order above. What a step writes into the
 * objects of the PDO with the communication parameter `index`; size 0: nothing. */
#define TUMBLE_PDO_SETUP_STEPS (TUMBLE_MAX_MAPPED + 7U)
void tumble_pdo_setup_write(const tumble_pdo_setup_t *setup, uint16_t index, uint8_t step,
                            tumble_object_write_t *write);

/* Does a step leave its value for good, and one that both ends must agree on: identifier, mapping? */
bool tumble_pdo_setup_stays(uint8_t step);

/* Set up the PDO `number` (0 is 1400h / 1800h) at once, in the order above: what was there before is gone. On a refusal
 * the PDO is left invalid.
 * Returns TUMBLE_ABORT_NONE or the reason, as from SDO; TUMBLE_ABORT_NO_OBJECT for a number that does not exist. */
tumble_abort_t tumble_pdo_configure(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary,
                                    tumble_pdo_direction_t direction, uint8_t number, const tumble_pdo_setup_t *setup);

/* Read and write the communication parameters (1400h.., 1800h..) and mappings (1600h.., 1A00h..). Both return
 * TUMBLE_ABORT_NONE or a refusal: TUMBLE_ABORT_NO_OBJECT (mapping of an object that does not exist, a PDO that does not
 * exist), TUMBLE_ABORT_NO_SUBINDEX, TUMBLE_ABORT_READ_ONLY, TUMBLE_ABORT_NOT_MAPPABLE (direction, access, bits that are
 * not the object's), TUMBLE_ABORT_MAP_LENGTH (over 8 bytes), TUMBLE_ABORT_VALUE (identifier reserved by CiA 301,
 * 29-bit, transmission type), TUMBLE_ABORT_DEVICE_STATE (the PDO must be disabled first, or its mapping). */
tumble_abort_t tumble_pdo_read_parameter(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary, uint16_t index,
                                         uint8_t subindex, uint32_t *value);
tumble_abort_t tumble_pdo_write_parameter(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary, uint16_t index,
                                          uint8_t subindex, uint32_t value);

/* Ask for transmit PDO `number`: it goes at the next step at which it exists and its inhibit time is over, with the
 * values of that moment. Numbers beyond the last are ignored. */
void tumble_pdo_trigger(tumble_pdos_t *pdos, uint8_t number);

/* Take a frame in (NMT state Operational): its values go through tumble_dictionary_write one by one. `number` (may be
 * null) receives which PDO it was. */
tumble_pdo_outcome_t tumble_pdo_receive(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary,
                                        const tumble_can_frame_t *frame, uint8_t *number);

/* Send what is due (NMT state Operational). */
void tumble_pdo_step(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary, tumble_link_t *link, uint64_t now_us);

/* Entering Operational: every transmit PDO is due once, as it is when it is enabled. */
void tumble_pdo_start(tumble_pdos_t *pdos);

/* Did the last frame of any receive PDO fall short? */
bool tumble_pdo_any_fault(const tumble_pdos_t *pdos);

/* The next moment at which step has something to do; one that is over: at once (also when the port was busy). */
uint64_t tumble_pdo_next_us(const tumble_pdos_t *pdos);

#endif
