/* stand_seen.h - what a run tells about the stand itself: its angles, the error of a set angle, the noise.
 *
 * Two ways to the angles. The closed form takes the paper's positions: with the biases and the sensitivities to x that
 * each mounting gives by itself, v = K^-1 (U1_0 - U2_0) and w = K^-1 (K2_x - K1_x),
 *
 *     alpha1 = (v_y - v_z) / 2,    w_y = alpha2 + alpha3 of mounting 1,    w_z = alpha2 + alpha3 of mounting 2.
 *
 * The fit takes any schedule: generalised least squares for coefficients and angles together, in which the error of a
 * set angle counts for what it is, an error of three outputs at once along one direction. It is the best there is, up
 * to six times sharper, and it alone gives alpha4 (docs/method.md, "the stand seen"). Only measured fit positions are
 * looked at. Pure functions; no libm but the square root, nothing allocated, nothing kept.
 */
#ifndef TUMBLE_CORE_STAND_SEEN_H
#define TUMBLE_CORE_STAND_SEEN_H

#include "core/calibration.h"
#include "core/estimator.h"
#include "core/limits.h"
#include "core/schedule.h"
#include "core/status.h"

#include <stdbool.h>
#include <stdint.h>

/* One quantity with its standard uncertainty. What a run cannot tell is not known, and its numbers are 0. */
typedef struct {
    double value;
    double u;
    bool known;
} tumble_seen_t;

/* Angles of the stand, rad. */
typedef struct {
    tumble_seen_t alpha1;             /* the axis is not level */
    tumble_seen_t alpha2_plus_alpha3; /* zero of the table angle, and mean yaw of all mountings */
    tumble_seen_t alpha3_difference;  /* yaw in the first mounting less that in the second */
} tumble_seen_angles_t;             /* mountings: those with measured fit positions, in the schedule's order */

/* The random errors that the uncertainties come from. */
typedef struct {
    double angle_rad;                                /* alpha4, standard deviation; 0 or more, finite */
    double mean_variance_v2[TUMBLE_MAX_POSITIONS];   /* noise of the mean of a channel; 0 or more, finite */
} tumble_random_errors_t;

/* Unknowns of the fit at most: coefficients, alpha1, alpha3 per mounting, alpha2; and room for them. */
#define TUMBLE_FIT_UNKNOWNS (TUMBLE_COEFFICIENTS + 2 + TUMBLE_MAX_MOUNTINGS)

/* Working memory of the fit, 2 kB. The caller owns it; its content is of no use to anybody. */
typedef struct {
    double r[(TUMBLE_FIT_UNKNOWNS * (TUMBLE_FIT_UNKNOWNS + 3)) / 2]; /* upper triangle and right sides, by rows */
    double row[TUMBLE_FIT_UNKNOWNS + 1];
    double residual_square;
    double scale_v;     /* largest element of K */
    double smallest_v2; /* noise variance that weights are relative to, in units of scale_v */
    double angle_square;
    uint8_t unknowns;
} tumble_fit_work_t;

/* Standard deviation of one sample, pooled over positions and channels, from the number of samples and the scatter of
 * each position (n - 1; not read below two samples). Unit as the scatter. Not known without any scatter. */
tumble_seen_t tumble_seen_noise(const uint32_t *samples, const double (*scatter)[TUMBLE_CHANNELS], uint8_t positions);

/* The angles by the closed form. `errors` as declared, or as seen; null: uncertainties are 0.
 * Returns TUMBLE_OK, _ARGUMENT, _NOT_HARMONIC, _MISSING_POSITION. */
tumble_status_t tumble_seen_angles(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                   const tumble_calibration_t *calibration, const tumble_random_errors_t *errors,
                                   tumble_seen_angles_t *angles);

/* The angles by the fit, linearised at `coefficients` (any estimate of them) and an ideal stand; errors of second order
 * in the angles remain. Returns TUMBLE_OK, _ARGUMENT. */
tumble_status_t tumble_seen_fit(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                const tumble_coefficients_t *coefficients, const tumble_random_errors_t *errors,
                                tumble_fit_work_t *work, tumble_seen_angles_t *angles);

/* alpha4 from the run itself: what the residuals hold beyond the noise (`errors->angle_rad` is not read). The weighted
 * residuals that errors of set angles move, m of them, are as large as they should be when their squares sum up to m
 * (Paule and Mandel). `freedom` receives the degrees of freedom of the estimate: m without noise, less with it.
 * Not known where m is 0, or where the residuals do not exceed the noise. Returns TUMBLE_OK, _ARGUMENT. */
tumble_status_t tumble_seen_angle_error(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                        const tumble_coefficients_t *coefficients,
                                        const tumble_random_errors_t *errors, tumble_fit_work_t *work,
                                        tumble_seen_t *alpha4, double *freedom);

/* How large those squares are if alpha4 were `errors->angle_rad`: chi-squared with `freedom` = m degrees of freedom
 * where that is the truth. Returns TUMBLE_OK, _ARGUMENT. */
tumble_status_t tumble_seen_angle_chi_squared(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                              const tumble_coefficients_t *coefficients,
                                              const tumble_random_errors_t *errors, tumble_fit_work_t *work,
                                              double *chi_squared, uint8_t *freedom);

#endif
