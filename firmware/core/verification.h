/* verification.h - is a calibration to be believed? The gravity check, closure and residuals.
 *
 * Pure functions; nothing allocated, nothing kept. Only measured positions are looked at.
 */
#ifndef TUMBLE_CORE_VERIFICATION_H
#define TUMBLE_CORE_VERIFICATION_H

#include "core/calibration.h"
#include "core/estimator.h"
#include "core/limits.h"
#include "core/schedule.h"
#include "core/status.h"

#include <stdbool.h>
#include <stdint.h>

/* The gravity check, formula (8): at every position the calibrated block must find a specific force of 1 g,
 *     delta_g = (|a|^2 - 1) / 2,     a = K^-1 (U - U0).
 * On fit positions it is optimistic, so check positions are kept apart. */
typedef struct {
    double delta_g_g[TUMBLE_MAX_POSITIONS]; /* 0 where not measured */
    double max_abs_fit_g;                   /* 0 when no fit position is measured */
    double max_abs_check_g;                 /* 0 when no check position is measured */
    uint8_t fit_positions;                  /* how many of each were judged */
    uint8_t check_positions;
    bool pass;                              /* both maxima at most the limit, and something was judged */
} tumble_gravity_check_t;

/* Judge a run by a limit (g), finite and above 0. Returns TUMBLE_OK (whatever the verdict), _ARGUMENT, or _NOT_FINITE
 * (then `check` is all zero and does not pass). */
tumble_status_t tumble_gravity_check(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                     const tumble_calibration_t *calibration, double limit_g,
                                     tumble_gravity_check_t *check);

/* Closure: the outputs at the last measured position of a mounting whose attitude equals that of an earlier one, less
 * those at the earliest such one (in the paper's schedule U9 - U1): drift, slip of the table, or a block that moved.
 * `mounting` is the mounting's number. Returns TUMBLE_OK, _ARGUMENT, or TUMBLE_E_MISSING_POSITION when the mounting has
 * no such pair. */
tumble_status_t tumble_closure(const tumble_schedule_t *schedule, const tumble_means_t *means, uint8_t mounting,
                               double difference_v[TUMBLE_CHANNELS]);

/* Residual (V) of the position at `index`: U - U0 - K a on the ideal geometry. `index` below position_count. */
void tumble_residual(const tumble_schedule_t *schedule, const tumble_means_t *means,
                     const tumble_coefficients_t *coefficients, uint8_t index, double residual_v[TUMBLE_CHANNELS]);

/* Root mean square of the residuals of the measured fit positions, per channel, over n - 4 degrees of freedom.
 * Returns TUMBLE_OK, _ARGUMENT, or TUMBLE_E_TOO_FEW with fewer than five measured fit positions. */
tumble_status_t tumble_residual_rms(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                    const tumble_coefficients_t *coefficients, double rms_v[TUMBLE_CHANNELS]);

#endif
