#include "simulation/random.h"

#include "simulation/maths.h"

#include <math.h> /* sqrt: correctly rounded */

uint64_t sim_splitmix64(uint64_t *state)
{
    *state += UINT64_C(0x9E3779B97F4A7C15);
    uint64_t z = *state;
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return z ^ (z >> 31);
}

void sim_random_open(sim_random_t *stream, uint64_t seed, sim_cause_t cause, uint32_t index)
{
    uint64_t state = seed;
    state = sim_splitmix64(&state) ^ (((uint64_t)cause << 32) | index);
    state = sim_splitmix64(&state);
    for (int i = 0; i < 4; i++) {
        stream->s[i] = sim_splitmix64(&state);
    }
}

double sim_random_symmetric(sim_random_t *stream)
{
    return 2.0 * sim_random_unit(stream) - 1.0;
}

/* AS 241: p within 0.075 to 0.925; r = 0.180625 - q^2, result q * ratio. */
static double central_ratio(double r)
{
    const double above = ((((((2.5090809287301226727e3 * r + 3.3430575583588128105e4) * r + 6.7265770927008700853e4) * r +
                             4.5921953931549871457e4) * r + 1.3731693765509461125e4) * r + 1.9715909503065514427e3) * r +
                          1.3314166789178437745e2) * r + 3.3871328727963666080e0;
    const double below = ((((((5.2264952788528545610e3 * r + 2.8729085735721942674e4) * r + 3.9307895800092710610e4) * r +
                             2.1213794301586595867e4) * r + 5.3941960214247511077e3) * r + 6.8718700749205790830e2) * r +
                          4.2313330701600911252e1) * r + 1.0;
    return above / below;
}

/* The nearer tail; r = sqrt(-ln p) - 1.6, r up to 3.4. */
static double tail_ratio(double r)
{
    const double above =
        ((((((7.74545014278341407640e-4 * r + 2.27238449892691845833e-2) * r + 2.41780725177450611770e-1) * r +
            1.27045825245236838258e0) * r + 3.64784832476320460504e0) * r + 5.76949722146069140550e0) * r +
         4.63033784615654529590e0) * r + 1.42343711074968357734e0;
    const double below =
        ((((((1.05075007164441684324e-9 * r + 5.47593808499534494600e-4) * r + 1.51986665636164571966e-2) * r +
            1.48103976427480074590e-1) * r + 6.89767334985100004550e-1) * r + 1.67638483018380384940e0) * r +
         2.05319162663775882187e0) * r + 1.0;
    return above / below;
}

/* The far tail; r = sqrt(-ln p) - 5. */
static double far_tail_ratio(double r)
{
    const double above =
        ((((((2.01033439929228813265e-7 * r + 2.71155556874348757815e-5) * r + 1.24266094738807843860e-3) * r +
            2.65321895265761230930e-2) * r + 2.96560571828504891230e-1) * r + 1.78482653991729133580e0) * r +
         5.46378491116411436990e0) * r + 6.65790464350110377720e0;
    const double below =
        ((((((2.04426310338993978564e-15 * r + 1.42151175831644588870e-7) * r + 1.84631831751005468180e-5) * r +
            7.86869131145613259100e-4) * r + 1.48753612908506148525e-2) * r + 1.36929880922735805310e-1) * r +
         5.99832206555887937690e-1) * r + 1.0;
    return above / below;
}

static double outer_quantile(double p)
{
    const double r = sqrt(-sim_log((p < 0.5) ? p : 1.0 - p));
    const double z = (r <= 5.0) ? tail_ratio(r - 1.6) : far_tail_ratio(r - 5.0);
    return (p < 0.5) ? -z : z;
}

static inline double quantile(double p)
{
    const double q = p - 0.5;
    if (q <= 0.425 && q >= -0.425) {
        return q * central_ratio(0.180625 - q * q);
    }
    return outer_quantile(p);
}

double sim_normal_quantile(double p)
{
    return quantile(p);
}

double sim_random_normal(sim_random_t *stream)
{
    return quantile(sim_random_unit(stream));
}

void sim_random_normals(sim_random_t *stream, double *deviates, int count)
{
    for (int i = 0; i < count; i++) {
        deviates[i] = quantile(sim_random_unit(stream));
    }
}
