/* estimator_bench.h - what the tests of the estimators share: their common shape, and how a refusal must look. */
#ifndef TUMBLE_TESTS_UNIT_ESTIMATOR_BENCH_H
#define TUMBLE_TESTS_UNIT_ESTIMATOR_BENCH_H

#include "model.h"

typedef tumble_status_t estimator_t(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                    tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

static inline void assert_same_coefficients(const tumble_coefficients_t *expected, const tumble_coefficients_t *actual)
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            ASSERT_SAME_DOUBLE(expected->k_v_per_g[i][j], actual->k_v_per_g[i][j]);
        }
        ASSERT_SAME_DOUBLE(expected->u0_v[i], actual->u0_v[i]);
    }
}

static inline tumble_coefficients_t estimate_with(estimator_t *estimator, const tumble_schedule_t *schedule,
                                                  const tumble_means_t *means)
{
    tumble_coefficients_t coefficients;
    tumble_coefficients_t again;
    tumble_refusal_t refusal = {0xFFFFFFFFU, 0xFF};
    ASSERT_STATUS(TUMBLE_OK, estimator(schedule, means, &coefficients, &refusal));
    TEST_ASSERT_EQUAL_HEX64(0, refusal.missing);
    TEST_ASSERT_EQUAL_HEX8(0, refusal.unidentified);
    ASSERT_STATUS(TUMBLE_OK, estimator(schedule, means, &again, NULL));
    assert_same_coefficients(&coefficients, &again);
    return coefficients;
}

/* The exact status, the exact reason, and coefficients as they were. */
static inline void assert_estimator_refuses(estimator_t *estimator, const tumble_schedule_t *schedule,
                                            const tumble_means_t *means, tumble_status_t expected,
                                            tumble_refusal_t reason)
{
    tumble_coefficients_t coefficients;
    tumble_coefficients_t as_they_were;
    tumble_refusal_t refusal = {0xFFFFFFFFU, 0xFF};
    memset(&coefficients, 0x5A, sizeof coefficients);
    as_they_were = coefficients;
    ASSERT_STATUS(expected, estimator(schedule, means, &coefficients, &refusal));
    TEST_ASSERT_EQUAL_HEX64(reason.missing, refusal.missing);
    TEST_ASSERT_EQUAL_HEX8(reason.unidentified, refusal.unidentified);
    ASSERT_STATUS(expected, estimator(schedule, means, &coefficients, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&as_they_were, &coefficients, sizeof coefficients);
}

static inline void assert_estimator_refuses_null(estimator_t *estimator)
{
    static tumble_means_t means;
    tumble_coefficients_t coefficients;
    tumble_refusal_t refusal;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, estimator(NULL, &means, &coefficients, &refusal));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, estimator(&tumble_schedule_paper, NULL, &coefficients, &refusal));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, estimator(&tumble_schedule_paper, &means, NULL, &refusal));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, estimator(NULL, NULL, NULL, NULL));
}

/* NaN and infinity in every position of the paper and every channel. */
static inline void assert_estimator_refuses_what_is_not_finite(estimator_t *estimator)
{
    static const double bad[] = {NOT_A_NUMBER, INFINITE, -INFINITE};
    static tumble_means_t means;
    dice_t dice = {9};
    const tumble_coefficients_t block = random_block(&dice);
    model_means(&tumble_schedule_paper, &block, &means);
    for (unsigned cell = 0; cell < 54U; cell++) {
        double *u_v = &means.u_v[cell / 3U][cell % 3U];
        const double good = *u_v;
        for (size_t i = 0; i < COUNT_OF(bad); i++) {
            *u_v = bad[i];
            assert_estimator_refuses(estimator, &tumble_schedule_paper, &means, TUMBLE_E_NOT_FINITE,
                                     (tumble_refusal_t){0, 0});
        }
        *u_v = good;
    }
}

/* Means as large as allowed give finite coefficients; one unit in the last place more is refused. */
static inline void assert_estimator_has_the_documented_range(estimator_t *estimator)
{
    static tumble_means_t means;
    for (int p = 0; p < 18; p++) {
        means.measured[p] = true;
        means.u_v[p][0] = (p % 2 == 0) ? TUMBLE_MAX_MEAN_V : -TUMBLE_MAX_MEAN_V;
        means.u_v[p][1] = -TUMBLE_MAX_MEAN_V;
        means.u_v[p][2] = 1.0;
    }
    const tumble_coefficients_t estimate = estimate_with(estimator, &tumble_schedule_paper, &means);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            TEST_ASSERT_DOUBLE_IS_DETERMINATE(estimate.k_v_per_g[i][j]);
        }
        TEST_ASSERT_DOUBLE_IS_DETERMINATE(estimate.u0_v[i]);
    }
    for (int p = 0; p < 18; p++) {
        for (int i = 0; i < 2; i++) {
            means.u_v[p][i] = one_ulp_beyond(means.u_v[p][i]);
            assert_estimator_refuses(estimator, &tumble_schedule_paper, &means, TUMBLE_E_NOT_FINITE,
                                     (tumble_refusal_t){0, 0});
            means.u_v[p][i] = one_ulp_within(means.u_v[p][i]);
        }
    }
}

/* The values at check positions do not enter a fit; what was not measured, and rows beyond the schedule, may hold
 * anything. */
static inline void assert_estimator_ignores_what_is_not_for_it(estimator_t *estimator)
{
    static tumble_position_t positions[TUMBLE_MAX_POSITIONS];
    static tumble_means_t means;
    dice_t dice = {10};
    memcpy(positions, tumble_schedule_paper.positions, 18U * sizeof positions[0]);
    positions[18] = (tumble_position_t){1, 101, TUMBLE_USE_CHECK, steps_of_7_5_deg[3]};
    positions[19] = (tumble_position_t){2, 101, TUMBLE_USE_CHECK, positions[2].angle};
    positions[20] = (tumble_position_t){2, 102, TUMBLE_USE_FIT, steps_of_7_5_deg[9]};
    const tumble_schedule_t extended = {tumble_schedule_paper.mountings, positions, 2, 21};
    for (int round = 0; round < 20; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        model_means(&extended, &block, &means);
        means.measured[20] = false;
        const tumble_coefficients_t expected = estimate_with(estimator, &tumble_schedule_paper, &means);
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            means.u_v[18][i] = 1e6;
            means.u_v[19][i] = -1e6;
            means.u_v[20][i] = (i == 0) ? INFINITE : NOT_A_NUMBER;
            means.u_v[21][i] = NOT_A_NUMBER;
        }
        means.measured[21] = true;
        const tumble_coefficients_t actual = estimate_with(estimator, &extended, &means);
        assert_same_coefficients(&expected, &actual);
    }
    means.u_v[18][1] = NOT_A_NUMBER; /* measured, so it must be a number */
    assert_estimator_refuses(estimator, &extended, &means, TUMBLE_E_NOT_FINITE, (tumble_refusal_t){0, 0});
}

#endif
