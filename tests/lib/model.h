/* model.h - an independent model of the ideal stand, to make the means that a known block must give.
 *
 * It reads the schedule's data but none of the core's functions, and computes with 31 digits, so that the only rounding
 * in a mean is the last one.
 */
#ifndef TUMBLE_TESTS_UNIT_MODEL_H
#define TUMBLE_TESTS_UNIT_MODEL_H

#include "angles.h"
#include "double_double.h"
#include "support.h"
#include "tumble/core.h"

static inline const tumble_mounting_t *model_mounting(const tumble_schedule_t *schedule, unsigned position)
{
    unsigned m = 0;
    while (schedule->mountings[m].number != schedule->positions[position].mounting) {
        m++;
    }
    return &schedule->mountings[m];
}

/* a = M f, f = (cos t sin p, sin t, cos t cos p). */
static inline void model_attitude(const tumble_schedule_t *schedule, unsigned position, dd_t a[TUMBLE_CHANNELS])
{
    const tumble_mounting_t *mounting = model_mounting(schedule, position);
    const tumble_angle_t *table = &schedule->positions[position].angle;
    const dd_t f[3] = {dd_two_product(mounting->tilt.cosine, table->sine), dd_of(mounting->tilt.sine),
                       dd_two_product(mounting->tilt.cosine, table->cosine)};
    for (int axis = 0; axis < TUMBLE_CHANNELS; axis++) {
        a[axis] = dd_of(0.0);
        for (int k = 0; k < 3; k++) {
            a[axis] = dd_add(a[axis], dd_multiply(dd_of(mounting->matrix[axis][k]), f[k]));
        }
    }
}

static inline dd_t model_output(const tumble_coefficients_t *block, int channel, const dd_t a[TUMBLE_CHANNELS])
{
    dd_t u = dd_of(block->u0_v[channel]);
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        u = dd_add(u, dd_multiply(dd_of(block->k_v_per_g[channel][j]), a[j]));
    }
    return u;
}

/* What the block gives on the ideal stand; every position measured. */
static inline void model_means(const tumble_schedule_t *schedule, const tumble_coefficients_t *block,
                               tumble_means_t *means)
{
    memset(means, 0, sizeof *means);
    for (unsigned p = 0; p < schedule->position_count; p++) {
        dd_t a[TUMBLE_CHANNELS];
        model_attitude(schedule, p, a);
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            means->u_v[p][i] = dd_round(model_output(block, i, a));
        }
        means->measured[p] = true;
    }
}

/* Scale factors of either sign from 0.5 to 3.5 V/g, cross terms to 0.2 V/g, biases to 0.3 V. */
static inline tumble_coefficients_t random_block(dice_t *dice)
{
    tumble_coefficients_t block;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            block.k_v_per_g[i][j] = 0.2 * dice_signed_unit(dice);
        }
        const double scale = 2.0 + 1.5 * dice_signed_unit(dice);
        block.k_v_per_g[i][i] = (dice_below(dice, 2) == 0U) ? scale : -scale;
        block.u0_v[i] = 0.3 * dice_signed_unit(dice);
    }
    return block;
}

/* A proper rotation from a random integer quaternion: rational, so good to the last bits. */
static inline void random_rotation(dice_t *dice, double matrix[3][3])
{
    const double w = (double)dice_between(dice, 1, 9);
    const double x = (double)dice_between(dice, -9, 9);
    const double y = (double)dice_between(dice, -9, 9);
    const double z = (double)dice_between(dice, -9, 9);
    const double n = w * w + x * x + y * y + z * z;
    const double r[3][3] = {
        {w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
        {2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)},
        {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z},
    };
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            matrix[i][j] = r[i][j] / n;
        }
    }
}

static inline double largest_k(const tumble_coefficients_t *block)
{
    double largest = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            const double size = magnitude(block->k_v_per_g[i][j]);
            largest = (size > largest) ? size : largest;
        }
    }
    return largest;
}

/* All twelve within `relative` of the largest element of K. */
static inline void assert_coefficients(const tumble_coefficients_t *expected, const tumble_coefficients_t *actual,
                                       double relative)
{
    const double tolerance = relative * largest_k(expected);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected->k_v_per_g[i][j], actual->k_v_per_g[i][j]);
        }
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected->u0_v[i], actual->u0_v[i]);
    }
}

#endif
