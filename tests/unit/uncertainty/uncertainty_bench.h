/* uncertainty_bench.h - what the tests of the uncertainties share. */
#ifndef TUMBLE_TESTS_UNIT_UNCERTAINTY_BENCH_H
#define TUMBLE_TESTS_UNIT_UNCERTAINTY_BENCH_H

#include "estimator_bench.h"
#include "tumble/core.h"

typedef tumble_status_t judge_t(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                tumble_refusal_t *refusal);

static inline tumble_uncertainty_t judged(judge_t *judge, const tumble_judged_run_t *run)
{
    tumble_uncertainty_t found;
    tumble_uncertainty_t again;
    tumble_refusal_t refusal = {0xFFFFFFFFU, 0xFF};
    ASSERT_STATUS(TUMBLE_OK, judge(run, &found, &refusal));
    TEST_ASSERT_EQUAL_HEX64(0, refusal.missing);
    TEST_ASSERT_EQUAL_HEX8(0, refusal.unidentified);
    ASSERT_STATUS(TUMBLE_OK, judge(run, &again, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&found, &again, sizeof found);
    return found;
}

static inline void assert_uncertainties(const double k[3][3], const double u0[3], const tumble_uncertainty_t *found,
                                        double relative)
{
    double largest = 1.0; /* what cancels is of that size, also where nothing is left */
    for (int cell = 0; cell < 12; cell++) {
        const double expected = (cell < 9) ? k[cell / 3][cell % 3] : u0[cell - 9];
        largest = (expected > largest) ? expected : largest;
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            TEST_ASSERT_DOUBLE_WITHIN(relative * k[i][j] + 1e-16 * largest, k[i][j], found->k_v_per_g[i][j]);
        }
        TEST_ASSERT_DOUBLE_WITHIN(relative * u0[i] + 1e-16 * largest, u0[i], found->u0_v[i]);
    }
}

static inline tumble_judged_run_t run_on_paper(const tumble_stand_record_t *stand, const tumble_coefficients_t *block)
{
    return (tumble_judged_run_t){.schedule = &tumble_schedule_paper, .stand = stand, .coefficients = block};
}

#endif
