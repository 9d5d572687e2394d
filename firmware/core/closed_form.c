#include "tumble/core.h"

#include "core/harmonic.h"
#include "core/means.h"

#include <stddef.h>

#define ROOT_2 1.4142135623730951

/* A channel on a circle: its means are b + s sin(phi) + c cos(phi). */
typedef struct {
    double s;
    double c;
    double b;
} harmonics_t;

/* Of nine positions, numbered from 1:
 *     8 c = U1 + U9 - 2 U5 + sqrt2 (U2 + U8 - U4 - U6)                        formula (3)
 *     8 s = 2 (U3 - U7) + sqrt2 (U2 + U4 - U6 - U8)
 *     8 b = (U1 + U9)/2 + U2 + U3 + U4 + U5 + U6 + U7 + U8
 * What is opposite is taken together, so that a bias is gone before it is multiplied. */
static harmonics_t of_nine(const double u[TUMBLE_STEPS])
{
    const double diagonal = u[1] - u[5];
    const double other = u[3] - u[7];
    return (harmonics_t){
        .s = ((2.0 * (u[2] - u[6])) + (ROOT_2 * (diagonal + other))) / 8.0,
        .c = (((u[0] - u[4]) + (u[8] - u[4])) + (ROOT_2 * (diagonal - other))) / 8.0,
        .b = (((u[0] + u[8]) / 2.0) + u[1] + u[2] + u[3] + u[4] + u[5] + u[6] + u[7]) / 8.0,
    };
}

/* Of the diagonals alone, the positions of even number, the same less what is not there. */
static harmonics_t of_diagonals(const double u[TUMBLE_STEPS])
{
    const double diagonal = u[1] - u[5];
    const double other = u[3] - u[7];
    return (harmonics_t){
        .s = (ROOT_2 * (diagonal + other)) / 4.0,
        .c = (ROOT_2 * (diagonal - other)) / 4.0,
        .b = (u[1] + u[3] + u[5] + u[7]) / 4.0,
    };
}

static harmonics_t harmonics_of(const tumble_circle_t *circle, const tumble_means_t *means, int i)
{
    double u[TUMBLE_STEPS] = {0};
    for (uint32_t l = circle->stride - 1U; l < TUMBLE_STEPS; l += circle->stride) {
        u[l] = means->u_v[circle->index[l]][i];
    }
    return (circle->stride == 1U) ? of_nine(u) : of_diagonals(u);
}

/* The force (sin, 0, cos) of the table frame makes s and c the first and last column of K M, so K_ij = M_jh s + M_jv c for
 * both axes j of the circle. What several circles say is averaged, formula (7). */
static void estimate_channel(const tumble_harmonic_map_t *map, const tumble_means_t *means, bool refined, int i,
                             tumble_coefficients_t *coefficients)
{
    for (uint8_t m = 0; m < map->count; m++) {
        const tumble_circle_t *circle = &map->circle[m];
        const double (*matrix)[3] = map->schedule->mountings[circle->mounting].matrix;
        const harmonics_t told = harmonics_of(circle, means, i);
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            const uint8_t share = tumble_circle_share(map, refined, i, j, circle->normal);
            if (share != 0U) {
                coefficients->k_v_per_g[i][j] += ((matrix[j][0] * told.s) + (matrix[j][2] * told.c)) / (double)share;
            }
        }
        coefficients->u0_v[i] += told.b / (double)map->count;
    }
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
    if (status != TUMBLE_OK) {
        return status;
    }
    *coefficients = (tumble_coefficients_t){0};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        estimate_channel(&map, means, refined, i, coefficients);
    }
    return TUMBLE_OK;
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
