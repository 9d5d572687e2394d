/* Closure of a mounting, and what the ideal geometry leaves unexplained. */
#include "model.h"
#include "random_schedule.h"
#include "six_faces.h"
#include "tumble/core.h"

static tumble_means_t means;

static void random_means(dice_t *dice)
{
    for (int p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        means.measured[p] = true;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            means.u_v[p][i] = dice_signed_unit(dice);
        }
    }
}

static void set_up(void)
{
    dice_t dice = {50};
    random_means(&dice);
}

static void assert_closure(const tumble_schedule_t *schedule, uint8_t mounting, int late, int early)
{
    double difference[3];
    ASSERT_STATUS(TUMBLE_OK, tumble_closure(schedule, &means, mounting, difference));
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        ASSERT_SAME_DOUBLE(means.u_v[late][i] - means.u_v[early][i], difference[i]);
    }
}

static void assert_no_closure(const tumble_schedule_t *schedule, uint8_t mounting)
{
    double difference[3] = {7, 7, 7};
    ASSERT_STATUS(TUMBLE_E_MISSING_POSITION, tumble_closure(schedule, &means, mounting, difference));
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        ASSERT_SAME_DOUBLE(7.0, difference[i]);
    }
}

static void test_closure_of_the_paper_is_the_ninth_less_the_first(void)
{
    assert_closure(&tumble_schedule_paper, 1, 8, 0);
    assert_closure(&tumble_schedule_paper, 2, 17, 9);
}

static void test_closure_needs_a_pair_that_was_measured(void)
{
    static const int ends[] = {0, 8, 9, 17};
    for (size_t i = 0; i < COUNT_OF(ends); i++) {
        means.measured[ends[i]] = false;
        assert_no_closure(&tumble_schedule_paper, (ends[i] < 9) ? 1 : 2);
        means.measured[ends[i]] = true;
    }
    assert_no_closure(&tumble_schedule_paper, 3);
    for (uint8_t mounting = 1; mounting <= 3U; mounting++) {
        assert_no_closure(&six_faces, mounting);
    }
}

/* 0, 90, -270, 360, 450, 45 degrees: the last that closes is 450 on 90. */
static void test_closure_goes_by_attitude_and_takes_the_last_pair(void)
{
    static const tumble_position_t positions[] = {
        {2, 1, TUMBLE_USE_FIT, {0, 0, 1}},     {2, 2, TUMBLE_USE_FIT, {90, 1, 0}},
        {1, 3, TUMBLE_USE_FIT, {90, 1, 0}},    {2, 3, TUMBLE_USE_CHECK, {-270, 1, 0}},
        {2, 4, TUMBLE_USE_FIT, {360, 0, 1}},   {2, 5, TUMBLE_USE_FIT, {450, 1, 0}},
        {1, 6, TUMBLE_USE_FIT, {180, 0, -1}},  {2, 7, TUMBLE_USE_FIT, {270, -1, 0}},
        {2, 8, TUMBLE_USE_FIT, {-180, 0, -1}},
    };
    const tumble_schedule_t schedule = {tumble_schedule_paper.mountings, positions, 2, COUNT_OF(positions)};
    ASSERT_STATUS(TUMBLE_OK, tumble_schedule_validate(&schedule, NULL));
    assert_closure(&schedule, 2, 5, 1);
    means.measured[1] = false;
    assert_closure(&schedule, 2, 5, 3);
    means.measured[5] = false;
    assert_closure(&schedule, 2, 4, 0);
    means.measured[0] = false;
    assert_no_closure(&schedule, 2);
    assert_no_closure(&schedule, 1);
}

static void test_closure_refuses_null(void)
{
    double difference[3];
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_closure(NULL, &means, 1, difference));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_closure(&tumble_schedule_paper, NULL, 1, difference));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_closure(&tumble_schedule_paper, &means, 1, NULL));
}

static dd_t residual_at(const tumble_schedule_t *schedule, const tumble_coefficients_t *block, unsigned position,
                        int channel)
{
    dd_t a[3];
    model_attitude(schedule, position, a);
    return dd_add(dd_of(means.u_v[position][channel]), dd_negate(model_output(block, channel, a)));
}

static void test_residuals_are_what_the_model_leaves(void)
{
    static random_schedule_t random;
    dice_t dice = {51};
    for (int round = 0; round < 100; round++) {
        random_schedule(&dice, &random);
        random_means(&dice);
        const tumble_coefficients_t block = random_block(&dice);
        for (uint8_t p = 0; p < random.schedule.position_count; p++) {
            double residual[3];
            tumble_residual(&random.schedule, &means, &block, p, residual);
            for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                const double expected = dd_round(residual_at(&random.schedule, &block, p, i));
                TEST_ASSERT_DOUBLE_WITHIN(3e-15, expected, residual[i]);
            }
        }
    }
}

static void test_the_root_mean_square_is_that_of_the_measured_fit_positions(void)
{
    static random_schedule_t random;
    dice_t dice = {52};
    int enough = 0;
    int too_few = 0;
    for (int round = 0; round < 200; round++) {
        random_schedule(&dice, &random);
        random_means(&dice);
        const tumble_coefficients_t block = random_block(&dice);
        double squares[3] = {0, 0, 0};
        double rms[3] = {7, 7, 7};
        int n = 0;
        for (unsigned p = 0; p < random.schedule.position_count; p++) {
            means.measured[p] = dice_below(&dice, 4) != 0U;
            const bool counts = means.measured[p] && random.positions[p].use == TUMBLE_USE_FIT;
            for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                const double residual = dd_round(residual_at(&random.schedule, &block, p, i));
                squares[i] += counts ? residual * residual : 0.0;
            }
            n += counts ? 1 : 0;
        }
        const tumble_status_t expected = (n < 5) ? TUMBLE_E_TOO_FEW : TUMBLE_OK;
        ASSERT_STATUS(expected, tumble_residual_rms(&random.schedule, &means, &block, rms));
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const double value = (n < 5) ? 7.0 : sqrt(squares[i] / (double)(n - 4));
            TEST_ASSERT_DOUBLE_WITHIN(1e-14 * value, value, rms[i]);
        }
        enough += (n < 5) ? 0 : 1;
        too_few += (n == 4) ? 1 : 0;
    }
    TEST_ASSERT_GREATER_THAN(50, enough);
    TEST_ASSERT_GREATER_THAN(3, too_few);
}

static void test_five_positions_leave_one_degree_of_freedom(void)
{
    const tumble_coefficients_t block = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    model_means(&tumble_schedule_paper, &block, &means);
    for (int p = 0; p < 18; p++) {
        means.measured[p] = p < 4;
    }
    double rms[3];
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_residual_rms(&tumble_schedule_paper, &means, &block, rms));
    means.measured[17] = true;
    means.u_v[17][1] += 3.0;
    means.u_v[0][1] += 4.0;
    ASSERT_STATUS(TUMBLE_OK, tumble_residual_rms(&tumble_schedule_paper, &means, &block, rms));
    ASSERT_SAME_DOUBLE(0.0, rms[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 5.0, rms[1]);
}

static void test_the_root_mean_square_refuses_null(void)
{
    const tumble_coefficients_t block = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    double rms[3];
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_residual_rms(NULL, &means, &block, rms));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_residual_rms(&tumble_schedule_paper, NULL, &block, rms));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_residual_rms(&tumble_schedule_paper, &means, NULL, rms));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_residual_rms(&tumble_schedule_paper, &means, &block, NULL));
}
