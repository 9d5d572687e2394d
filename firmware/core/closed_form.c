#include "tumble/core.h"

#include "core/arith.h"
#include "core/averaging_state.h"
#include "core/fixed.h"
#include "core/harmonic.h"
#include "core/means.h"

#include <stddef.h>

#define ROOT_2 INT64_C(12738103345051545) /* sqrt(2), as a factor */
#define BIAS TUMBLE_CHANNELS              /* of the unknowns of a channel, the last one */

/* What the circles tell of one channel, K_i and U0_i: 16 times the sums, and over how many circles. */
typedef struct {
    int64_t sums[TUMBLE_UNKNOWNS];
    uint8_t circles[TUMBLE_UNKNOWNS];
} told_t;

static bool counts(const tumble_circle_t *circle, uint32_t step)
{
    return ((step + 1U) & (circle->stride - 1U)) == 0U;
}

/* Of nine positions, numbered from 1:
 *     8 c = U1 + U9 - 2 U5 + sqrt2 (U2 + U8 - U4 - U6)                        formula (3)
 *     8 s = 2 (U3 - U7) + sqrt2 (U2 + U4 - U6 - U8)
 *     8 b = (U1 + U9)/2 + U2 + U3 + U4 + U5 + U6 + U7 + U8
 * Of the diagonals the same, less what is not there: with the U of even number 4 c, 4 s and 4 b.
 * The force (sin, 0, cos) of the table frame makes s and c the first and last column of K M, so K_ij = M_jh s + M_jv c for
 * both axes j of the circle. */
static void add_circle(const int64_t u[TUMBLE_STEPS], const tumble_harmonic_map_t *map, const tumble_circle_t *circle,
                       bool refined, int i, told_t *told)
{
    const double (*matrix)[3] = map->schedule->mountings[circle->mounting].matrix;
    const bool nine = (circle->stride == 1U);
    const int64_t root = nine ? (2 * ROOT_2) : (4 * ROOT_2);
    const int64_t difference = u[1] - u[5];
    const int64_t other = u[3] - u[7];
    const int64_t sum = (u[1] + u[5]) + (u[3] + u[7]);
    int64_t s = tumble_fixed_product(difference + other, root);
    int64_t c = tumble_fixed_product(difference - other, root);
    int64_t b = 4 * sum;
    if (nine) {
        s += 4 * (u[2] - u[6]);
        c += 2 * ((u[0] - u[4]) + (u[8] - u[4]));
        b = (u[0] + u[8]) + (2 * (sum + u[2] + u[4] + u[6]));
    }
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        const uint8_t share = tumble_circle_share(map, refined, i, j, circle->normal);
        if (share != 0U) {
            told->circles[j] = share;
            told->sums[j] += tumble_fixed_times(s, matrix[j][0]) + tumble_fixed_times(c, matrix[j][2]);
        }
    }
    told->sums[BIAS] += b;
}

static void begin(told_t *told, const tumble_harmonic_map_t *map)
{
    for (int j = 0; j < TUMBLE_UNKNOWNS; j++) {
        told->sums[j] = 0;
        told->circles[j] = map->count;
    }
}

/* What a sixteenth of a sum is worth that is over so many circles. */
static void find_worth(const tumble_harmonic_map_t *map, double unit, double worth[TUMBLE_MAX_CIRCLES + 1U])
{
    for (uint8_t n = 1; n <= map->count; n++) {
        worth[n] = tumble_divide(1.0 / 16.0, (double)n) * unit;
    }
}

static void conclude(const told_t *told, const double worth[], double unit, int i, tumble_coefficients_t *coefficients)
{
    for (int j = 0; j < TUMBLE_UNKNOWNS; j++) {
        const double unknown = ((double)told->sums[j] * worth[told->circles[j]]) * unit;
        *((j == BIAS) ? &coefficients->u0_v[i] : &coefficients->k_v_per_g[i][j]) = unknown;
    }
}

/* The bits of the largest mean of each channel. */
static tumble_status_t look_at_means(const tumble_harmonic_map_t *map, const tumble_means_t *means,
                                     uint64_t largest[TUMBLE_CHANNELS])
{
    bool measured = true;
    for (uint8_t m = 0; m < map->count; m++) {
        const tumble_circle_t *circle = &map->circle[m];
        for (uint32_t l = circle->stride - 1U; (l < TUMBLE_STEPS) && measured; l += circle->stride) {
            const uint8_t p = circle->index[l];
            measured = means->measured[p];
            for (int i = 0; (i < TUMBLE_CHANNELS) && measured; i++) {
                const uint64_t size = tumble_bits(tumble_abs(means->u_v[p][i]));
                largest[i] = (size > largest[i]) ? size : largest[i];
            }
        }
    }
    bool numbers = true;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        numbers = numbers && (largest[i] <= tumble_bits(TUMBLE_MAX_MEAN_V));
    }
    if (!measured) {
        return TUMBLE_E_MISSING_POSITION;
    }
    return numbers ? TUMBLE_OK : TUMBLE_E_NOT_FINITE;
}

