/* means.h - what every estimator asks of the means before it computes (private to the core). */
#ifndef TUMBLE_CORE_MEANS_H
#define TUMBLE_CORE_MEANS_H

#include "tumble/core.h"

#include <stdbool.h>

/* Is every measured mean a number of at most TUMBLE_MAX_MEAN_V? */
bool tumble_means_are_numbers(const tumble_schedule_t *schedule, const tumble_means_t *means);

/* Is every fit position measured? */
bool tumble_means_are_complete(const tumble_schedule_t *schedule, const tumble_means_t *means);

/* Number of fit positions of a schedule. */
uint8_t tumble_means_fit_positions(const tumble_schedule_t *schedule);

#endif
