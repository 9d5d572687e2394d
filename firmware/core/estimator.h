/* estimator.h - from position means to the twelve coefficients of U = U0 + K a.
 *
 * K in volts per g (unit of the means per unit of local gravity), U0 in volts. Pure functions: nothing allocated,
 * nothing kept. Outputs are written only on TUMBLE_OK. The formulas are exact for an ideal stand, to rounding; every
 * position counts as one mean whatever its number of samples. A measured mean that is not a number, or beyond
 * TUMBLE_MAX_MEAN_V, is TUMBLE_E_NOT_FINITE, so no result can overflow.
 *
 * Source: Chernyak, Rybak, Paliushok, "Ensuring the given accuracy of calibrating a three-axis block of navigation
 * accelerometers on a single-axis rotary stand": formulas (3) and (7); s and b follow from the same harmonic pattern.
 */
#ifndef TUMBLE_CORE_ESTIMATOR_H
#define TUMBLE_CORE_ESTIMATOR_H

#include "core/limits.h"
#include "core/schedule.h"
#include "core/status.h"

#include <stdint.h>

#define TUMBLE_MAX_MEAN_V 1e100

typedef struct {
    double k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS]; /* [i][j]: response of channel i to acceleration along j */
    double u0_v[TUMBLE_CHANNELS];
} tumble_coefficients_t;

/* Which positions or coefficients made an estimator refuse; bits as in schedule.h. Zero when they do not apply. */
typedef struct {
    uint32_t missing;
    uint8_t unidentified;
} tumble_refusal_t;

/* `averaged`: what both mountings tell is averaged: K_ix = (K1_ix + K2_ix)/2, U0_i = (U1_0i + U2_0i)/2.
 * Returns TUMBLE_OK, _ARGUMENT, _NOT_HARMONIC, _MISSING_POSITION (then refusal->missing), _NOT_FINITE.
 * `refusal` may be null. */
tumble_status_t tumble_estimate_averaged(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                         tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

/* `refined`, formula (7): as averaged, but K_yx from mounting 2 and K_zx from mounting 1, which keeps the yaw of the
 * block on the platform out of them. Returns as tumble_estimate_averaged. */
tumble_status_t tumble_estimate_refined(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                        tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

/* `least_squares`: ordinary least squares of the measured fit positions on the ideal geometry, any schedule. Solves the
 * four-unknown normal matrix that the three channels share, then corrects the solution once from its residuals
 * (corrected seminormal equations), so the error grows with the condition of the design, not with its square.
 * Returns TUMBLE_OK, _ARGUMENT, _RANK (then refusal->unidentified), _NOT_FINITE. */
tumble_status_t tumble_estimate_least_squares(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                              tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

#define TUMBLE_MAX_GAIN 1e100

/* A constant gain table: twelve rows (K row by row, then U0), in each one gain per fit position of the schedule and
 * channel, in the schedule's order, the channel running fastest. Gains of K in 1/g, of U0 dimensionless. */
typedef struct {
    const double *gains;  /* TUMBLE_COEFFICIENTS x (3 x fit_positions) */
    uint8_t fit_positions;
} tumble_gain_table_t;

/* Any estimator that is linear in the means, from its gain table. All fit positions must be measured.
 * Returns TUMBLE_OK, _ARGUMENT, _GAIN_TABLE (wrong number of fit positions, or a gain that is not a number or beyond
 * TUMBLE_MAX_GAIN), _MISSING_POSITION, _NOT_FINITE. */
tumble_status_t tumble_estimate_gains(const tumble_gain_table_t *table, const tumble_schedule_t *schedule,
                                      const tumble_means_t *means, tumble_coefficients_t *coefficients);

#endif
