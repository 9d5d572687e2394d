/* Least squares against a dense solution of the 12 x 12 normal equations with 31 digits, for any schedule. */
#include "eigen.h"
#include "estimator_bench.h"
#include "random_schedule.h"
#include "six_faces.h"

static tumble_means_t means;

#define N TUMBLE_COEFFICIENTS

/* [A | b] with partial pivoting; the solution is left in the last column. */
static void solve_dense(dd_t system[N][N + 1])
{
    for (int column = 0; column < N; column++) {
        int pivot = column;
        for (int row = column + 1; row < N; row++) {
            pivot = (magnitude(system[row][column].high) > magnitude(system[pivot][column].high)) ? row : pivot;
        }
        for (int k = 0; k <= N; k++) {
            const dd_t kept = system[column][k];
            system[column][k] = system[pivot][k];
            system[pivot][k] = kept;
        }
        for (int row = 0; row < N; row++) {
            const dd_t factor = dd_divide(system[row][column], system[column][column]);
            for (int k = column; k <= N && row != column && factor.high != 0.0; k++) {
                system[row][k] = dd_add(system[row][k], dd_negate(dd_multiply(factor, system[column][k])));
            }
        }
    }
    for (int row = 0; row < N; row++) {
        system[row][N] = dd_divide(system[row][N], system[row][row]);
    }
}

/* One row of the design for every measured fit position and channel, all twelve unknowns at once. */
static tumble_coefficients_t dense_least_squares(const tumble_schedule_t *schedule, const tumble_means_t *them)
{
    static dd_t system[N][N + 1];
    memset(system, 0, sizeof system);
    for (unsigned p = 0; p < schedule->position_count; p++) {
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            dd_t row[N + 1] = {{0, 0}};
            if (schedule->positions[p].use == TUMBLE_USE_FIT && them->measured[p]) {
                model_attitude(schedule, p, &row[3 * i]);
                row[9 + i] = dd_of(1.0);
                row[N] = dd_of(them->u_v[p][i]);
            }
            for (int r = 0; r < N; r++) {
                for (int c = 0; c <= N && row[r].high != 0.0; c++) {
                    system[r][c] = dd_add(system[r][c], dd_multiply(row[r], row[c]));
                }
            }
        }
    }
    solve_dense(system);
    tumble_coefficients_t solution;
    for (int r = 0; r < 9; r++) {
        solution.k_v_per_g[r / 3][r % 3] = dd_round(system[r][N]);
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        solution.u0_v[i] = dd_round(system[9 + i][N]);
    }
    return solution;
}

static void test_it_is_exact_on_an_ideal_stand(void)
{
    dice_t dice = {17};
    for (int round = 0; round < 2000; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        const tumble_schedule_t *schedule = (round % 4 == 0) ? &six_faces : &tumble_schedule_paper;
        model_means(schedule, &block, &means);
        const tumble_coefficients_t estimate = estimate_with(tumble_estimate_least_squares, schedule, &means);
        assert_coefficients(&block, &estimate, 1e-15);
    }
}

static void test_it_minimises_the_squares_on_the_papers_schedule(void)
{
    dice_t dice = {18};
    for (int round = 0; round < 50; round++) {
        for (unsigned cell = 0; cell < 54U; cell++) {
            means.measured[cell / 3U] = true;
            means.u_v[cell / 3U][cell % 3U] = 4.0 * dice_signed_unit(&dice);
        }
        const tumble_coefficients_t expected = dense_least_squares(&tumble_schedule_paper, &means);
        const tumble_coefficients_t estimate =
            estimate_with(tumble_estimate_least_squares, &tumble_schedule_paper, &means);
        assert_coefficients(&expected, &estimate, 5e-15);
    }
}

/* Schedules of any shape, some positions not measured, outputs with 1e-4 V of noise. What can be identified is solved,
 * with an error that grows with the condition of the design; what cannot is refused. */
