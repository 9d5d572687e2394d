#include "core/harmonic.h"

#include "core/arith.h"

#include <stddef.h>

#define ANGLE_TOLERANCE 1e-12
#define ROTATION_TOLERANCE 1e-9
#define TOLERANCE 4U /* 1e-9 degrees in 2^-32 */
#define UPPER_OF_2_20 0x41300000U

/* Steps as bits: all nine, and the diagonals 45, 135, 225 and 315 degrees. */
#define NINE 0x1FFU
#define FOUR 0x0AAU

/* Step 0 to 8; TUMBLE_STEPS for an angle that is none. A double from 2^20 on has 2^-32 for its last place, so the sum's lower word
 * counts parts of a degree and its upper one, less that of 2^20, whole degrees. */
static uint8_t step_of(const tumble_angle_t *angle)
{
    const uint64_t bits = tumble_bits(angle->deg + (1048576.0 + 45.0)) + TOLERANCE;
    const uint32_t whole_deg = (uint32_t)(bits >> 32) - UPPER_OF_2_20;
    const uint32_t step = (whole_deg / 45U) - 1U;
    const bool is_step = ((uint32_t)bits <= (2U * TOLERANCE)) && ((whole_deg % 45U) == 0U);
    return (is_step && (step < TUMBLE_STEPS)) ? (uint8_t)step : (uint8_t)TUMBLE_STEPS;
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

/* The circle of the mounting at index `m`; false if it is none. Of several positions at one step the first that is measured
 * counts; if none is, the circle holds one of them. */
static bool find_circle(const tumble_schedule_t *schedule, const bool *measured, uint8_t m, tumble_circle_t *circle)
{
    uint32_t planned = 0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const tumble_position_t *position = &schedule->positions[p];
        if ((position->mounting == schedule->mountings[m].number) && (position->use == TUMBLE_USE_FIT)) {
            const uint8_t step = step_of(&position->angle);
            const uint32_t bit = (uint32_t)1U << step;
            if ((step < TUMBLE_STEPS) &&
                (((planned & bit) == 0U) || ((measured != NULL) && !measured[circle->index[step]]))) {
                circle->index[step] = p;
            }
            planned |= bit;
        }
    }
    planned &= NINE;
    circle->stride = (planned == NINE) ? 1U : 2U;
    circle->normal = normal_of(&schedule->mountings[m]);
    circle->mounting = m;
    return (circle->normal < TUMBLE_CHANNELS) && ((planned == NINE) || (planned == FOUR));
}

/* One bit for each of its positions that was not measured. */
static uint64_t lacking_of(const tumble_circle_t *circle, const bool *measured)
{
    uint64_t lacking = 0;
    for (uint32_t l = circle->stride - 1U; (l < TUMBLE_STEPS) && (measured != NULL); l += circle->stride) {
        if (!measured[circle->index[l]]) {
            lacking |= UINT64_C(1) << circle->index[l];
        }
    }
    return lacking;
}

tumble_status_t tumble_schedule_harmonic(const tumble_schedule_t *schedule, const bool *measured,
                                         tumble_harmonic_map_t *map, uint64_t *missing)
{
    if ((schedule == NULL) || (map == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    uint64_t lacking = 0;
    uint32_t normals = 0;
    *map = (tumble_harmonic_map_t){.schedule = schedule};
    for (uint8_t m = 0; (m < schedule->mounting_count) && (map->count < TUMBLE_MAX_CIRCLES); m++) {
        tumble_circle_t *circle = &map->circle[map->count];
        if (find_circle(schedule, measured, m, circle)) {
            lacking |= lacking_of(circle, measured);
            normals |= (uint32_t)1U << circle->normal;
            map->circles[circle->normal]++;
            map->count++;
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

uint8_t tumble_circle_share(const tumble_harmonic_map_t *map, bool refined, int i, int j, int normal)
{
    const int other = TUMBLE_CHANNELS - i - j; /* the third axis: normal to the circles that hold both */
    if (refined && (i != j) && (map->circles[other] > 0U)) {
        return (normal == other) ? map->circles[other] : 0U;
    }
    return (normal == j) ? 0U : (uint8_t)(map->count - map->circles[j]);
}
