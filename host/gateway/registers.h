/* registers.h - which objects of the node become which Modbus registers; the table is generated (registers.c). */
#ifndef TUMBLE_GATEWAY_REGISTERS_H
#define TUMBLE_GATEWAY_REGISTERS_H

#include "register_map.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    GATEWAY_FORM_WORD,   /* an integer of at most 16 bits, sign-extended, in one register */
    GATEWAY_FORM_LONG,   /* 32 bits in two */
    GATEWAY_FORM_QUAD,   /* 64 bits in four */
    GATEWAY_FORM_FLOAT,  /* REAL32 or REAL64 as REAL32 in two */
    GATEWAY_FORM_SCALED, /* REAL32 or REAL64 as an i32 of `scale` each, in two */
    GATEWAY_FORM_TEXT    /* two characters in each */
} gateway_form_t;

/* An object of the node as a value in input registers. */
typedef struct {
    uint16_t at; /* its first register */
    uint8_t words;
    uint8_t form;
    uint16_t validity; /* the register that says in bit `bit` whether the value is there */
    uint8_t bit;
    uint16_t index;
    uint8_t subindex;
    uint8_t type; /* TUMBLE_TYPE_... */
    uint8_t size; /* bytes of the object; of a text the most it may have */
    bool kept;    /* read anew only when a mark has changed, and now and then */
    double scale; /* of GATEWAY_FORM_SCALED */
} gateway_value_t;

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t type;
    uint8_t size;
} gateway_object_t;

/* Values of one object stand together. */
extern const gateway_value_t gateway_values[GATEWAY_VALUES];

/* Objects whose change tells that the results, and all that is kept, are others. */
extern const gateway_object_t gateway_marks[GATEWAY_MARKS];

/* Indices of the command objects, by the number that Modbus has for them: argument at subindex 1, command at 2, angle
 * at 3. */
extern const uint16_t gateway_command_objects[GATEWAY_COMMAND_OBJECTS];

#endif
