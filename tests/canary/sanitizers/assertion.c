/* A Unity test that holds for the argument 1.5 alone, as doubles. */
#include "unity.h"

#include <stdlib.h>

static double given;

void setUp(void) {}
void tearDown(void) {}

static void test_given_is_one_and_a_half(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 1.5, given);
}

int main(int count, char **arguments)
{
    given = (count > 1) ? atof(arguments[1]) : 0.0;
    UNITY_BEGIN();
    RUN_TEST(test_given_is_one_and_a_half);
    return UNITY_END();
}
