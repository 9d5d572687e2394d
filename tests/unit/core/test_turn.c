/* The small turn, which has no library behind it, against the library's sine and cosine. */
#include "core/turn.h"
#include "suite.h"
#include "tumble/core.h"

#include <math.h>

static void test_an_angle_is_turned_as_the_library_says(void)
{
    const int steps = 1000;
    for (int i = -steps; i <= steps; i++) {
        const double x = TUMBLE_MAX_STAND_ERROR_RAD * i / steps;
        for (int k = 0; k < 7; k++) {
            double sine = sin(k);
            double cosine = cos(k);
            tumble_turn(x, &sine, &cosine);
            TEST_ASSERT_DOUBLE_WITHIN(5e-16, sin(k + x), sine);
            TEST_ASSERT_DOUBLE_WITHIN(5e-16, cos(k + x), cosine);
        }
    }
}

static void test_a_vector_is_turned_from_a_towards_b(void)
{
    double a = 3.0;
    double b = 0.0;
    tumble_turn(0.1, &a, &b);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 3.0 * cos(0.1), a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, -3.0 * sin(0.1), b);
    tumble_turn(0.0, &a, &b);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 3.0 * cos(0.1), a);
}
