/* uncertainty.h - the standard uncertainties that the navigation computer itself states of its result.
 *
 * Computed when asked for, from what the board declares of its stand; nothing is kept here, and a board that never asks
 * does not link it. The keeper asks once a result, coefficient by coefficient, and serves what it was told (2023h,
 * 2024h).
 */
#ifndef TUMBLE_NAVCOMP_UNCERTAINTY_H
#define TUMBLE_NAVCOMP_UNCERTAINTY_H

#include "tumble/core.h"
#include "tumble/navcomp.h"

/* The stand as declared, const data of the board. */
typedef struct tumble_declared {
    const tumble_stand_record_t *stand; /* its `samples` are not looked at: the run knows them */

    /* Of TUMBLE_ESTIMATE_OPTIMAL: tumble_optimal_uncertainty of tumble/core.h; else may be null. */
    tumble_status_t (*weighted)(const void *source, const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty);
} tumble_declared_t;

#define TUMBLE_ALL_COEFFICIENTS 0x0FFFU

/* Standard uncertainties of the present result, for the configured estimator. Ask before another estimator is written
 * for the next run. `coefficients`: bits of those that this call computes (0 to 11: K row by row, then U0); the others
 * are left as they are. All twelve take a Cortex-M4 without floating point hardware 0.7 million instructions
 * (`refined`) to 1.2 million (`least_squares`) for 18 positions: a control loop computes one in each step, beginning
 * with coefficient 0, the only one with which a gain record is checked. `uncertainty` is written on TUMBLE_OK, and set
 * to zero on TUMBLE_E_NOT_FINITE.
 * Returns TUMBLE_OK, TUMBLE_E_STATE (no result), TUMBLE_E_ARGUMENT (null; nothing declared; no coefficient; a number
 * out of range), or as the estimator's function in tumble/core.h. */
tumble_status_t tumble_navcomp_uncertainty(const tumble_navcomp_t *navcomp, uint16_t coefficients,
                                           tumble_uncertainty_t *uncertainty);

#endif
