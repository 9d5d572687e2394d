/* Angles come with their sine and cosine, and the three must agree. */
#include "model.h"

static tumble_mounting_t mountings[1];
static tumble_position_t positions[2];
static const tumble_schedule_t schedule = {mountings, positions, 1, 2};

static void set_up(void)
{
    mountings[0] = (tumble_mounting_t){1, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, LEVEL, 0};
    positions[0] = (tumble_position_t){1, 1, TUMBLE_USE_FIT, LEVEL};
    positions[1] = (tumble_position_t){1, 2, TUMBLE_USE_FIT, LEVEL};
}

/* As the angle of the table, and as the tilt of the axis. */
static void assert_angle(tumble_status_t expected, double deg, double sine, double cosine)
{
    uint8_t where = 99;
    positions[1].angle = (tumble_angle_t){deg, sine, cosine};
    ASSERT_STATUS(expected, tumble_schedule_validate(&schedule, &where));
    if (expected != TUMBLE_OK) {
        TEST_ASSERT_EQUAL_UINT8(1, where);
    }
    positions[1].angle = (tumble_angle_t)LEVEL;
    mountings[0].tilt = (tumble_angle_t){deg, sine, cosine};
    ASSERT_STATUS(expected, tumble_schedule_validate(&schedule, &where));
    if (expected != TUMBLE_OK) {
        TEST_ASSERT_EQUAL_UINT8(0, where);
    }
    mountings[0].tilt = (tumble_angle_t)LEVEL;
}

static const tumble_angle_t assorted[] = {
    {22.5, 0.38268343236508978, 0.92387953251128674},
    {-22.5, -0.38268343236508978, 0.92387953251128674},
    {-45.0, -0.70710678118654757, 0.70710678118654757},
    {30.0, 0.5, 0.8660254037844386},
    {123.456, 0.83430943331480656, -0.55129644428558244},
    {-123.456, -0.83430943331480656, -0.55129644428558244},
    {720.0, 0.0, 1.0},
    {-720.0, 0.0, 1.0},
    {3600.0, 0.0, 1.0},
    {-3600.0, 0.0, 1.0},
    {3577.5, -0.38268343236508978, 0.92387953251128674},
    {3599.999, -1.7453292522612904e-05, 0.99999999984769128},
    {-3599.999, 1.7453292522612904e-05, 0.99999999984769128},
    {-2879.3, 0.012217000835243994, 0.99992536966045198},
    {404.999, 0.70709443973735508, 0.70711912242034292},
    {1e-07, 1.7453292519943295e-09, 1.0},
    {44.999999999, 0.70710678117420622, 0.70710678119888881},
    {45.000000001, 0.70710678119888881, 0.70710678117420622},
    {89.999999, 0.99999999999999989, 1.7453292475877967e-08},
    {90.000001, 0.99999999999999989, -1.7453292475877967e-08},
    {179.99, 0.00017453292431317805, -0.9999999847691291},
};

static void test_angles_that_agree_are_accepted(void)
{
    for (size_t i = 0; i < COUNT_OF(assorted); i++) {
        assert_angle(TUMBLE_OK, assorted[i].deg, assorted[i].sine, assorted[i].cosine);
    }
}

static void test_every_turn_of_every_step_is_accepted(void)
{
    for (int turn = -10; turn < 10; turn++) {
        for (int i = 0; i < STEP_COUNT; i++) {
            const tumble_angle_t *step = &steps_of_7_5_deg[i];
            assert_angle(TUMBLE_OK, step->deg + 360.0 * (double)turn, step->sine, step->cosine);
        }
    }
}

