/* double_double.h - numbers of about 31 digits as unevaluated sums of two doubles, for oracles.
 *
 * Error-free transformations (Dekker 1971, Knuth TAOCP 2): they need round-to-nearest and -ffp-contract=off, and give
 * the same bits on every machine, unlike long double.
 */
#ifndef TUMBLE_TESTS_UNIT_DOUBLE_DOUBLE_H
#define TUMBLE_TESTS_UNIT_DOUBLE_DOUBLE_H

typedef struct {
    double high;
    double low;
} dd_t;

static inline dd_t dd_of(double x)
{
    return (dd_t){x, 0.0};
}

static inline double dd_round(dd_t x)
{
    return x.high + x.low;
}

static inline dd_t dd_two_sum(double x, double y)
{
    const double sum = x + y;
    const double part = sum - x;
    return (dd_t){sum, (x - (sum - part)) + (y - part)};
}

static inline dd_t dd_split(double x)
{
    const double scaled = 134217729.0 * x; /* 2^27 + 1 */
    const double high = scaled - (scaled - x);
    return (dd_t){high, x - high};
}

static inline dd_t dd_two_product(double x, double y)
{
    const double product = x * y;
    const dd_t p = dd_split(x);
    const dd_t q = dd_split(y);
    return (dd_t){product, ((p.high * q.high - product) + p.high * q.low + p.low * q.high) + p.low * q.low};
}

static inline dd_t dd_add(dd_t x, dd_t y)
{
    const dd_t high = dd_two_sum(x.high, y.high);
    const dd_t low = dd_two_sum(x.low, y.low);
    const dd_t middle = dd_two_sum(high.high, high.low + low.high);
    return dd_two_sum(middle.high, middle.low + low.low);
}

static inline dd_t dd_negate(dd_t x)
{
    return (dd_t){-x.high, -x.low};
}

static inline dd_t dd_multiply(dd_t x, dd_t y)
{
    const dd_t product = dd_two_product(x.high, y.high);
    return dd_two_sum(product.high, product.low + (x.high * y.low + x.low * y.high));
}

static inline dd_t dd_divide(dd_t x, dd_t y)
{
    const double first = x.high / y.high;
    const dd_t rest = dd_add(x, dd_negate(dd_multiply(y, dd_of(first))));
    const double second = rest.high / y.high;
    const dd_t last = dd_add(rest, dd_negate(dd_multiply(y, dd_of(second))));
    return dd_add(dd_two_sum(first, second), dd_of(last.high / y.high));
}

#endif
