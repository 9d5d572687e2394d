/* vector.h - products of vectors with three components. */
#ifndef TUMBLE_CORE_VECTOR_H
#define TUMBLE_CORE_VECTOR_H

#include "core/arith.h"

/* (a0 b0 + a1 b1) + a2 b2, in this order. */
double tumble_dot(const double a[3], const double b[3]);

/* c = a x b; it must not be one of them. */
void tumble_cross(const double a[3], const double b[3], double c[3]);

/* The largest component, without its sign; inline, so that it costs nothing where it stands alone. */
static inline double tumble_largest(const double a[3])
{
    double largest = 0.0;
    for (int j = 0; j < 3; j++) {
        largest = tumble_larger(tumble_abs(a[j]), largest);
    }
    return largest;
}

#endif
