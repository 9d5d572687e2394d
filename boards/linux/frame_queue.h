/* frame_queue.h - frames that wait, first in, first out; what finds no room is counted. */
#ifndef TUMBLE_LINUX_FRAME_QUEUE_H
#define TUMBLE_LINUX_FRAME_QUEUE_H

#include "tumble/port.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FRAME_QUEUE_DEPTH 16384U /* of 8-byte frames: four seconds of a full bus */

typedef struct {
    tumble_can_frame_t frames[FRAME_QUEUE_DEPTH];
    uint32_t first;
    uint32_t count;
    uint64_t overflow;
} frame_queue_t;

_Static_assert((FRAME_QUEUE_DEPTH & (FRAME_QUEUE_DEPTH - 1U)) == 0U, "a power of two");

static inline void frame_queue_put(frame_queue_t *queue, const tumble_can_frame_t *frame)
{
    if (queue->count == FRAME_QUEUE_DEPTH) {
        queue->overflow++;
        return;
    }
    queue->frames[(queue->first + queue->count++) % FRAME_QUEUE_DEPTH] = *frame;
}

/* The oldest, or null. */
static inline const tumble_can_frame_t *frame_queue_peek(const frame_queue_t *queue)
{
    return (queue->count > 0U) ? &queue->frames[queue->first] : NULL;
}

/* Take the oldest away; there is one. */
static inline void frame_queue_pop(frame_queue_t *queue)
{
    queue->first = (queue->first + 1U) % FRAME_QUEUE_DEPTH;
    queue->count--;
}

#endif
