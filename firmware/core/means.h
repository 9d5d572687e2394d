/* means.h - what every estimator asks of the means before it computes (private to the core). */
#ifndef TUMBLE_CORE_MEANS_H
#define TUMBLE_CORE_MEANS_H

#include "tumble/core.h"

#include <stdbool.h>

/* Is there all an estimator needs, and every measured mean a number of at most TUMBLE_MAX_MEAN_V? Returns TUMBLE_OK,
 * TUMBLE_E_ARGUMENT (a null), TUMBLE_E_NOT_FINITE. */
tumble_status_t tumble_means_check(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                   const tumble_coefficients_t *coefficients);

/* Is every fit position measured? */
bool tumble_means_are_complete(const tumble_schedule_t *schedule, const tumble_means_t *means);

/* Number of fit positions of a schedule. */
uint8_t tumble_means_fit_positions(const tumble_schedule_t *schedule);

#endif
