/* closure.h - which two positions of a mounting have one attitude; private to the firmware. */
#ifndef TUMBLE_CORE_CLOSURE_H
#define TUMBLE_CORE_CLOSURE_H

#include "tumble/core.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint8_t early; /* indices in the schedule */
    uint8_t late;
} tumble_closure_pair_t;

/* The pair that tumble_closure compares. With `measured` (may be null) only measured positions count. False: the mounting
 * has none. */
bool tumble_closure_find(const tumble_schedule_t *schedule, const bool *measured, uint8_t mounting,
                         tumble_closure_pair_t *pair);

#endif
