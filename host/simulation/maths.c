#include "simulation/maths.h"

#include <stdint.h>
#include <string.h>

static const double RAD_PER_DEG = SIM_PI / 180.0;

/* Taylor series on |x| <= pi/4: the first term left out is below 1e-18 of the result. */
static double short_sine(double x)
{
    const double z = x * x;
    const double tail =
        z * (-1.0 / 6.0 +
             z * (1.0 / 120.0 + z * (-1.0 / 5040.0 + z * (1.0 / 362880.0 + z * (-1.0 / 39916800.0 +
                                                                                z * (1.0 / 6227020800.0 +
                                                                                     z * (-1.0 / 1307674368000.0)))))));
    return x + x * tail;
}

static double short_cosine(double x)
{
    const double z = x * x;
    const double tail =
        z * (1.0 / 24.0 +
             z * (-1.0 / 720.0 +
                  z * (1.0 / 40320.0 +
                       z * (-1.0 / 3628800.0 +
                            z * (1.0 / 479001600.0 + z * (-1.0 / 87178291200.0 + z * (1.0 / 20922789888000.0)))))));
    return 1.0 + z * (-0.5 + tail);
}

void sim_sincos_deg(double angle_deg, double *sine, double *cosine)
{
    const int32_t quarters = sim_nearest(angle_deg * (1.0 / 90.0));
    const double x = (angle_deg - 90.0 * (double)quarters) * RAD_PER_DEG; /* the subtraction is exact */
    const double both[2] = {short_sine(x), short_cosine(x)};
    static const double SIGN[5] = {1.0, 1.0, -1.0, -1.0, 1.0}; /* of the sine, and a quarter on of the cosine */
    const uint32_t quarter = (uint32_t)quarters & 3U;
    *sine = SIGN[quarter] * both[quarter & 1U];
    *cosine = SIGN[quarter + 1U] * both[~quarter & 1U];
}

/* ln 2 in two parts: the first has trailing zeros, so that its product with an exponent is exact. */
static const double LN2_HIGH = 6.93147180369123816490e-01;
static const double LN2_LOW = 1.90821492927058770002e-10;

/* x 2^k for normal results. */
static double scaled(double x, int32_t k)
{
    const int64_t bits = (int64_t)(k + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return x * power;
}

double sim_exp(double x)
{
    if (x < -700.0) {
        return 0.0;
    }
    const int32_t k = sim_nearest(x * (1.0 / 6.93147180559945309417e-01));
    const double r = (x - (double)k * LN2_HIGH) - (double)k * LN2_LOW;
    const double z = r * r; /* Taylor series, |r| <= 0.347, even and odd terms side by side */
    const double even =
        1.0 +
        z * (1.0 / 2.0 +
             z * (1.0 / 24.0 +
                  z * (1.0 / 720.0 + z * (1.0 / 40320.0 + z * (1.0 / 3628800.0 +
                                                               z * (1.0 / 479001600.0 + z * (1.0 / 87178291200.0)))))));
    const double odd =
        1.0 + z * (1.0 / 6.0 +
                   z * (1.0 / 120.0 +
                        z * (1.0 / 5040.0 + z * (1.0 / 362880.0 + z * (1.0 / 39916800.0 + z * (1.0 / 6227020800.0))))));
    return scaled(even + r * odd, k);
}

double sim_log(double x)
{
    static const double SQRT2 = 1.41421356237309504880;
    int64_t bits;
    memcpy(&bits, &x, sizeof bits);
    int64_t exponent = ((bits >> 52) & 0x7FF) - 1023;
    bits = (bits & INT64_C(0xFFFFFFFFFFFFF)) | INT64_C(0x3FF0000000000000);
    double m;
    memcpy(&m, &bits, sizeof m);
    if (m > SQRT2) {
        m *= 0.5;
        exponent++;
    }
    const double s = (m - 1.0) / (m + 1.0); /* ln m = 2 artanh s, |s| <= 0.172 */
    const double z = s * s;
    const double y = z * z; /* even and odd powers of z side by side */
    const double odd =
        1.0 / 3.0 + y * (1.0 / 7.0 + y * (1.0 / 11.0 + y * (1.0 / 15.0 + y * (1.0 / 19.0 + y * (1.0 / 23.0)))));
    const double even = 1.0 / 5.0 + y * (1.0 / 9.0 + y * (1.0 / 13.0 + y * (1.0 / 17.0 + y * (1.0 / 21.0))));
    const double sum = odd + z * even;
    const double k = (double)exponent;
    return k * LN2_HIGH + (2.0 * s + (2.0 * s * z * sum + k * LN2_LOW));
}
