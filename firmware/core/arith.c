#include "core/arith.h"

bool tumble_is_finite(double x)
{
    return (x - x) == 0.0;
}

bool tumble_is_positive(double x)
{
    return (x > 0.0) && tumble_is_finite(x);
}

bool tumble_within(double x, double bound)
{
    return (x <= bound) && (x >= -bound);
}
