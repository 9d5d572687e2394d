/* maths.h - sine, cosine, exponential and logarithm that give the same bits on every host.
 *
 * The C library's own differ in the last bit from one version to the next, and a run must replay to the same bytes
 * anywhere. These use + - x / on IEEE 754 doubles, exact scaling by powers of two and exact rounding alone. Errors are
 * within two units in the last place over the ranges given. Pure functions.
 */
#ifndef TUMBLE_SIMULATION_MATHS_H
#define TUMBLE_SIMULATION_MATHS_H

#include <float.h>
#include <stdint.h>

#if FLT_EVAL_METHOD != 0
#error "doubles must be computed as doubles"
#endif

#define SIM_PI 3.14159265358979323846
#define SIM_DEG_PER_RAD (180.0 / SIM_PI)

/* The nearest whole number, of two the even one; |x| below 2^31. Adding 1.5 x 2^52 leaves no room for fractions. */
static inline int32_t sim_nearest(double x)
{
    return (int32_t)((x + 6755399441055744.0) - 6755399441055744.0);
}

/* Exact at multiples of 90 degrees. |angle_deg| up to 1e11. */
void sim_sincos_deg(double angle_deg, double *sine, double *cosine);

/* e^x for x up to 700; 0 below -700. */
double sim_exp(double x);

/* Natural logarithm of a normal x > 0. */
double sim_log(double x);

#endif
