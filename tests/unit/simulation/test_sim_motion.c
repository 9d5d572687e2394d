/* The motion profile: closed form of the trapezoid, and what every plan must keep to. */
#include "simulation/motion.h"
#include "support.h"

#include <math.h>

static double position_at(const sim_motion_t *motion, double time_s)
{
    double position;
    double velocity;
    sim_motion_at(motion, time_s, &position, &velocity);
    return position;
}

static double velocity_at(const sim_motion_t *motion, double time_s)
{
    double position;
    double velocity;
    sim_motion_at(motion, time_s, &position, &velocity);
    return velocity;
}

/* 90 deg/s and 180 deg/s2, 180 degrees: 0.5 s and 22.5 degrees on either ramp, 1.5 s of cruise. */
static void test_trapezoid_in_closed_form(void)
{
    sim_motion_t motion;
    sim_motion_move(&motion, 10.0, 0.0, 190.0, 90.0, 180.0, 180.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2.5, motion.end_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 10.0 + 0.5 * 180.0 * 0.25 * 0.25, position_at(&motion, 0.25));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 45.0, velocity_at(&motion, 0.25));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 10.0 + 22.5 + 90.0 * 0.75, position_at(&motion, 1.25));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 90.0, velocity_at(&motion, 1.25));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 190.0 - 0.5 * 180.0 * 0.1 * 0.1, position_at(&motion, 2.4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 18.0, velocity_at(&motion, 2.4));
    ASSERT_SAME_DOUBLE(190.0, position_at(&motion, 2.5));
    ASSERT_SAME_DOUBLE(0.0, velocity_at(&motion, 1e6));
}

/* 45 degrees: never at full speed; 2 sqrt(d / a) = 1 s, peak sqrt(a d) = 90 deg/s just reached. 20 degrees: a triangle.
 */
static void test_triangle_in_closed_form(void)
{
    sim_motion_t motion;
    sim_motion_move(&motion, 0.0, 0.0, -20.0, 90.0, 180.0, 180.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2.0 * sqrt(20.0 / 180.0), motion.end_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -10.0, position_at(&motion, 0.5 * motion.end_s));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -sqrt(180.0 * 20.0), velocity_at(&motion, 0.5 * motion.end_s));
    ASSERT_SAME_DOUBLE(-20.0, position_at(&motion, motion.end_s));
}

/* Unequal ramps: peak^2 / 2a + peak^2 / 2d = distance. */
static void test_unequal_ramps(void)
{
    sim_motion_t motion;
    sim_motion_move(&motion, 0.0, 0.0, 30.0, 1000.0, 100.0, 50.0);
    const double peak = sqrt(2.0 * 30.0 * 100.0 * 50.0 / 150.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, peak / 100.0 + peak / 50.0, motion.end_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, peak, velocity_at(&motion, peak / 100.0));
}

static void test_no_way_to_go_takes_no_time(void)
{
    sim_motion_t motion;
    sim_motion_move(&motion, 45.0, 0.0, 45.0, 90.0, 180.0, 180.0);
    ASSERT_SAME_DOUBLE(0.0, motion.end_s);
    ASSERT_SAME_DOUBLE(45.0, position_at(&motion, 0.0));
    sim_motion_stop(&motion, 12.0, 0.0, 5.0);
    ASSERT_SAME_DOUBLE(0.0, motion.end_s);
    ASSERT_SAME_DOUBLE(12.0, motion.end_position);
}

/* From 60 deg/s with 120 deg/s2: 0.5 s, 15 degrees. */
static void test_stop_in_closed_form(void)
{
    sim_motion_t motion;
    sim_motion_stop(&motion, 100.0, -60.0, 120.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.5, motion.end_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 85.0, motion.end_position);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -30.0, velocity_at(&motion, 0.25));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 100.0 - 60.0 * 0.25 + 0.5 * 120.0 * 0.25 * 0.25, position_at(&motion, 0.25));
}

/* Too fast to stop before the target: it goes past by what braking takes, and comes back. */
static void test_a_target_passed_is_come_back_to(void)
{
    sim_motion_t motion;
    sim_motion_move(&motion, 0.0, 90.0, 5.0, 90.0, 180.0, 180.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 22.5, position_at(&motion, 0.5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, velocity_at(&motion, 0.5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.5 + 2.0 * sqrt(17.5 / 180.0), motion.end_s);
    ASSERT_SAME_DOUBLE(5.0, position_at(&motion, motion.end_s));
}

/* What holds for every plan: it begins where the axis is, position and velocity have no jumps and follow from each
 * other, neither speed nor acceleration is exceeded, and it ends at rest on the target. */
static void assert_sound(const sim_motion_t *motion, double from, double start, double target, double speed,
                         double acceleration)
{
    enum { STEPS = 400 };
    const double step = motion->end_s / (double)STEPS;
    const double most = (fabs(start) > speed) ? fabs(start) : speed;
    double position = from;
    double velocity = start;
    for (int n = 1; n <= STEPS; n++) {
        double next;
        double next_velocity;
        sim_motion_at(motion, step * n, &next, &next_velocity);
        TEST_ASSERT_TRUE(fabs(next_velocity) <= most * (1.0 + 1e-9));
        TEST_ASSERT_TRUE(fabs(next_velocity - velocity) <= acceleration * step * (1.0 + 1e-6) + 1e-9);
        TEST_ASSERT_TRUE(fabs(next - position - 0.5 * (velocity + next_velocity) * step) <=
                         acceleration * step * step + 1e-9);
        position = next;
        velocity = next_velocity;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, target, position);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, velocity);
    ASSERT_SAME_DOUBLE(target, motion->end_position);
}

static void test_any_plan_is_sound(void)
{
    dice_t dice = {5};
    for (int n = 0; n < 3000; n++) {
        const double from = 400.0 * dice_signed_unit(&dice);
        const double target = 400.0 * dice_signed_unit(&dice);
        const double speed = 1.0 + 60.0 * (1.0 + dice_signed_unit(&dice));
        const double start = (n % 3 == 0) ? 0.0 : 1.5 * speed * dice_signed_unit(&dice);
        const double up = 10.0 + 200.0 * (1.0 + dice_signed_unit(&dice));
        const double down = 10.0 + 200.0 * (1.0 + dice_signed_unit(&dice));
        sim_motion_t motion;
        sim_motion_move(&motion, from, start, target, speed, up, down);
        assert_sound(&motion, from, start, target, speed, (up > down) ? up : down);
    }
}
