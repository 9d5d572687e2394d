#include "tumble/core.h"

#include "core/arith.h"
#include "core/closure.h"
#include "core/normal.h"
#include "core/vector.h"

#include <stddef.h>

#define SAME_ATTITUDE 1e-12

/* delta_g = (|a|^2 - 1) / 2, formula (8) */
static double gravity_error_g(const tumble_calibration_t *calibration, const double u_v[TUMBLE_CHANNELS])
{
    double a[TUMBLE_CHANNELS];
    tumble_calibration_apply(calibration, u_v, a);
    return 0.5 * (tumble_dot(a, a) - 1.0);
}

static tumble_status_t judge_position(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                      const tumble_calibration_t *calibration, uint8_t p, tumble_gravity_check_t *found)
{
    const double delta_g = gravity_error_g(calibration, means->u_v[p]);
    if (!tumble_is_finite(delta_g)) {
        return TUMBLE_E_NOT_FINITE;
    }
    found->delta_g_g[p] = delta_g;
    const bool fit = (schedule->positions[p].use == TUMBLE_USE_FIT);
    double *const largest_g = fit ? &found->max_abs_fit_g : &found->max_abs_check_g;
    uint8_t *const judged = fit ? &found->fit_positions : &found->check_positions;
    *largest_g = tumble_larger(*largest_g, tumble_abs(delta_g));
    *judged = (uint8_t)(*judged + 1U);
    return TUMBLE_OK;
}

tumble_status_t tumble_gravity_check(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                     const tumble_calibration_t *calibration, double limit_g,
                                     tumble_gravity_check_t *check)
{
    if ((schedule == NULL) || (means == NULL) || (calibration == NULL) || (check == NULL) ||
        !tumble_is_positive(limit_g)) {
        return TUMBLE_E_ARGUMENT;
    }
    *check = (tumble_gravity_check_t){0};
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        if (means->measured[p]) {
            const tumble_status_t status = judge_position(schedule, means, calibration, p, check);
            if (status != TUMBLE_OK) {
                *check = (tumble_gravity_check_t){0};
                return status;
            }
        }
    }
    const bool judged = (check->fit_positions > 0U) || (check->check_positions > 0U);
    check->pass =
        judged && tumble_within(check->max_abs_fit_g, limit_g) && tumble_within(check->max_abs_check_g, limit_g);
    return TUMBLE_OK;
}

static bool same_attitude(const tumble_schedule_t *schedule, uint8_t p, uint8_t q)
{
    const tumble_position_t *a = &schedule->positions[p];
    const tumble_position_t *b = &schedule->positions[q];
    return (a->mounting == b->mounting) && tumble_within(a->angle.sine - b->angle.sine, SAME_ATTITUDE) &&
           tumble_within(a->angle.cosine - b->angle.cosine, SAME_ATTITUDE);
}

static bool is_measured(const bool *measured, uint8_t p)
{
    return (measured == NULL) || measured[p];
}

bool tumble_closure_find(const tumble_schedule_t *schedule, const bool *measured, uint8_t mounting,
                         tumble_closure_pair_t *pair)
{
    for (uint8_t late = schedule->position_count; late-- > 0U;) {
        if ((schedule->positions[late].mounting != mounting) || !is_measured(measured, late)) {
            continue;
        }
        for (uint8_t early = 0; early < late; early++) {
            if (is_measured(measured, early) && same_attitude(schedule, early, late)) {
                *pair = (tumble_closure_pair_t){early, late};
                return true;
            }
        }
    }
    return false;
}

tumble_status_t tumble_closure(const tumble_schedule_t *schedule, const tumble_means_t *means, uint8_t mounting,
                               double difference_v[TUMBLE_CHANNELS])
{
    if ((schedule == NULL) || (means == NULL) || (difference_v == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_closure_pair_t pair;
    if (!tumble_closure_find(schedule, means->measured, mounting, &pair)) {
        return TUMBLE_E_MISSING_POSITION;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        difference_v[i] = means->u_v[pair.late][i] - means->u_v[pair.early][i];
    }
    return TUMBLE_OK;
}

void tumble_residual(const tumble_schedule_t *schedule, const tumble_means_t *means,
                     const tumble_coefficients_t *coefficients, uint8_t index, double residual_v[TUMBLE_CHANNELS])
{
    double a[TUMBLE_CHANNELS];
    tumble_schedule_attitude(schedule, index, a);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double *k = coefficients->k_v_per_g[i];
        const double model_v = coefficients->u0_v[i] + (k[0] * a[0]) + (k[1] * a[1]) + (k[2] * a[2]);
        residual_v[i] = means->u_v[index][i] - model_v;
    }
}

tumble_status_t tumble_residual_rms(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                    const tumble_coefficients_t *coefficients, double rms_v[TUMBLE_CHANNELS])
{
    if ((schedule == NULL) || (means == NULL) || (coefficients == NULL) || (rms_v == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    double square_sum[TUMBLE_CHANNELS] = {0.0, 0.0, 0.0};
    int positions = 0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        if (tumble_normal_uses(schedule, means->measured, p)) {
            double residual[TUMBLE_CHANNELS];
            tumble_residual(schedule, means, coefficients, p, residual);
            for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                square_sum[i] += residual[i] * residual[i];
            }
            positions++;
        }
    }
    if (positions <= TUMBLE_UNKNOWNS) {
        return TUMBLE_E_TOO_FEW;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        rms_v[i] = tumble_sqrt(square_sum[i] / (double)(positions - TUMBLE_UNKNOWNS));
    }
    return TUMBLE_OK;
}
