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

/* The noise that a run shows, 248 bytes. The board lends it beside the stand that it declares; tumble_navcomp_init clears
 * it. Private, but for what tumble_navcomp_noise tells. A position that is measured again counts again; after a loss of
 * power only the positions measured since then count, and the scatter of all. */
typedef struct tumble_run_noise {
    tumble_blocks_t blocks;
    tumble_noise_t seen;
    tumble_status_t status; /* of the look; TUMBLE_OK: `seen` is of this run */
    bool looked;            /* since the last sample */
} tumble_run_noise_t;

/* The stand as declared, const data of the board. */
typedef struct tumble_declared {
    const tumble_stand_record_t *stand; /* its `samples` are not looked at: the run knows them */

    /* tumble_navcomp_take_noise and memory for it: the uncertainties count the noise that a run shows, where it is more
     * than declared. Both null: the declared noise is believed. */
    void (*take)(const tumble_navcomp_t *navcomp, tumble_taken_t taken, const tumble_block_sample_t *sample);
    tumble_run_noise_t *noise;
} tumble_declared_t;

/* A sample that went into a mean: for `take`, and for nothing else. Integers alone. */
void tumble_navcomp_take_noise(const tumble_navcomp_t *navcomp, tumble_taken_t taken,
                               const tumble_block_sample_t *sample);

/* For this room: look at the noise of the present result, which takes as long as one uncertainty. False: that has been
 * done, or there is no memory for it. */
bool tumble_navcomp_estimate_noise(const tumble_navcomp_t *navcomp);

/* For this room: fill in schedule and stand, and of the present result the numbers of samples, for which `samples` is
 * memory, and the noise. There is a result, and a stand is declared. Returns TUMBLE_OK, TUMBLE_E_DEVIATION. */
tumble_status_t tumble_navcomp_judged_run(const tumble_navcomp_t *navcomp, uint32_t samples[TUMBLE_MAX_POSITIONS],
                                          tumble_judged_run_t *run);

#define TUMBLE_ALL_COEFFICIENTS 0x0FFFU

/* Standard uncertainties of the present result, for the configured estimator. Ask before another estimator is written
 * for the next run. `coefficients`: bits of those that this call computes (0 to 11: K row by row, then U0); the others
 * are left as they are. All twelve take a Cortex-M4 without floating point hardware 0.7 million instructions
 * (`refined`) to 1.2 million (`least_squares`) for 18 positions: a control loop computes one in each step, beginning
 * with coefficient 0, the only one with which a gain record is checked. `uncertainty` is written on TUMBLE_OK, and set
 * to zero on TUMBLE_E_NOT_FINITE.
 * Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY (the noise of the run has been looked at, and nothing else: ask again; only with
 * memory for it, and only the first time), TUMBLE_E_STATE (no result), TUMBLE_E_ARGUMENT (null; nothing declared; no
 * coefficient; a number out of range; an estimator that the board lends without it), TUMBLE_E_DEVIATION (the samples scatter beyond all measure), or as the
 * estimator's function in tumble/core.h. */
tumble_status_t tumble_navcomp_uncertainty(const tumble_navcomp_t *navcomp, uint16_t coefficients,
                                           tumble_uncertainty_t *uncertainty);

/* The standard uncertainty, g, of the length of the specific force that the calibrated block shows at an attitude, a unit
 * vector on its axes. Ask for coefficient 0 first; each takes as long as three or four coefficients. Returns likewise. */
tumble_status_t tumble_navcomp_norm(const tumble_navcomp_t *navcomp, const double attitude[3], double *norm_g);

/* The noise that these uncertainties count, valid until the next sample is averaged.
 * Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY (the uncertainties have not been asked for), TUMBLE_E_STATE (no result, or no
 * memory for it), TUMBLE_E_TOO_FEW (one sample a position shows none: the declared noise counts), TUMBLE_E_DEVIATION. */
tumble_status_t tumble_navcomp_noise(const tumble_navcomp_t *navcomp, const tumble_noise_t **noise);

#endif
