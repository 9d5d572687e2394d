/* registers.h - which objects of the node become which Modbus registers (the table is generated: registers.c), how numbers
 * stand in registers (image.c), and what the gateway counts. */
#ifndef TUMBLE_GATEWAY_REGISTERS_H
#define TUMBLE_GATEWAY_REGISTERS_H

#include "canopen/link.h"
#include "register_map.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* An object of the node as a value in input registers: an integer in one register or as many as it has words, a number
 * of either precision as REAL32 in two, a text two characters in each. */
typedef struct {
    uint16_t at;       /* its first register */
    uint16_t validity; /* the register that says in bit `bit` whether the value is there */
    uint8_t bit;
    uint16_t index;
    uint8_t subindex;
    uint8_t type;       /* TUMBLE_TYPE_... */
    uint8_t size;       /* bytes of the object; of a text the most it may have */
    uint8_t group;      /* GATEWAY_GROUP_..., or one of those that have keys */
    uint8_t key;        /* its place among the keys, which are read in every poll; GATEWAY_KEYS: it is none */
    uint16_t scaled_at; /* a number once more, as an i32 of `scale` each, in two; 0: it is not */
    uint16_t scaled_validity;
    double scale;
} gateway_value_t;

/* Values of which each is one subindex, one bit and its own words further than the one before. */
typedef struct {
    uint8_t count;
    gateway_value_t first;
} gateway_value_run_t;

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t type;
    uint8_t size;
} gateway_object_t;

/* An object that may be written by the number that Modbus has for it. */
typedef struct {
    uint16_t number;
    uint16_t index;
    uint8_t subindex;
    uint8_t type;
    uint8_t size;
    uint8_t group; /* what changes with it */
    bool service;  /* the node takes it at service level only */
} gateway_target_t;

/* Settings of which each has the next number, and the next subindex. */
typedef struct {
    uint8_t count;
    gateway_target_t first;
} gateway_target_run_t;

/* When values are read: in every poll; when a mark has changed, and now and then; in groups from GATEWAY_GROUP_KEYED on
 * when a key of theirs or a mark has changed, a setting of theirs was written, and now and then. */
enum { GATEWAY_GROUP_ALWAYS = 0, GATEWAY_GROUP_KEPT, GATEWAY_GROUP_KEYED };

/* Those of a group that has keys stand together, its keys first. */
extern const gateway_value_run_t gateway_value_runs[];

/* The value of a place below GATEWAY_VALUES, in that order. */
gateway_value_t gateway_value(size_t place);

/* Registers of a value that is not scaled. */
uint8_t gateway_words_of(const gateway_value_t *value);

/* Objects that tell of others by a change: the marks, that the results, and all that is kept, are others; and the keys,
 * in the order in which they are read. */
extern const gateway_object_t gateway_tells[GATEWAY_MARKS + GATEWAY_KEYS];

/* Of each group the place of its key that selects what the others are of; GATEWAY_KEYS: it has none. */
extern const uint8_t gateway_selectors[GATEWAY_GROUPS];

/* In the order of their numbers. */
extern const gateway_target_run_t gateway_target_runs[GATEWAY_TARGET_RUNS];

/* Indices of the command objects, by the number that Modbus has for them: argument at subindex 1, command at 2, angle
 * at 3, the proposal's name at 4. */
extern const uint16_t gateway_command_objects[GATEWAY_COMMAND_OBJECTS];

/* Numbers in registers: big-endian, the high word first, packed by shifts. */
void gateway_put_u32(uint16_t *at, uint32_t value);
void gateway_put_f32(uint16_t *at, float value);

/* Put the value of an object, `size` little-endian bytes as SDO brings them, into its registers of `words`
 * (GATEWAY_INPUT_END of them, all 0 before) and set their bits of validity; none if the bytes are not as many as the
 * object has, or the number is not finite or beyond what the registers can say. */
void gateway_image_put(uint16_t *words, const gateway_value_t *value, const uint8_t *bytes, uint8_t size);

#endif
