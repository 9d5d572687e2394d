/* misfit.h - does a run fit the stand that is declared? A chi-squared test of every mounting, taken in small steps.
 *
 * In one mounting the specific force turns on a circle, so every channel is
 *
 *     U(phi) = b + s sin phi + c cos phi
 *
 * whatever K and U0 are, and whatever the systematic errors of the stand (alpha1, alpha2, the yaw alpha3, a known tilt):
 * each of them changes b, s and c alone. What is left of a generalised least-squares fit of these nine numbers comes from
 * the errors of the set angles and from the noise of the means, and from what nobody declared: steps, drift, slip,
 * curvature of the block. With V = v I + alpha4^2 d d^T the covariance of the three means at a position (d: how the outputs
 * answer to its angle), the sum of r^T V^-1 r is chi-squared with 3 (n - 3) degrees of freedom.
 *
 * A fault of one channel drowns in the sum over three. So each channel is judged again, given the other two: the sum less
 * the sum without that channel is chi-squared with n - 3 degrees of freedom. Hence four tests a mounting. Each fails an
 * honest run in TUMBLE_MISFIT_CHANCE of cases, so that all tests of TUMBLE_MAX_MOUNTINGS together stay below 1e-3.
 *
 * What two mountings say about each other is not looked at: a step between them, and a tilt of the seat, pass.
 *
 * Every measured position counts, also one that is for checks alone. A mounting with fewer than four positions cannot
 * be judged, and passes. Pure but for the caller's working memory; nothing allocated. No libm but the square root.
 */
#ifndef TUMBLE_CORE_MISFIT_H
#define TUMBLE_CORE_MISFIT_H

#include "core/averaging.h"
#include "core/estimator.h"
#include "core/limits.h"
#include "core/schedule.h"
#include "core/uncertainty.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_MISFIT_UNKNOWNS 9 /* b, s and c of three channels */
#define TUMBLE_MISFIT_TESTS 4    /* of a mounting: all channels, and each given the others */
#define TUMBLE_MISFIT_SIGMAS 4.0 /* one-sided quantile of the normal distribution that the limit is taken at */
#define TUMBLE_MISFIT_CHANCE 3.2e-5

static_assert((TUMBLE_MISFIT_TESTS * TUMBLE_MAX_MOUNTINGS * TUMBLE_MISFIT_CHANCE) < 1e-3,
              "an honest run must be doubted in less than one case of a thousand");

/* The run and its stand. All must stay as they are from the first step to the last. */
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_averaging_t *averaging;       /* its finished positions */
    const tumble_coefficients_t *coefficients; /* any estimate: residuals are taken from it before they are fitted */
    const tumble_stand_record_t *stand;        /* angle_rad, noise_v and least_noise_v count; checked by its owner */
    double v_per_count;
} tumble_misfit_run_t;

/* Working memory, 0.5 kB. The caller owns it; all of it is private. */
typedef struct {
    double triangle[(TUMBLE_MISFIT_UNKNOWNS * (TUMBLE_MISFIT_UNKNOWNS + 1)) / 2]; /* lower, by rows */
    double right[TUMBLE_MISFIT_UNKNOWNS];
    double square;     /* of the whitened residuals */
    double all_square; /* what the fit of all three channels left, */
    uint8_t all_freedom;
    uint8_t counted;   /* means in the sums */
    uint8_t mounting;  /* index in the schedule */
    uint8_t test;      /* 0: all channels; else all but channel test - 1 */
    uint8_t position;  /* the next to be looked at */
    bool misfit;       /* some test has failed */
} tumble_misfit_work_t;

/* Begin. */
void tumble_misfit_begin(tumble_misfit_work_t *work);

/* Go on: one position, or the end of one test; some 20,000 instructions on a Cortex-M4 without floating point hardware.
 * Returns true as long as there is more to do. */
bool tumble_misfit_step(tumble_misfit_work_t *work, const tumble_misfit_run_t *run);

/* The largest chi-squared of an honest run, by Wilson and Hilferty (1931): k (1 - 2/(9 k) + z sqrt(2/(9 k)))^3 with
 * z = TUMBLE_MISFIT_SIGMAS: never below the true quantile, and above it by 9 % (1 degree), 2.4 % (6), 0.8 % (18). */
double tumble_misfit_limit(int freedom);

#endif
