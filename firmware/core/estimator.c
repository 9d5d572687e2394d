#include "tumble/core.h"

#include "core/arith.h"
#include "core/means.h"
#include "core/normal.h"

#include <stddef.h>

enum { X, Y, Z };

#define SQRT2 1.41421356237309504880

/* What one channel tells in one mounting: the harmonics of its nine means. */
typedef struct {
    double c; /* amplitude of cos phi, formula (3) */
    double s; /* amplitude of sin phi */
    double b; /* mean */
} harmonics_t;

/* c = [U1 + U9 - 2 U5 + sqrt2 (U2 + U8 - U4 - U6)] / 8
 * s = [2 (U3 - U7) + sqrt2 (U2 + U4 - U6 - U8)] / 8
 * b = [(U1 + U9)/2 + U2 + U3 + U4 + U5 + U6 + U7 + U8] / 8
 * with opposite positions paired, so that the bias cancels before anything is scaled. */
static harmonics_t harmonics(const tumble_means_t *means, const uint8_t index[9], int channel)
{
    double u[10]; /* numbered from 1 as in the formulas */
    for (int l = 1; l <= 9; l++) {
        u[l] = means->u_v[index[l - 1]][channel];
    }
    double difference[5]; /* of the positions l and l + 4, and their sum */
    double sum[5];
    for (int l = 1; l <= 4; l++) {
        difference[l] = u[l] - u[l + 4];
        sum[l] = u[l] + u[l + 4];
    }
    const double c = (difference[1] + (u[9] - u[5])) + (SQRT2 * (difference[2] - difference[4]));
    const double s = (2.0 * difference[3]) + (SQRT2 * (difference[2] + difference[4]));
    const double b = (((0.5 * (u[1] + u[9])) + u[5]) + sum[3]) + (sum[2] + sum[4]);
    return (harmonics_t){0.125 * c, 0.125 * s, 0.125 * b};
}

static tumble_status_t check_arguments(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                       const tumble_coefficients_t *coefficients)
{
    if ((schedule == NULL) || (means == NULL) || (coefficients == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    return tumble_means_are_numbers(schedule, means) ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
}

static void report(tumble_refusal_t *refusal, uint32_t missing, uint8_t unidentified)
{
    if (refusal != NULL) {
        *refusal = (tumble_refusal_t){missing, unidentified};
    }
}

static tumble_status_t estimate_harmonic(const tumble_schedule_t *schedule, const tumble_means_t *means, bool refined,
                                         tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    tumble_status_t status = check_arguments(schedule, means, coefficients);
    uint32_t missing = 0;
    tumble_harmonic_map_t map;
    if (status == TUMBLE_OK) {
        status = tumble_schedule_harmonic(schedule, means->measured, &map, &missing);
    }
    report(refusal, missing, 0);
    if (status != TUMBLE_OK) {
        return status;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const harmonics_t one = harmonics(means, map.index[0], i);
        const harmonics_t two = harmonics(means, map.index[1], i);
        double k_ix = 0.5 * (one.s - two.s); /* K1_ix = s1_i, K2_ix = -s2_i */
        if (refined && (i == Y)) {
            k_ix = -two.s; /* formula (7): K_yx = K2_yx */
        } else if (refined && (i == Z)) {
            k_ix = one.s; /* formula (7): K_zx = K1_zx */
        }
        coefficients->k_v_per_g[i][X] = k_ix;
        coefficients->k_v_per_g[i][Y] = two.c;
        coefficients->k_v_per_g[i][Z] = one.c;
        coefficients->u0_v[i] = 0.5 * (one.b + two.b);
    }
    return TUMBLE_OK;
}

tumble_status_t tumble_estimate_averaged(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                         tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    return estimate_harmonic(schedule, means, false, coefficients, refusal);
}

tumble_status_t tumble_estimate_refined(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                        tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    return estimate_harmonic(schedule, means, true, coefficients, refusal);
}

tumble_status_t tumble_estimate_least_squares(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                              tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    const tumble_status_t status = check_arguments(schedule, means, coefficients);
    report(refusal, 0, 0);
    if (status != TUMBLE_OK) {
        return status;
    }
    tumble_normal_t normal;
    tumble_normal_build(&normal, schedule, means->measured);
    const uint8_t unidentified = tumble_normal_unidentified(&normal);
    if (unidentified != 0U) {
        report(refusal, 0, unidentified);
        return TUMBLE_E_RANK;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double x[TUMBLE_UNKNOWNS];
        tumble_normal_fit(&normal, schedule, means, i, x);
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            coefficients->k_v_per_g[i][j] = x[j];
        }
        coefficients->u0_v[i] = x[TUMBLE_CHANNELS];
    }
    return TUMBLE_OK;
}

static bool gains_fit(const tumble_gain_table_t *table, const tumble_schedule_t *schedule)
{
    const size_t fit_positions = tumble_means_fit_positions(schedule);
    bool fits = (fit_positions == table->fit_positions);
    for (size_t g = 0; fits && (g < ((size_t)TUMBLE_COEFFICIENTS * TUMBLE_CHANNELS * fit_positions)); g++) {
        fits = tumble_within(table->gains[g], TUMBLE_MAX_GAIN);
    }
    return fits;
}

static double apply_gain_row(const double *gains, const tumble_schedule_t *schedule, const tumble_means_t *means)
{
    double sum = 0.0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        if (schedule->positions[p].use == TUMBLE_USE_FIT) {
            for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                sum += *gains * means->u_v[p][i];
                gains++;
            }
        }
    }
    return sum;
}

tumble_status_t tumble_estimate_gains(const tumble_gain_table_t *table, const tumble_schedule_t *schedule,
                                      const tumble_means_t *means, tumble_coefficients_t *coefficients)
{
    const tumble_status_t status = check_arguments(schedule, means, coefficients);
    if ((status != TUMBLE_OK) || (table == NULL) || (table->gains == NULL)) {
        return (status != TUMBLE_OK) ? status : TUMBLE_E_ARGUMENT;
    }
    if (!gains_fit(table, schedule)) {
        return TUMBLE_E_GAIN_TABLE;
    }
    if (!tumble_means_are_complete(schedule, means)) {
        return TUMBLE_E_MISSING_POSITION;
    }
    const size_t row_length = (size_t)table->fit_positions * TUMBLE_CHANNELS;
    const double *u0_rows = table->gains + ((size_t)(TUMBLE_CHANNELS * TUMBLE_CHANNELS) * row_length);
    for (size_t i = 0; i < TUMBLE_CHANNELS; i++) {
        for (size_t j = 0; j < TUMBLE_CHANNELS; j++) {
            const double *row = table->gains + (((i * TUMBLE_CHANNELS) + j) * row_length);
            coefficients->k_v_per_g[i][j] = apply_gain_row(row, schedule, means);
        }
        coefficients->u0_v[i] = apply_gain_row(u0_rows + (i * row_length), schedule, means);
    }
    return TUMBLE_OK;
}
