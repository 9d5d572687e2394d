#include "tumble/core.h"

#include "core/arith.h"
#include "core/means.h"
#include "core/normal.h"

#include <stddef.h>

static void report(tumble_refusal_t *refusal, uint64_t missing, uint8_t unidentified)
{
    if (refusal != NULL) {
        *refusal = (tumble_refusal_t){missing, unidentified};
    }
}

tumble_status_t tumble_estimate_least_squares(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                              tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    const tumble_status_t status = tumble_means_check(schedule, means, coefficients);
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
    const tumble_status_t status = tumble_means_check(schedule, means, coefficients);
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
