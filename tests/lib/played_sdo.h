/* played_sdo.h - the SDO servers of a node that a test plays: objects that are read and written, expedited or in segments,
 * through the server that is asked. */
#ifndef TUMBLE_TESTS_PLAYED_SDO_H
#define TUMBLE_TESTS_PLAYED_SDO_H

#include "canopen/sdo.h"

#include <stdbool.h>
#include <stdint.h>

#define PLAYED_OBJECTS 512U
#define PLAYED_BYTES 64U

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size; /* 0: there is nothing to be read */
    uint8_t bytes[PLAYED_BYTES];
} played_object_t;

typedef struct {
    uint8_t node;
    void (*send)(const tumble_can_frame_t *frame);
    /* Before an object is read (may be null) or written: the abort code of a refusal, or 0. */
    uint32_t (*may_read)(uint16_t index, uint8_t subindex);
    uint32_t (*may_write)(uint16_t index, uint8_t subindex);
    /* It is `written` now. False: the answer goes with played_sdo_acknowledge. */
    bool (*on_write)(void);
    bool silent;
    bool has_one_server; /* the second one does not answer */
    bool is_second;      /* the one that was asked last */
    played_object_t objects[PLAYED_OBJECTS];
    unsigned count;
    played_object_t upload; /* under way */
    unsigned sent;
    played_object_t written;
    uint8_t acknowledgement[8];
} played_sdo_t;

/* The object, or null. */
played_object_t *played_sdo_find(played_sdo_t *self, uint16_t index, uint8_t subindex);

/* From now on the object has these bytes; 0 of them: it is refused with 0800 0024h, as all that were never given. */
void played_sdo_give(played_sdo_t *self, uint16_t index, uint8_t subindex, const uint8_t *bytes, uint8_t size);

/* A frame has come. False: it is none to a server of this node. */
bool played_sdo_receive(played_sdo_t *self, const tumble_can_frame_t *frame);

void played_sdo_acknowledge(const played_sdo_t *self);

#endif
