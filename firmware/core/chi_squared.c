#include "tumble/core.h"

#include "core/arith.h"

double tumble_chi_squared_limit(double freedom, double sigmas)
{
    const double part = 2.0 / (9.0 * freedom);
    const double root = 1.0 - part + (sigmas * tumble_sqrt(part));
    return freedom * root * root * root;
}