static void test_random_schedules_against_the_dense_solution(void)
{
    static random_schedule_t random;
    dice_t dice = {19};
    int solved = 0;
    for (int round = 0; round < 400; round++) {
        random_schedule(&dice, &random);
        const tumble_coefficients_t block = random_block(&dice);
        model_means(&random.schedule, &block, &means);
        for (unsigned cell = 0; cell < 3U * random.schedule.position_count; cell++) {
            means.measured[cell / 3U] = dice_below(&dice, 10) != 0U;
            means.u_v[cell / 3U][cell % 3U] += 1e-4 * dice_signed_unit(&dice);
        }
        const eigen_t eigen = eigen_of_design(&random.schedule, means.measured);
        double weakest = eigen.value[0];
        for (int k = 1; k < 4; k++) {
            weakest = (eigen.value[k] < weakest) ? eigen.value[k] : weakest;
        }
        uint8_t unidentified;
        if (tumble_schedule_identify(&random.schedule, means.measured, &unidentified) != TUMBLE_OK) {
            assert_estimator_refuses(tumble_estimate_least_squares, &random.schedule, &means, TUMBLE_E_RANK,
                                     (tumble_refusal_t){0, unidentified});
            continue;
        }
        const tumble_coefficients_t expected = dense_least_squares(&random.schedule, &means);
        const tumble_coefficients_t estimate = estimate_with(tumble_estimate_least_squares, &random.schedule, &means);
        assert_coefficients(&expected, &estimate, 3e-15 / sqrt(weakest));
        solved++;
    }
    TEST_ASSERT_GREATER_THAN(150, solved);
}

/* Tilts of 20 and 20.2 degrees: the component along the axis is nearly as constant as the bias, condition 700. Plain
 * normal equations would be wrong by its square, 3e-11. */
static void test_a_weak_schedule_loses_digits_with_its_condition_only(void)
{
    static const tumble_mounting_t mountings[] = {
        {1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {20.0, 0.34202014332566871, 0.93969262078590843}, 0},
        {2, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {20.2, 0.34529819899853464, 0.93849302275955593}, 0},
    };
    static tumble_position_t positions[24];
    dice_t dice = {20};
    for (uint8_t p = 0; p < 24U; p++) {
        const uint8_t mounting = (uint8_t)(p / 12U + 1U);
        positions[p] = (tumble_position_t){mounting, p, TUMBLE_USE_FIT, steps_of_7_5_deg[4U * (p % 12U)]};
    }
    const tumble_schedule_t weak = {mountings, positions, 2, 24};
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&weak, NULL));
    for (int round = 0; round < 50; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        model_means(&weak, &block, &means);
        const tumble_coefficients_t estimate = estimate_with(tumble_estimate_least_squares, &weak, &means);
        assert_coefficients(&block, &estimate, 1e-16 * 700.0);
    }
}

static void test_it_names_what_cannot_be_identified(void)
{
    dice_t dice = {21};
    const tumble_coefficients_t block = random_block(&dice);
    model_means(&tumble_schedule_paper, &block, &means);
    for (int p = 9; p < 18; p++) {
        means.measured[p] = false;
    }
    assert_estimator_refuses(tumble_estimate_least_squares, &tumble_schedule_paper, &means, TUMBLE_E_RANK,
                             (tumble_refusal_t){0, 2});
    memset(means.measured, 0, sizeof means.measured);
    assert_estimator_refuses(tumble_estimate_least_squares, &tumble_schedule_paper, &means, TUMBLE_E_RANK,
                             (tumble_refusal_t){0, 15});
}

static void test_any_measured_positions_of_full_rank_will_do(void)
{
    dice_t dice = {22};
    const tumble_coefficients_t block = random_block(&dice);
    model_means(&tumble_schedule_paper, &block, &means);
    for (int p = 0; p < 18; p++) {
        means.measured[p] = (p == 0) || (p == 2) || (p == 6) || (p == 9);
        if (!means.measured[p]) {
            means.u_v[p][1] = NOT_A_NUMBER;
        }
    }
    const tumble_coefficients_t estimate = estimate_with(tumble_estimate_least_squares, &tumble_schedule_paper, &means);
    assert_coefficients(&block, &estimate, 2e-15);
}

static void test_it_refuses_null(void)
{
    assert_estimator_refuses_null(tumble_estimate_least_squares);
}

static void test_it_refuses_what_is_not_finite(void)
{
    assert_estimator_refuses_what_is_not_finite(tumble_estimate_least_squares);
    assert_estimator_has_the_documented_range(tumble_estimate_least_squares);
}

static void test_it_ignores_check_positions_and_what_was_not_measured(void)
{
    assert_estimator_ignores_what_is_not_for_it(tumble_estimate_least_squares);
}
