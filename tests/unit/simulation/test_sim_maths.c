/* The simulation's own sine, cosine, exponential and logarithm against the C library's, and exactly where exact. */
#include "simulation/maths.h"
#include "support.h"

#include <math.h>

static void test_quarter_turns_are_exact(void)
{
    static const double SINES[] = {0.0, 1.0, 0.0, -1.0};
    for (int quarter = -40; quarter <= 40; quarter++) {
        double sine;
        double cosine;
        sim_sincos_deg(90.0 * quarter, &sine, &cosine);
        ASSERT_SAME_DOUBLE(SINES[quarter & 3], sine);
        ASSERT_SAME_DOUBLE(SINES[(quarter + 1) & 3], cosine);
    }
}

static void test_sine_and_cosine_against_the_library(void)
{
    dice_t dice = {1};
    for (int n = 0; n < 200000; n++) {
        const double degrees = 45.0 * dice_signed_unit(&dice);
        const int quarter = dice_between(&dice, -20, 20);
        double sine;
        double cosine;
        sim_sincos_deg(degrees, &sine, &cosine);
        TEST_ASSERT_DOUBLE_WITHIN(4e-16 * fabs(sine), sin(degrees * (SIM_PI / 180.0)), sine);
        TEST_ASSERT_DOUBLE_WITHIN(2.3e-16, cos(degrees * (SIM_PI / 180.0)), cosine);
        double far_sine;
        double far_cosine;
        sim_sincos_deg(degrees + 90.0 * quarter, &far_sine, &far_cosine);
        TEST_ASSERT_DOUBLE_WITHIN(5e-16, 1.0, far_sine * far_sine + far_cosine * far_cosine);
        const double back = degrees + 90.0 * quarter - 90.0 * quarter;
        sim_sincos_deg(back, &sine, &cosine);
        ASSERT_SAME_DOUBLE(((quarter & 1) == 0) ? fabs(sine) : fabs(cosine), fabs(far_sine));
    }
}

static void test_exponential_against_the_library(void)
{
    dice_t dice = {2};
    ASSERT_SAME_DOUBLE(1.0, sim_exp(0.0));
    ASSERT_SAME_DOUBLE(0.0, sim_exp(-701.0));
    for (int n = 0; n < 200000; n++) {
        const double x = ((n % 2 == 0) ? 699.0 : 1.0) * dice_signed_unit(&dice);
        const double expected = exp(x);
        TEST_ASSERT_DOUBLE_WITHIN(5e-16 * expected, expected, sim_exp(x));
    }
}

static void test_logarithm_against_the_library(void)
{
    dice_t dice = {3};
    ASSERT_SAME_DOUBLE(0.0, sim_log(1.0));
    for (int n = 0; n < 200000; n++) {
        const double x = ldexp(1.5 + 0.5 * dice_signed_unit(&dice), dice_between(&dice, -1000, 1000));
        TEST_ASSERT_DOUBLE_WITHIN(4.5e-16 * fabs(log(x)), log(x), sim_log(x));
        const double near_one = 1.0 + 1e-3 * dice_signed_unit(&dice);
        TEST_ASSERT_DOUBLE_WITHIN(4.5e-16 * fabs(log(near_one)), log(near_one), sim_log(near_one));
    }
}
