#include "core/turn.h"

/* Both series are good to a double's last bits. */
void tumble_turn(double x, double *sine, double *cosine)
{
    const double q = x * x;
    const double s =
        x * (1.0 + (q * ((-1.0 / 6.0) + (q * ((1.0 / 120.0) + (q * ((-1.0 / 5040.0) + (q * (1.0 / 362880.0)))))))));
    const double c_less_1 = q * (-0.5 + (q * ((1.0 / 24.0) + (q * ((-1.0 / 720.0) + (q * (1.0 / 40320.0)))))));
    const double before = *sine;
    *sine += (before * c_less_1) + (*cosine * s);
    *cosine += (*cosine * c_less_1) - (before * s);
}
