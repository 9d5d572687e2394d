/* The gravity check, closure, and residuals. */
#include "model.h"
#include "random_schedule.h"
#include "tumble/core.h"

static tumble_position_t positions[TUMBLE_MAX_POSITIONS];
static tumble_schedule_t schedule; /* the paper's and two check positions, 18 and 19 */
static tumble_means_t means;
static tumble_coefficients_t block;
static tumble_calibration_t calibration;
static tumble_gravity_check_t check;

static void set_up(void)
{
    dice_t dice = {40};
    memcpy(positions, tumble_schedule_paper.positions, 18U * sizeof positions[0]);
    positions[18] = (tumble_position_t){1, 101, TUMBLE_USE_CHECK, steps_of_7_5_deg[3]};
    positions[19] = (tumble_position_t){2, 101, TUMBLE_USE_CHECK, steps_of_7_5_deg[9]};
    schedule = (tumble_schedule_t){tumble_schedule_paper.mountings, positions, 2, 20};
    block = random_block(&dice);
    model_means(&schedule, &block, &means);
    ASSERT_STATUS(TUMBLE_OK, tumble_calibration_invert(&block, &calibration));
}

static void judge(double limit_g)
{
    memset(&check, 0x5A, sizeof check);
    ASSERT_STATUS(TUMBLE_OK, tumble_gravity_check(&schedule, &means, &calibration, limit_g, &check));
}

/* As if gravity at a position were `factor` g. */
static void scale_gravity_at(unsigned position, double factor)
{
    dd_t a[3];
    model_attitude(&schedule, position, a);
    for (int axis = 0; axis < 3; axis++) {
        a[axis] = dd_multiply(a[axis], dd_of(factor));
    }
    for (int i = 0; i < 3; i++) {
        means.u_v[position][i] = dd_round(model_output(&block, i, a));
    }
}

static void test_an_ideal_run_has_no_gravity_error(void)
{
    dice_t dice = {41};
    for (int round = 0; round < 300; round++) {
        block = random_block(&dice);
        model_means(&schedule, &block, &means);
        ASSERT_STATUS(TUMBLE_OK, tumble_calibration_invert(&block, &calibration));
        judge(1e-14);
        TEST_ASSERT_TRUE(check.pass);
        TEST_ASSERT_EQUAL_UINT8(18, check.fit_positions);
        TEST_ASSERT_EQUAL_UINT8(2, check.check_positions);
    }
}

static void test_the_gravity_error_has_its_sign_and_size(void)
{
    scale_gravity_at(4, 1.0 + 1e-3);
    scale_gravity_at(12, 1.0 - 2e-3);
    scale_gravity_at(19, 1.0 - 4e-3);
    judge(3e-4);
    TEST_ASSERT_FALSE(check.pass);
    for (int p = 0; p < 20; p++) {
        const double e = (p == 4) ? 1e-3 : (p == 12) ? -2e-3 : (p == 19) ? -4e-3 : 0.0;
        TEST_ASSERT_DOUBLE_WITHIN(1e-14, e + 0.5 * e * e, check.delta_g_g[p]);
    }
    ASSERT_SAME_DOUBLE(-check.delta_g_g[12], check.max_abs_fit_g);
    ASSERT_SAME_DOUBLE(-check.delta_g_g[19], check.max_abs_check_g);
}

static void test_fit_and_check_positions_are_kept_apart(void)
{
    scale_gravity_at(18, 1.0 + 1e-3);
    judge(5e-4);
    TEST_ASSERT_FALSE(check.pass);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.0, check.max_abs_fit_g);
    ASSERT_SAME_DOUBLE(check.delta_g_g[18], check.max_abs_check_g);
    model_means(&schedule, &block, &means);
    scale_gravity_at(0, 1.0 + 1e-3);
    judge(5e-4);
    TEST_ASSERT_FALSE(check.pass);
    TEST_ASSERT_DOUBLE_WITHIN(1e-14, 0.0, check.max_abs_check_g);
    ASSERT_SAME_DOUBLE(check.delta_g_g[0], check.max_abs_fit_g);
    judge(2e-3);
    TEST_ASSERT_TRUE(check.pass);
}

static void test_only_measured_positions_are_judged(void)
{
    means.u_v[0][0] = NOT_A_NUMBER;
    means.measured[0] = false;
    means.u_v[18][2] = INFINITE;
    means.measured[18] = false;
    judge(1e-9);
    TEST_ASSERT_TRUE(check.pass);
    TEST_ASSERT_EQUAL_UINT8(17, check.fit_positions);
    TEST_ASSERT_EQUAL_UINT8(1, check.check_positions);
    ASSERT_SAME_DOUBLE(0.0, check.delta_g_g[0]);
    ASSERT_SAME_DOUBLE(0.0, check.delta_g_g[18]);
}

