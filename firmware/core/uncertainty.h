/* uncertainty.h - how far the twelve coefficients may be from the truth, from what the stand is declared to be.
 *
 * An estimate is linear in the means, so its standard uncertainty follows exactly to first order from the estimator's
 * gains and from the derivatives of the specific force by each error of the stand, taken at zero error on the exact
 * geometry, the known tilt of the axis included (docs/method.md, "Uncertainty"). Independent errors add in quadrature.
 * The gains are computed row by row as they are needed: no table, no matrix. Pure functions; nothing allocated,
 * nothing kept.
 *
 * Some 80 double operations for each of the twelve coefficients and each position, by least squares twice as many.
 */
#ifndef TUMBLE_CORE_UNCERTAINTY_H
#define TUMBLE_CORE_UNCERTAINTY_H

#include "core/estimator.h"
#include "core/limits.h"
#include "core/schedule.h"
#include "core/status.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_MAX_STAND_SIGMA_RAD 1.0

/* What a stand is declared to be: standard deviations, 0 for an error that it does not have. */
typedef struct {
    double axis_tilt_rad; /* alpha1: the axis is not level; one for a run. Angles: 0 to TUMBLE_MAX_STAND_SIGMA_RAD */
    double level_rad;     /* alpha2: the zero of the table angle; one for a run */
    double remount_rad;   /* alpha3: yaw of the block on the platform; one for each mounting, or `common_yaw` */
    double angle_rad;     /* alpha4: of a set table angle; one for each position */
    double noise_v;       /* of one sample of one channel; 0 to TUMBLE_MAX_MEAN_V */
    double least_noise_v; /* of a mean, however many samples it has: it never counts as less; 0 to TUMBLE_MAX_MEAN_V */
    uint32_t samples;     /* in a mean, where the run does not say; at least 1 */
    bool common_yaw;      /* every mounting has the same yaw */
} tumble_stand_record_t;

/* The run whose estimate is judged. */
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_stand_record_t *stand;
    const tumble_coefficients_t *coefficients; /* the estimate; only its K matters */
    const bool *measured;                      /* one flag per position; null: all are measured */
    const uint32_t *samples;                   /* in the mean of each position, at least 1; null: the stand's */
    uint16_t only; /* bits of the coefficients (0 to 11: K row by row, then U0) to be judged now, so that all twelve can
                    * be judged in small steps; the others stay as they are. 0: all */
} tumble_judged_run_t;

/* Standard uncertainties, arranged and with units as in tumble_coefficients_t. */
typedef struct {
    double k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
    double u0_v[TUMBLE_CHANNELS];
} tumble_uncertainty_t;

/* Of an estimate by tumble_estimate_averaged, _refined, _least_squares; each uses, and refuses, the positions that its
 * estimator does. `refusal` may be null. `uncertainty` is written on TUMBLE_OK,
 * and set to zero on TUMBLE_E_NOT_FINITE.
 * Returns TUMBLE_OK; _ARGUMENT (null, or a number out of its range above); _NOT_FINITE (K is no number, or too large);
 * _NOT_HARMONIC, _MISSING_POSITION (refusal->missing) or _RANK (refusal->unidentified) as the estimator. */
tumble_status_t tumble_uncertainty_averaged(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                            tumble_refusal_t *refusal);
tumble_status_t tumble_uncertainty_refined(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                           tumble_refusal_t *refusal);
tumble_status_t tumble_uncertainty_least_squares(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                                 tumble_refusal_t *refusal);

/* Of an estimate by tumble_estimate_gains, or by the table of a gain record.
 * Returns TUMBLE_OK, _ARGUMENT, _NOT_FINITE, _GAIN_TABLE (for another number of fit positions), _MISSING_POSITION. */
tumble_status_t tumble_uncertainty_gains(const tumble_gain_table_t *table, const tumble_judged_run_t *run,
                                         tumble_uncertainty_t *uncertainty);

#endif