static void test_an_error_in_the_sine_or_the_cosine_is_refused(void)
{
    static const double errors[] = {1e-9, -1e-9, 1.1e-12, -1.1e-12, 2e-3, NOT_A_NUMBER, INFINITE, -INFINITE};
    for (size_t i = 0; i < COUNT_OF(assorted); i++) {
        const tumble_angle_t *angle = &assorted[i];
        for (size_t e = 0; e < COUNT_OF(errors); e++) {
            assert_angle(TUMBLE_E_SCHEDULE_ANGLE, angle->deg, angle->sine + errors[e], angle->cosine);
            assert_angle(TUMBLE_E_SCHEDULE_ANGLE, angle->deg, angle->sine, angle->cosine + errors[e]);
        }
    }
}

static void test_an_error_within_1e_12_is_accepted(void)
{
    for (size_t i = 0; i < COUNT_OF(assorted); i++) {
        const tumble_angle_t *angle = &assorted[i];
        assert_angle(TUMBLE_OK, angle->deg, angle->sine + 9e-13, angle->cosine - 9e-13);
        assert_angle(TUMBLE_OK, angle->deg, angle->sine - 9e-13, angle->cosine + 9e-13);
    }
}

/* Sine and cosine of some other angle: each pair is on the unit circle. */
static void test_sine_and_cosine_of_another_angle_are_refused(void)
{
    for (int i = 0; i < STEP_COUNT; i++) {
        const tumble_angle_t *step = &steps_of_7_5_deg[i];
        assert_angle(TUMBLE_E_SCHEDULE_ANGLE, step->deg + 6e-8, step->sine, step->cosine); /* 1e-9 rad */
        assert_angle(TUMBLE_E_SCHEDULE_ANGLE, step->deg - 6e-8, step->sine, step->cosine);
        assert_angle(TUMBLE_E_SCHEDULE_ANGLE, step->deg, -step->sine, -step->cosine);
        assert_angle(TUMBLE_E_SCHEDULE_ANGLE, step->deg, -step->cosine, step->sine);
        if (i % (STEP_COUNT / 2) != 0) {
            assert_angle(TUMBLE_E_SCHEDULE_ANGLE, step->deg, -step->sine, step->cosine);
        }
        if (i % (STEP_COUNT / 2) != STEP_COUNT / 4) {
            assert_angle(TUMBLE_E_SCHEDULE_ANGLE, step->deg, step->sine, -step->cosine);
        }
        if (i % (STEP_COUNT / 2) != STEPS_PER_45_DEG) {
            assert_angle(TUMBLE_E_SCHEDULE_ANGLE, step->deg, step->cosine, step->sine);
        }
    }
}

static void test_angles_out_of_range_are_refused(void)
{
    assert_angle(TUMBLE_E_SCHEDULE_ANGLE, one_ulp_beyond(3600.0), 0.0, 1.0);
    assert_angle(TUMBLE_E_SCHEDULE_ANGLE, one_ulp_beyond(-3600.0), 0.0, 1.0);
    assert_angle(TUMBLE_E_SCHEDULE_ANGLE, 3960.0, 0.0, 1.0);
    assert_angle(TUMBLE_E_SCHEDULE_ANGLE, 1e300, 0.0, 1.0);
    assert_angle(TUMBLE_E_SCHEDULE_ANGLE, -1e300, 0.0, 1.0);
    assert_angle(TUMBLE_E_SCHEDULE_ANGLE, NOT_A_NUMBER, 0.0, 1.0);
    assert_angle(TUMBLE_E_SCHEDULE_ANGLE, INFINITE, 0.0, 1.0);
    assert_angle(TUMBLE_E_SCHEDULE_ANGLE, -INFINITE, 0.0, 1.0);
}

static void test_the_first_angle_at_fault_is_named(void)
{
    uint8_t where = 99;
    positions[0].angle.cosine = 0.5;
    positions[1].angle.cosine = 0.5;
    ASSERT_STATUS(TUMBLE_E_SCHEDULE_ANGLE, tumble_schedule_validate(&schedule, &where));
    TEST_ASSERT_EQUAL_UINT8(0, where);
    ASSERT_STATUS(TUMBLE_E_SCHEDULE_ANGLE, tumble_schedule_validate(&schedule, NULL));
}
