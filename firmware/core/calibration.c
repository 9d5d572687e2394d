#include "tumble/core.h"

#include "core/arith.h"
#include "core/vector.h"

#include <stdbool.h>
#include <stddef.h>

/* Lengths of the rows of K, each at least TUMBLE_MIN_ROW_RATIO of the longest. */
static tumble_status_t row_lengths(const tumble_coefficients_t *coefficients, double length[TUMBLE_CHANNELS])
{
    double longest = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double *row = coefficients->k_v_per_g[i];
        length[i] = tumble_sqrt(tumble_dot(row, row));
        if (!tumble_is_finite(length[i]) || !tumble_is_finite(coefficients->u0_v[i])) {
            return TUMBLE_E_NOT_FINITE;
        }
        longest = tumble_larger(length[i], longest);
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        if (!tumble_exceeds(length[i], TUMBLE_MIN_ROW_RATIO * longest)) {
            return TUMBLE_E_SINGULAR;
        }
    }
    return TUMBLE_OK;
}

/* With unit rows r_i and D = diag(length): K^-1 = [r1 x r2, r2 x r0, r0 x r1] / volume * D^-1. */
tumble_status_t tumble_calibration_invert(const tumble_coefficients_t *coefficients, tumble_calibration_t *calibration)
{
    if ((coefficients == NULL) || (calibration == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    double length[TUMBLE_CHANNELS];
    const tumble_status_t status = row_lengths(coefficients, length);
    if (status != TUMBLE_OK) {
        return status;
    }
    double unit[TUMBLE_CHANNELS][3];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < 3; j++) {
            unit[i][j] = coefficients->k_v_per_g[i][j] / length[i];
        }
    }
    double column[3];
    tumble_cross(unit[1], unit[2], column);
    const double volume = tumble_dot(unit[0], column);
    if (tumble_within(volume, TUMBLE_MIN_ROW_VOLUME)) {
        return TUMBLE_E_SINGULAR;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        tumble_cross(unit[(i + 1) % 3], unit[(i + 2) % 3], column);
        for (int j = 0; j < 3; j++) {
            calibration->k_inverse_g_per_v[j][i] = column[j] / (volume * length[i]);
        }
        calibration->u0_v[i] = coefficients->u0_v[i];
    }
    return TUMBLE_OK;
}

void tumble_calibration_apply(const tumble_calibration_t *calibration, const double u_v[TUMBLE_CHANNELS],
                              double a_g[TUMBLE_CHANNELS])
{
    double without_bias[TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        without_bias[i] = u_v[i] - calibration->u0_v[i];
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        a_g[i] = tumble_dot(calibration->k_inverse_g_per_v[i], without_bias);
    }
}

void tumble_calibration_apply_counts(const tumble_calibration_t *calibration, double v_per_count,
                                     const int32_t counts[TUMBLE_CHANNELS], double a_g[TUMBLE_CHANNELS])
{
    double u_v[TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        u_v[i] = (double)counts[i] * v_per_count;
    }
    tumble_calibration_apply(calibration, u_v, a_g);
}

tumble_status_t tumble_calibration_intrinsic(const tumble_coefficients_t *coefficients, tumble_intrinsic_t *intrinsic)
{
    if ((coefficients == NULL) || (intrinsic == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    double length[TUMBLE_CHANNELS];
    const tumble_status_t status = row_lengths(coefficients, length);
    if (status != TUMBLE_OK) {
        return status;
    }
    const double *x = coefficients->k_v_per_g[0];
    const double *y = coefficients->k_v_per_g[1];
    const double *z = coefficients->k_v_per_g[2];
    intrinsic->cosine_xy = tumble_dot(x, y) / (length[0] * length[1]);
    intrinsic->cosine_xz = tumble_dot(x, z) / (length[0] * length[2]);
    intrinsic->cosine_yz = tumble_dot(y, z) / (length[1] * length[2]);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        intrinsic->scale_v_per_g[i] = length[i];
        intrinsic->bias_g[i] = coefficients->u0_v[i] / length[i];
    }
    return TUMBLE_OK;
}
