#include "core/harmonic.h"

#include "core/arith.h"

#include <stddef.h>

#define ANGLE_TOLERANCE 1e-12
#define ROTATION_TOLERANCE 1e-9
#define TOLERANCE 4U /* 1e-9 degrees in 2^-32 */
#define UPPER_OF_2_20 0x41300000U

/* Steps as bits: all nine, and the diagonals 45, 135, 225 and 315 degrees. */
#define NINE 0x3FEU
#define FOUR 0x154U

/* Step 1 to 9; 0 for an angle that is none. A double from 2^20 on has 2^-32 for its last place, so the sum's lower word
 * counts parts of a degree and its upper one, less that of 2^20, whole degrees. */
static uint8_t step_of(const tumble_angle_t *angle)
{
    const double sum = angle->deg + (1048576.0 + 45.0);
    uint64_t bits;
    (void)memcpy(&bits, &sum, sizeof bits);
    bits += TOLERANCE;
    const uint32_t whole_deg = (uint32_t)(bits >> 32) - UPPER_OF_2_20;
    const uint32_t step = whole_deg / 45U;
    const bool is_step = ((uint32_t)bits <= (2U * TOLERANCE)) && (whole_deg == (45U * step));
    return (is_step && (step <= TUMBLE_STEPS)) ? (uint8_t)step : 0U;
}

/* The block axis along the axis of the stand, up or down; TUMBLE_CHANNELS if none is, or if that axis is tilted. */
static uint8_t normal_of(const tumble_mounting_t *mounting)
{
    uint8_t normal = TUMBLE_CHANNELS;
    bool straight = tumble_within(mounting->tilt.sine, ANGLE_TOLERANCE) && tumble_is_positive(mounting->tilt.cosine);
    for (uint8_t j = 0; j < TUMBLE_CHANNELS; j++) {
        const double along = tumble_abs(mounting->matrix[j][1]);
        if (!tumble_within(along, ROTATION_TOLERANCE)) {
            straight = straight && tumble_within(along - 1.0, ROTATION_TOLERANCE);
            normal = j;
        }
    }
    return straight ? normal : TUMBLE_CHANNELS;
}

void tumble_circle_find(const tumble_schedule_t *schedule, const bool *measured, uint8_t m, tumble_circle_t *circle)
{
    uint32_t planned = 0;
    for (size_t step = 0; step < sizeof circle->index; step++) {
        circle->index[step] = TUMBLE_NOWHERE;
    }
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const tumble_position_t *position = &schedule->positions[p];
        if ((position->mounting == schedule->mountings[m].number) && (position->use == TUMBLE_USE_FIT)) {
            const uint8_t step = step_of(&position->angle);
            uint8_t *at = &circle->index[step];
            if ((*at == TUMBLE_NOWHERE) || ((measured != NULL) && !measured[*at])) {
                *at = p;
            }
            planned |= (uint32_t)1U << step;
        }
    }
    planned &= NINE;
    circle->normal = normal_of(&schedule->mountings[m]);
    circle->over = 0;
    if (circle->normal < TUMBLE_CHANNELS) {
        circle->over = (planned == NINE) ? 8U : ((planned == FOUR) ? 4U : 0U);
    }
}

tumble_status_t tumble_schedule_harmonic(const tumble_schedule_t *schedule, const bool *measured,
                                         tumble_harmonic_map_t *map, uint64_t *missing)
{
    if ((schedule == NULL) || (map == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    uint64_t lacking = 0;
    uint32_t normals = 0;
    *map = (tumble_harmonic_map_t){0};
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        tumble_circle_t circle;
        tumble_circle_find(schedule, measured, m, &circle);
        for (uint8_t step = 1; (step <= TUMBLE_STEPS) && (circle.over != 0U); step++) {
            const uint8_t p = circle.index[step];
            if ((p != TUMBLE_NOWHERE) && (measured != NULL) && !measured[p]) {
                lacking |= UINT64_C(1) << p;
            }
        }
        if (circle.over != 0U) {
            map->circles[circle.normal]++;
            normals |= (uint32_t)1U << circle.normal;
        }
    }
    /* Two different circles hold all three axes. */
    const bool complete = (normals & (normals - 1U)) != 0U;
    if (missing != NULL) {
        *missing = complete ? lacking : 0U;
    }
    if (!complete) {
        return TUMBLE_E_NOT_HARMONIC;
    }
    return (lacking == 0U) ? TUMBLE_OK : TUMBLE_E_MISSING_POSITION;
}

uint8_t tumble_circle_count(const tumble_harmonic_map_t *map)
{
    return (uint8_t)(map->circles[0] + map->circles[1] + map->circles[2]);
}

uint8_t tumble_circle_share(const tumble_harmonic_map_t *map, bool refined, int i, int j, int normal)
{
    const int other = TUMBLE_CHANNELS - i - j; /* the third axis: normal to the circles that hold both */
    if (refined && (i != j) && (map->circles[other] > 0U)) {
        return (normal == other) ? map->circles[other] : 0U;
    }
    return (normal == j) ? 0U : (uint8_t)(tumble_circle_count(map) - map->circles[j]);
}
