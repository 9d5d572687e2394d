#include "tumble/core.h"

#include "core/arith.h"
#include "core/means.h"
#include "core/uncertainty.h"

#include <stddef.h>

/* A force along h, n and v of the table: what one unit of each adds to a sum of coefficients by the outputs of the fit
 * position number `fit` from 0. */
static void weigh_force(const tumble_gains_t *gains, const double weight[TUMBLE_COEFFICIENTS],
                        const tumble_mounting_t *mounting, size_t fit, double by_force[3])
{
    const size_t row_length = (size_t)gains->table->fit_positions * TUMBLE_CHANNELS;
    double along[TUMBLE_CHANNELS] = {0.0, 0.0, 0.0}; /* the axes of the block */
    for (size_t row = 0; row < TUMBLE_COEFFICIENTS; row++) {
        const double *gain = &gains->table->gains[(row * row_length) + (fit * TUMBLE_CHANNELS)];
        const bool counts = tumble_is_positive(tumble_abs(weight[row])); /* mostly one does */
        for (int i = 0; counts && (i < TUMBLE_CHANNELS); i++) {
            for (int j = 0; j < TUMBLE_CHANNELS; j++) {
                along[j] += weight[row] * gain[i] * gains->run->coefficients->k_v_per_g[i][j];
            }
        }
    }
    for (int n = 0; n < 3; n++) {
        by_force[n] = 0.0;
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            by_force[n] += along[j] * mounting->matrix[j][n];
        }
    }
}

/* What one unit of beta and of tau of a mounting adds to a sum of coefficients. False: no position is fitted there. */
static bool weigh_inclination(const tumble_gains_t *gains, const double weight[TUMBLE_COEFFICIENTS],
                              const tumble_mounting_t *mounting, double *by_beta, double *by_tau)
{
    const tumble_schedule_t *schedule = gains->run->schedule;
    const tumble_angle_t *tilt = &mounting->tilt;
    size_t fit = 0;
    bool used = false;
    *by_beta = 0.0;
    *by_tau = 0.0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const tumble_position_t *position = &schedule->positions[p];
        const bool is_fit = (position->use == TUMBLE_USE_FIT);
        if (is_fit && (position->mounting == mounting->number)) {
            const tumble_angle_t *angle = &position->angle;
            double by[3];
            weigh_force(gains, weight, mounting, fit, by);
            *by_beta += (tilt->cosine * by[1]) - (tilt->sine * ((angle->sine * by[0]) + (angle->cosine * by[2])));
            *by_tau += tilt->cosine * ((angle->cosine * by[0]) - (angle->sine * by[2]));
            used = true;
        }
        fit += is_fit ? 1U : 0U;
    }
    return used;
}

/* What the errors of inclinations add to the uncertainty of a sum of coefficients. In a bolting of several each has a beta,
 * and each but the first a tau. */
static double with_inclinations(const tumble_gains_t *gains, const double weight[TUMBLE_COEFFICIENTS], double u)
{
    const tumble_schedule_t *schedule = gains->run->schedule;
    double squares = 0.0;
    double first_square = 0.0;
    uint8_t inclinations = 0;
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        double by_beta;
        double by_tau;
        if (!tumble_schedule_stays_bolted(schedule, m)) {
            inclinations = 0;
        }
        if (weigh_inclination(gains, weight, &schedule->mountings[m], &by_beta, &by_tau)) {
            if (inclinations == 0U) {
                first_square = tumble_square(by_beta);
            } else {
                squares += ((inclinations == 1U) ? first_square : 0.0) + tumble_square(by_beta) + tumble_square(by_tau);
            }
            inclinations++;
        }
    }
    return tumble_sqrt(tumble_square(u) + (tumble_square(gains->table->inclination_rad) * squares));
}

/* To what was judged, the length of the shown force at an attitude (core/uncertainty.c) or coefficients. */
static tumble_status_t add_inclinations(const tumble_gains_t *gains, tumble_uncertainty_t *uncertainty)
{
    const tumble_judged_run_t *run = gains->run;
    double weight[TUMBLE_COEFFICIENTS] = {0};
    double check = 0.0;
    if (run->attitude != NULL) {
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            for (int j = 0; j < TUMBLE_CHANNELS; j++) {
                weight[(TUMBLE_CHANNELS * i) + j] = gains->by_channel[i] * run->attitude[j];
            }
            weight[(TUMBLE_CHANNELS * TUMBLE_CHANNELS) + i] = gains->by_channel[i];
        }
        *run->norm_g = with_inclinations(gains, weight, *run->norm_g);
        return tumble_is_finite(*run->norm_g) ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
    }
    for (int row = 0; row < TUMBLE_COEFFICIENTS; row++) {
        const uint32_t bit = UINT32_C(1) << (uint32_t)row;
        double *const u = (row < (TUMBLE_CHANNELS * TUMBLE_CHANNELS))
                              ? &uncertainty->k_v_per_g[row / TUMBLE_CHANNELS][row % TUMBLE_CHANNELS]
                              : &uncertainty->u0_v[row % TUMBLE_CHANNELS];
        if ((run->only == 0U) || ((run->only & bit) != 0U)) {
            weight[row] = 1.0;
            *u = with_inclinations(gains, weight, *u);
            weight[row] = 0.0;
            check += *u;
        }
    }
    if (!tumble_is_finite(check)) {
        *uncertainty = (tumble_uncertainty_t){0};
        return TUMBLE_E_NOT_FINITE;
    }
    return TUMBLE_OK;
}

static bool every_fit_position_is_measured(const tumble_judged_run_t *run)
{
    bool measured = true;
    for (uint8_t p = 0; (run->measured != NULL) && (p < run->schedule->position_count); p++) {
        measured = measured && (run->measured[p] || (run->schedule->positions[p].use != TUMBLE_USE_FIT));
    }
    return measured;
}

tumble_status_t tumble_uncertainty_gains(const tumble_gain_table_t *table, const tumble_judged_run_t *run,
                                         tumble_uncertainty_t *uncertainty)
{
    const tumble_status_t status = tumble_uncertainty_check(run, uncertainty);
    if ((status != TUMBLE_OK) || (table == NULL) || (table->gains == NULL)) {
        return (status != TUMBLE_OK) ? status : TUMBLE_E_ARGUMENT;
    }
    if (table->fit_positions != tumble_means_fit_positions(run->schedule)) {
        return TUMBLE_E_GAIN_TABLE;
    }
    if (!every_fit_position_is_measured(run)) {
        return TUMBLE_E_MISSING_POSITION;
    }
    tumble_gains_t gains = {.run = run, .kind = TUMBLE_GAINS_TABLE, .table = table};
    const tumble_status_t judged = tumble_uncertainty_judge(&gains, uncertainty);
    const bool is_inclined = tumble_is_positive(table->inclination_rad);
    return ((judged == TUMBLE_OK) && is_inclined) ? add_inclinations(&gains, uncertainty) : judged;
}