static void test_rows_beyond_the_schedule_are_not_read(void)
{
    for (int p = 20; p < TUMBLE_MAX_POSITIONS; p++) {
        means.measured[p] = true;
        means.u_v[p][0] = NOT_A_NUMBER;
    }
    judge(1e-9);
    TEST_ASSERT_TRUE(check.pass);
    TEST_ASSERT_EQUAL_UINT8(18, check.fit_positions);
    TEST_ASSERT_EQUAL_UINT8(2, check.check_positions);
    for (int p = 20; p < TUMBLE_MAX_POSITIONS; p++) {
        ASSERT_SAME_DOUBLE(0.0, check.delta_g_g[p]);
    }
}

static void test_one_kind_of_position_is_enough_to_pass_and_none_is_not(void)
{
    for (int p = 0; p < 20; p++) {
        means.measured[p] = p == 19;
    }
    judge(1e-9);
    TEST_ASSERT_TRUE(check.pass);
    TEST_ASSERT_EQUAL_UINT8(0, check.fit_positions);
    ASSERT_SAME_DOUBLE(0.0, check.max_abs_fit_g);
    for (int p = 0; p < 20; p++) {
        means.measured[p] = p == 5;
    }
    judge(1e-9);
    TEST_ASSERT_TRUE(check.pass);
    TEST_ASSERT_EQUAL_UINT8(0, check.check_positions);
    ASSERT_SAME_DOUBLE(0.0, check.max_abs_check_g);
    means.measured[5] = false;
    judge(1e-9);
    TEST_ASSERT_FALSE(check.pass);
    TEST_ASSERT_EQUAL_UINT8(0, check.fit_positions + check.check_positions);
}

/* With K = 1, (0, 0, 1.5) is 1.5 g and its error exactly 0.625 g; (0, 0, 0.5) is -0.375 g. */
static void test_the_limit_itself_passes(void)
{
    static const double identity[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    memcpy(calibration.k_inverse_g_per_v, identity, sizeof identity);
    memset(calibration.u0_v, 0, sizeof calibration.u0_v);
    for (int p = 0; p < 20; p++) {
        means.measured[p] = (p == 7) || (p == 18);
        means.u_v[p][0] = 0.0;
        means.u_v[p][1] = 0.0;
        means.u_v[p][2] = 1.5;
    }
    for (int use = 0; use < 2; use++) {
        means.u_v[(use == 0) ? 18 : 7][2] = 0.5;
        means.u_v[(use == 0) ? 7 : 18][2] = 1.5;
        judge(0.625);
        TEST_ASSERT_TRUE(check.pass);
        ASSERT_SAME_DOUBLE(0.625, (use == 0) ? check.max_abs_fit_g : check.max_abs_check_g);
        ASSERT_SAME_DOUBLE(0.375, (use == 0) ? check.max_abs_check_g : check.max_abs_fit_g);
        judge(one_ulp_within(0.625));
        TEST_ASSERT_FALSE(check.pass);
    }
    means.u_v[7][2] = 0.5;
    means.u_v[18][2] = 0.5;
    judge(0.375);
    TEST_ASSERT_TRUE(check.pass);
    judge(one_ulp_within(0.375));
    TEST_ASSERT_FALSE(check.pass);
}

static void test_a_bad_limit_and_null_pointers_are_refused(void)
{
    static const double bad[] = {0.0, -0.0, -3e-4, NOT_A_NUMBER, INFINITE, -INFINITE};
    tumble_gravity_check_t as_it_was;
    memset(&check, 0x5A, sizeof check);
    as_it_was = check;
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_gravity_check(&schedule, &means, &calibration, bad[i], &check));
    }
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_gravity_check(NULL, &means, &calibration, 1.0, &check));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_gravity_check(&schedule, NULL, &calibration, 1.0, &check));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_gravity_check(&schedule, &means, NULL, 1.0, &check));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_gravity_check(&schedule, &means, &calibration, 1.0, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &check, sizeof check);
}

static void assert_gravity_check_is_not_finite(void)
{
    memset(&check, 0x5A, sizeof check);
    ASSERT_STATUS(TUMBLE_E_NOT_FINITE, tumble_gravity_check(&schedule, &means, &calibration, 1.0, &check));
    TEST_ASSERT_FALSE(check.pass);
    TEST_ASSERT_EQUAL_UINT8(0, check.fit_positions + check.check_positions);
    ASSERT_SAME_DOUBLE(0.0, check.max_abs_fit_g + check.max_abs_check_g);
    for (int p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        ASSERT_SAME_DOUBLE(0.0, check.delta_g_g[p]);
    }
}

static void test_what_is_not_finite_is_refused_and_does_not_pass(void)
{
    static const double bad[] = {NOT_A_NUMBER, INFINITE, -INFINITE, 1e200};
    for (unsigned cell = 0; cell < 60U; cell++) {
        const double good = means.u_v[cell / 3U][cell % 3U];
        means.u_v[cell / 3U][cell % 3U] = bad[cell % COUNT_OF(bad)];
        assert_gravity_check_is_not_finite();
        means.u_v[cell / 3U][cell % 3U] = good;
    }
    calibration.k_inverse_g_per_v[1][2] = NOT_A_NUMBER;
    assert_gravity_check_is_not_finite();
    calibration.k_inverse_g_per_v[1][2] = 0.0;
    calibration.u0_v[2] = INFINITE;
    assert_gravity_check_is_not_finite();
}