static tumble_status_t solve_means(const tumble_harmonic_map_t *map, const tumble_means_t *means, bool refined,
                                   tumble_coefficients_t *coefficients)
{
    double worth[TUMBLE_MAX_CIRCLES + 1U];
    uint64_t largest[TUMBLE_CHANNELS] = {0};
    const tumble_status_t status = look_at_means(map, means, largest);
    if (status != TUMBLE_OK) {
        return status;
    }
    find_worth(map, 1.0, worth);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const uint32_t scale = tumble_fixed_scale(largest[i]);
        told_t told;
        begin(&told, map);
        for (uint8_t m = 0; m < map->count; m++) {
            const tumble_circle_t *circle = &map->circle[m];
            int64_t u[TUMBLE_STEPS];
            for (uint32_t l = 0; l < TUMBLE_STEPS; l++) {
                u[l] = counts(circle, l) ? tumble_fixed_of(means->u_v[circle->index[l]][i], scale) : 0;
            }
            add_circle(u, map, circle, refined, i, &told);
        }
        conclude(&told, worth, tumble_fixed_unit(scale), i, coefficients);
    }
    return TUMBLE_OK;
}

static tumble_status_t estimate(const tumble_schedule_t *schedule, const tumble_means_t *means, bool refined,
                                tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    tumble_harmonic_map_t map;
    uint64_t missing = 0;
    tumble_status_t status = tumble_means_check(schedule, means, coefficients);
    if (status == TUMBLE_OK) {
        status = tumble_schedule_harmonic(schedule, means->measured, &map, &missing);
    }
    if (refusal != NULL) {
        *refusal = (tumble_refusal_t){missing, 0};
    }
    return (status == TUMBLE_OK) ? solve_means(&map, means, refined, coefficients) : status;
}

tumble_status_t tumble_estimate_averaged(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                         tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    return estimate(schedule, means, false, coefficients, refusal);
}

tumble_status_t tumble_estimate_refined(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                        tumble_coefficients_t *coefficients, tumble_refusal_t *refusal)
{
    return estimate(schedule, means, true, coefficients, refusal);
}

tumble_status_t tumble_refined_of_means(const tumble_harmonic_map_t *map, const tumble_means_t *means,
                                        tumble_coefficients_t *coefficients)
{
    if ((map == NULL) || (means == NULL) || (coefficients == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    return solve_means(map, means, true, coefficients);
}

/* How many samples all positions have, and every bit that a sum of each channel has. */
typedef struct {
    uint32_t samples;
    uint64_t bits[TUMBLE_CHANNELS];
} extent_t;

static tumble_status_t look_at_sums(const tumble_harmonic_map_t *map, const tumble_averaging_t *averaging,
                                    extent_t *extent)
{
    bool finished = true;
    bool equal = true;
    *extent = (extent_t){averaging->averages[map->circle[0].index[1]].samples, {1U, 1U, 1U}};
    for (uint8_t m = 0; m < map->count; m++) {
        const tumble_circle_t *circle = &map->circle[m];
        for (uint32_t l = circle->stride - 1U; l < TUMBLE_STEPS; l += circle->stride) {
            const tumble_average_t *average = &averaging->averages[circle->index[l]];
            finished = finished && tumble_averaging_has_mean(averaging, circle->index[l]);
            equal = equal && (average->samples == extent->samples);
            for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                const int64_t sum = average->sum_counts[i];
                extent->bits[i] |= (uint64_t)((sum < 0) ? ~sum : sum);
            }
        }
    }
    if (!finished) {
        return TUMBLE_E_MISSING_POSITION;
    }
    return equal ? TUMBLE_OK : TUMBLE_E_STATE;
}

tumble_status_t tumble_refined_of_sums(const tumble_harmonic_map_t *map, const tumble_averaging_t *averaging,
                                       double v_per_count, tumble_coefficients_t *coefficients)
{
    if ((map == NULL) || (averaging == NULL) || (coefficients == NULL) ||
        !tumble_is_positive(tumble_abs(v_per_count)) || !tumble_within(v_per_count, TUMBLE_MAX_V_PER_COUNT)) {
        return TUMBLE_E_ARGUMENT;
    }
    double worth[TUMBLE_MAX_CIRCLES + 1U];
    extent_t extent;
    const tumble_status_t status = look_at_sums(map, averaging, &extent);
    if (status != TUMBLE_OK) {
        return status;
    }
    find_worth(map, tumble_divide(1.0, (double)extent.samples) * v_per_count, worth);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const uint32_t scale = tumble_fixed_scale(tumble_bits((double)extent.bits[i]));
        const int64_t factor = (int64_t)(UINT64_C(1) << (TUMBLE_FIXED_WHOLE - scale));
        told_t told;
        begin(&told, map);
        for (uint8_t m = 0; m < map->count; m++) {
            const tumble_circle_t *circle = &map->circle[m];
            int64_t u[TUMBLE_STEPS];
            for (uint32_t l = 0; l < TUMBLE_STEPS; l++) {
                u[l] = counts(circle, l) ? (averaging->averages[circle->index[l]].sum_counts[i] * factor) : 0;
            }
            add_circle(u, map, circle, true, i, &told);
        }
        conclude(&told, worth, tumble_fixed_unit(scale), i, coefficients);
    }
    return TUMBLE_OK;
}
