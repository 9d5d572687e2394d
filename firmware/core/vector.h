/* vector.h - products of vectors with three components. */
#ifndef TUMBLE_CORE_VECTOR_H
#define TUMBLE_CORE_VECTOR_H

/* (a0 b0 + a1 b1) + a2 b2, in this order. */
double tumble_dot(const double a[3], const double b[3]);

/* c = a x b; it must not be one of them. */
void tumble_cross(const double a[3], const double b[3], double c[3]);

#endif
