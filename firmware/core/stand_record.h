/* stand_record.h - is what a board declares of its stand in range? (private to the core) */
#ifndef TUMBLE_CORE_STAND_RECORD_H
#define TUMBLE_CORE_STAND_RECORD_H

#include "tumble/core.h"

#include <stdbool.h>

/* Standard deviations from 0 to the largest that tumble/core.h allows, and at least one sample. */
bool tumble_stand_record_is_valid(const tumble_stand_record_t *stand);

#endif
