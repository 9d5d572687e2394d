/* The weighted straight line against the textbook's sums, and what is refused. */
#include "support.h"
#include "tumble/sets.h"

static tumble_trend_sums_t sums;
static tumble_trend_t trend;

static void set_up(void)
{
    sums = (tumble_trend_sums_t){0};
}

static void assert_near(double expected, double value, double tolerance)
{
    TEST_ASSERT_TRUE(magnitude(value - expected) <= tolerance);
}

/* Slope, its uncertainty and chi-squared by sums over long double, months counted from a fixed date. */
static void by_the_textbook(const double *months, const double *values, const double *u, int count, double expected[3])
{
    long double s = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, chi = 0;
    for (int i = 0; i < count; i++) {
        const long double w = 1.0L / ((long double)u[i] * u[i]);
        s += w;
        sx += w * months[i];
        sy += w * values[i];
        sxx += w * months[i] * months[i];
        sxy += w * months[i] * values[i];
    }
    const long double d = s * sxx - sx * sx;
    const long double slope = (s * sxy - sx * sy) / d;
    const long double zero = (sy - slope * sx) / s;
    for (int i = 0; i < count; i++) {
        const long double r = (values[i] - zero - slope * months[i]) / u[i];
        chi += r * r;
    }
    expected[0] = (double)slope;
    expected[1] = (double)sqrtl(s / d);
    expected[2] = (double)chi;
}

static void test_the_line_is_the_textbooks(void)
{
    dice_t dice = {7};
    for (int round = 0; round < 500; round++) {
        double months[20], values[20], u[20], expected[3];
        const int count = dice_between(&dice, 3, 20);
        set_up();
        for (int i = 0; i < count; i++) {
            const uint64_t date = 1790000000U + dice_below(&dice, 100000000U);
            months[i] = (double)(date - 1790000000U) / TUMBLE_MONTH_S;
            u[i] = 1e-6 * (1.0 + 9.0 * magnitude(dice_signed_unit(&dice)));
            values[i] = 1.25 + 3e-6 * months[i] + 2.0 * u[i] * dice_signed_unit(&dice);
            assert_status(TUMBLE_OK, tumble_trend_add(&sums, date, values[i], u[i]));
        }
        by_the_textbook(months, values, u, count, expected);
        assert_status(TUMBLE_OK, tumble_trend_fit(&sums, &trend));
        assert_near(expected[0], trend.per_month, 1e-8 * expected[1]);
        assert_near(expected[1], trend.u_per_month, 1e-12 * expected[1]);
        assert_near(expected[2], trend.chi_squared, 1e-7 * (1.0 + expected[2]));
        TEST_ASSERT_EQUAL_UINT32(count - 2, trend.freedom);
    }
}

static void test_two_points_make_a_line(void)
{
    assert_status(TUMBLE_OK, tumble_trend_add(&sums, 1800000000U + 2629746U, 3.0, 0.3));
    assert_status(TUMBLE_E_TOO_FEW, tumble_trend_fit(&sums, &trend));
    assert_status(TUMBLE_OK, tumble_trend_add(&sums, 1800000000U, 1.0, 0.4));
    assert_status(TUMBLE_OK, tumble_trend_fit(&sums, &trend));
    assert_near(2.0, trend.per_month, 1e-14);
    assert_near(0.5, trend.u_per_month, 1e-15);
    assert_near(0.0, trend.chi_squared, 1e-12);
    TEST_ASSERT_EQUAL_UINT32(0, trend.freedom);
}

static void test_one_date_is_no_trend(void)
{
    for (int i = 0; i < 5; i++) {
        assert_status(TUMBLE_OK, tumble_trend_add(&sums, 1800000000U, 1.0 + i, 0.1));
    }
    assert_status(TUMBLE_E_TOO_FEW, tumble_trend_fit(&sums, &trend));
}

static void test_what_is_no_value_is_refused(void)
{
    assert_status(TUMBLE_E_ARGUMENT, tumble_trend_add(NULL, 1, 1.0, 1.0));
    assert_status(TUMBLE_E_ARGUMENT, tumble_trend_add(&sums, 0, 1.0, 1.0));
    assert_status(TUMBLE_E_ARGUMENT, tumble_trend_add(&sums, 1, 1.0, 0.0));
    assert_status(TUMBLE_E_ARGUMENT, tumble_trend_add(&sums, 1, 1.0, -1.0));
    assert_status(TUMBLE_E_NOT_FINITE, tumble_trend_add(&sums, 1, NOT_A_NUMBER, 1.0));
    assert_status(TUMBLE_E_NOT_FINITE, tumble_trend_add(&sums, 1, 1.1e100, 1.0));
    assert_status(TUMBLE_E_NOT_FINITE, tumble_trend_add(&sums, 1, 1.0, NOT_A_NUMBER));
    assert_status(TUMBLE_E_NOT_FINITE, tumble_trend_add(&sums, 1, 1.0, INFINITE));
    assert_status(TUMBLE_E_NOT_FINITE, tumble_trend_add(&sums, 1, 1.0, 1e-101));
    TEST_ASSERT_EQUAL_UINT32(0, sums.count);
    assert_status(TUMBLE_E_ARGUMENT, tumble_trend_fit(NULL, &trend));
    assert_status(TUMBLE_E_ARGUMENT, tumble_trend_fit(&sums, NULL));
}

static void test_an_overflow_is_no_trend(void)
{
    assert_status(TUMBLE_OK, tumble_trend_add(&sums, 1, -1e100, 1e-100));
    assert_status(TUMBLE_OK, tumble_trend_add(&sums, 9999999, 1e100, 1e-100));
    assert_status(TUMBLE_E_NOT_FINITE, tumble_trend_fit(&sums, &trend));
}
