#include "tumble/core.h"

#include "core/arith.h"
#include "core/harmonic.h"
#include "core/means.h"
#include "core/normal.h"
#include "core/vector.h"

#include <stddef.h>

#define SQRT2 1.41421356237309504880

/* What one channel tells on one circle, times 8 for nine positions and times 4 for the diagonals. */
typedef struct {
    double force[3]; /* amplitudes of the force (sin phi, 0, cos phi): the last one is formula (3) */
    double b;        /* mean */
} harmonics_t;

/* Of nine positions, numbered from 1:
 *     8 c = U1 + U9 - 2 U5 + sqrt2 (U2 + U8 - U4 - U6)
 *     8 s = 2 (U3 - U7) + sqrt2 (U2 + U4 - U6 - U8)
 *     8 b = (U1 + U9)/2 + U2 + U3 + U4 + U5 + U6 + U7 + U8
 * with opposite positions paired, so that the bias cancels before anything is scaled. Of the diagonals the same, less
 * what is not there: with the U of even number 4 c, 4 s and 4 b. */
static void harmonics(const tumble_means_t *means, const tumble_circle_t *circle, int channel, harmonics_t *h)
{
    const uint32_t stride = 8U / circle->over; /* of the diagonals: 2 */
    double u[TUMBLE_STEPS + 1U];
    double difference[5]; /* of the positions l and l + 4, and their sum */
    double sum[5];
    for (uint32_t l = stride; l <= TUMBLE_STEPS; l += stride) {
        u[l] = means->u_v[circle->index[l]][channel];
    }
    for (uint32_t l = stride; l <= 4U; l += stride) {
        difference[l] = u[l] - u[l + 4U];
        sum[l] = u[l] + u[l + 4U];
    }
    h->force[0] = SQRT2 * (difference[2] + difference[4]);
    h->force[1] = 0.0;
    h->force[2] = SQRT2 * (difference[2] - difference[4]);
    h->b = sum[2] + sum[4];
    if (stride == 1U) {
        h->force[2] += difference[1] + (u[9] - u[5]);
        h->force[0] += 2.0 * difference[3];
        h->b += ((0.5 * (u[1] + u[9])) + u[5]) + sum[3];
    }
}

static tumble_status_t check_arguments(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                       const tumble_coefficients_t *coefficients)
{
    if ((schedule == NULL) || (means == NULL) || (coefficients == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    return tumble_means_are_numbers(schedule, means) ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
}

static void report(tumble_refusal_t *refusal, uint64_t missing, uint8_t unidentified)
{
    if (refusal != NULL) {
        *refusal = (tumble_refusal_t){missing, unidentified};
    }
}

/* Add what a circle tells of channel i. The force (sin, 0, cos) of the table frame makes s and c the first and last
 * column of K M, so K_ij = M_jh s + M_jv c for both axes j of the circle. */
static void add_circle(const harmonics_t *h, const tumble_circle_t *circle, const tumble_harmonic_map_t *map,
                       const double matrix[3][3], bool refined, int i, tumble_coefficients_t *coefficients)
{
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        const int share = circle->over * tumble_circle_share(map, refined, i, j, circle->normal);
        if (share != 0) {
            coefficients->k_v_per_g[i][j] += tumble_divide(tumble_dot(matrix[j], h->force), (double)share);
        }
    }
    coefficients->u0_v[i] += tumble_divide(h->b, (double)(circle->over * tumble_circle_count(map)));
}

static tumble_status_t estimate_harmonic(const tumble_schedule_t *schedule, const tumble_means_t *means, bool refined,
                                         tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    tumble_status_t status = check_arguments(schedule, means, coefficients);
    uint64_t missing = 0;
    tumble_harmonic_map_t map;
    if (status == TUMBLE_OK) {
        status = tumble_schedule_harmonic(schedule, means->measured, &map, &missing);
    }
    report(refusal, missing, 0);
    if (status != TUMBLE_OK) {
        return status;
    }
    *coefficients = (tumble_coefficients_t){0};
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        tumble_circle_t circle;
        tumble_circle_find(schedule, means->measured, m, &circle);
        for (int i = 0; (i < TUMBLE_CHANNELS) && (circle.over != 0U); i++) {
            harmonics_t h;
            harmonics(means, &circle, i, &h);
            add_circle(&h, &circle, &map, schedule->mountings[m].matrix, refined, i, coefficients);
        }
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
