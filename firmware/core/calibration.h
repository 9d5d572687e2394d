/* calibration.h - coefficients to specific force, and what is intrinsic to the block.
 *
 * Pure functions; nothing allocated, nothing kept.
 */
#ifndef TUMBLE_CORE_CALIBRATION_H
#define TUMBLE_CORE_CALIBRATION_H

#include "core/estimator.h"
#include "core/limits.h"
#include "core/status.h"

#include <stdint.h>

/* Coefficients turned round, ready to be applied: a = k_inverse (U - u0). */
typedef struct {
    double k_inverse_g_per_v[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
    double u0_v[TUMBLE_CHANNELS];
} tumble_calibration_t;

/* At or below this, K counts as singular: a row's length over the longest row's, and the volume that the three unit rows
 * span (1 for orthogonal channels, 0 for parallel ones). */
#define TUMBLE_MIN_ROW_RATIO 1e-6
#define TUMBLE_MIN_ROW_VOLUME 1e-3

/* Invert the coefficients. Returns TUMBLE_OK, _ARGUMENT, _NOT_FINITE, _SINGULAR. */
tumble_status_t tumble_calibration_invert(const tumble_coefficients_t *coefficients, tumble_calibration_t *calibration);

/* Outputs (V) to specific force (g). */
void tumble_calibration_apply(const tumble_calibration_t *calibration, const double u_v[TUMBLE_CHANNELS],
                              double a_g[TUMBLE_CHANNELS]);

/* Raw counts to specific force (g); `v_per_count` is the size of one count of the converter. */
void tumble_calibration_apply_counts(const tumble_calibration_t *calibration, double v_per_count,
                                     const int32_t counts[TUMBLE_CHANNELS], double a_g[TUMBLE_CHANNELS]);

/* Parameters that do not depend on how the block sits on the stand (Geist and Gaitan, NIST, J. Res. 122.032, 126.038):
 * scale_i = |row i of K|, the angles between the sensitive axes as cosines (the core has no arc cosine), and the bias
 * of a channel over its own scale, U0_i / |row i|. */
typedef struct {
    double scale_v_per_g[TUMBLE_CHANNELS];
    double cosine_xy;
    double cosine_xz;
    double cosine_yz;
    double bias_g[TUMBLE_CHANNELS];
} tumble_intrinsic_t;

/* Returns TUMBLE_OK, _ARGUMENT, _NOT_FINITE, _SINGULAR (a row of K that is zero or nearly so). */
tumble_status_t tumble_calibration_intrinsic(const tumble_coefficients_t *coefficients, tumble_intrinsic_t *intrinsic);

#endif
