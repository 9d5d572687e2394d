/* The square root that the Cortex-M4 board brings along: the same bits as this machine's, which is IEEE 754's. */
#define sqrt board_sqrt
#include "../../boards/mps2_an386/root.c"
#undef sqrt

#include "suite.h"
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>

static double from_bits(uint64_t bits)
{
    double x;

    memcpy(&x, &bits, sizeof x);
    return x;
}

static void agrees(double x)
{
    const double wanted = sqrt(x);
    const double found = board_sqrt(x);
    char message[64];

    (void)snprintf(message, sizeof message, "root of %a", x);
    if (isnan(wanted)) {
        TEST_ASSERT_TRUE_MESSAGE(isnan(found), message);
    } else {
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&wanted, &found, sizeof wanted, message);
    }
}

static void test_special_numbers(void)
{
    const double cases[] = {0.0,
                            -0.0,
                            INFINITY,
                            -INFINITY,
                            NAN,
                            -1.0,
                            -DBL_MIN,
                            -4.9e-324,
                            DBL_MIN,
                            DBL_MAX,
                            4.9e-324,
                            1.0,
                            2.0,
                            4.0,
                            1.0 + DBL_EPSILON,
                            1.0 - (DBL_EPSILON / 2.0),
                            2.0 - DBL_EPSILON,
                            0.25};

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        agrees(cases[i]);
    }
}

static void test_every_power_of_two_and_its_neighbours(void)
{
    for (int exponent = -1074; exponent <= 1023; exponent++) {
        const double x = ldexp(1.0, exponent);

        agrees(x);
        agrees(nextafter(x, 0.0));
        agrees(nextafter(x, INFINITY));
    }
}

/* Exact squares, and what lies beside them: there the last bit is decided by the remainder alone. */
static void test_squares_and_their_neighbours(void)
{
    for (uint64_t root = 1; root < (UINT64_C(1) << 26); root += 997U) {
        const double square = (double)(root * root);

        TEST_ASSERT_TRUE(board_sqrt(square) == (double)root);
        agrees(nextafter(square, 0.0));
        agrees(nextafter(square, INFINITY));
    }
}

static void test_random_numbers_of_any_size(void)
{
    uint64_t state = UINT64_C(0x9E3779B97F4A7C15);

    for (int i = 0; i < 1000000; i++) {
        state ^= state << 13; /* xorshift */
        state ^= state >> 7;
        state ^= state << 17;
        agrees(from_bits(state));
        agrees(from_bits(state & UINT64_C(0x000FFFFFFFFFFFFF)));
    }
}
