/* uncertainty.h - the standard uncertainties that the navigation computer itself states of its result.
 *
 * Computed when asked for, from what the board declares of its stand; nothing is kept, and a board that never asks does
 * not link it. Not served over CAN.
 */
#ifndef TUMBLE_NAVCOMP_UNCERTAINTY_H
#define TUMBLE_NAVCOMP_UNCERTAINTY_H

#include "core/uncertainty.h"
#include "navcomp/navcomp.h"

/* The stand as declared, const data of the board. */
typedef struct tumble_declared {
    const tumble_stand_record_t *stand; /* its `samples` are not looked at: the run knows them */

    /* Of TUMBLE_ESTIMATE_OPTIMAL: tumble_optimal_uncertainty of core/optimal_uncertainty.h; else may be null. */
    tumble_status_t (*weighted)(const void *source, const tumble_judged_run_t *run,
                                tumble_uncertainty_t *uncertainty);
} tumble_declared_t;

/* Of the result at hand, for the estimator that is configured: before another one is written for the next run. On a
 * Cortex-M4 without floating point hardware it takes 0.7 million instructions (`refined`) to 1.2 million
 * (`least_squares`) for 18 positions: no business of a control loop. `uncertainty` is written on TUMBLE_OK, and set to
 * zero on _NOT_FINITE.
 * Returns TUMBLE_OK, TUMBLE_E_STATE (no result), _ARGUMENT (null; nothing declared; a number out of range), or as the
 * function of core/uncertainty.h or core/optimal_uncertainty.h. */
tumble_status_t tumble_navcomp_uncertainty(const tumble_navcomp_t *navcomp, tumble_uncertainty_t *uncertainty);

#endif
