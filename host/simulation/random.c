#include "simulation/random.h"

#include "simulation/maths.h"

#include <math.h> /* sqrt: correctly rounded; fabs: exact */
#include <stdbool.h>

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

/* Polynomials of degree 7, constant term first. */
static inline double polynomial(const double c[8], double r)
{
    return ((((((c[7] * r + c[6]) * r + c[5]) * r + c[4]) * r + c[3]) * r + c[2]) * r + c[1]) * r + c[0];
}

/* AS 241, p within 0.075 to 0.925: the result is q ratio(r), with q = p - 1/2, r = 0.180625 - q^2. */
static const double CENTRAL_ABOVE[8] = {3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3,
                                        1.3731693765509461125e4, 4.5921953931549871457e4, 6.7265770927008700853e4,
                                        3.3430575583588128105e4, 2.5090809287301226727e3};
static const double CENTRAL_BELOW[8] = {1.0,
                                        4.2313330701600911252e1,
                                        6.8718700749205790830e2,
                                        5.3941960214247511077e3,
                                        2.1213794301586595867e4,
                                        3.9307895800092710610e4,
                                        2.8729085735721942674e4,
                                        5.2264952788528545610e3};

/* The nearer tails, with s = sqrt(-ln min(p, 1 - p)) up to 5: ratio(s - 1.6). */
static const double TAIL_ABOVE[8] = {1.42343711074968357734e0,  4.63033784615654529590e0, 5.76949722146069140550e0,
                                     3.64784832476320460504e0,  1.27045825245236838258e0, 2.41780725177450611770e-1,
                                     2.27238449892691845833e-2, 7.74545014278341407640e-4};
static const double TAIL_BELOW[8] = {1.0,
                                     2.05319162663775882187e0,
                                     1.67638483018380384940e0,
                                     6.89767334985100004550e-1,
                                     1.48103976427480074590e-1,
                                     1.51986665636164571966e-2,
                                     5.47593808499534494600e-4,
                                     1.05075007164441684324e-9};

/* The far tails: ratio(s - 5). */
static const double FAR_ABOVE[8] = {6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,
                                    2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                    2.71155556874348757815e-5, 2.01033439929228813265e-7};
static const double FAR_BELOW[8] = {1.0,
                                    5.99832206555887937690e-1,
                                    1.36929880922735805310e-1,
                                    1.48753612908506148525e-2,
                                    7.86869131145613259100e-4,
                                    1.84631831751005468180e-5,
                                    1.42151175831644588870e-7,
                                    2.04426310338993978564e-15};

static double outer_quantile(double p)
{
    const double s = sqrt(-sim_log((p < 0.5) ? p : 1.0 - p));
    const double z = (s <= 5.0) ? polynomial(TAIL_ABOVE, s - 1.6) / polynomial(TAIL_BELOW, s - 1.6)
                                : polynomial(FAR_ABOVE, s - 5.0) / polynomial(FAR_BELOW, s - 5.0);
    return (p < 0.5) ? -z : z;
}

static inline bool is_central(double p)
{
    return fabs(p - 0.5) <= 0.425;
}

static inline double central_quantile(double p)
{
    const double q = p - 0.5;
    const double r = 0.180625 - q * q;
    return q * (polynomial(CENTRAL_ABOVE, r) / polynomial(CENTRAL_BELOW, r));
}

double sim_normal_quantile(double p)
{
    return is_central(p) ? central_quantile(p) : outer_quantile(p);
}

double sim_random_normal(sim_random_t *stream)
{
    return sim_normal_quantile(sim_random_unit(stream));
}

#define AT_ONCE 32

/* The middle of the law for all of them, which nothing interrupts; then the tails. */
static void draw_some(sim_random_t *stream, double *deviates, int count)
{
    double p[AT_ONCE];
    for (int i = 0; i < count; i++) {
        p[i] = sim_random_unit(stream);
    }
    for (int i = 0; i < count; i++) {
        deviates[i] = central_quantile(p[i]);
    }
    for (int i = 0; i < count; i++) {
        if (!is_central(p[i])) {
            deviates[i] = outer_quantile(p[i]);
        }
    }
}

void sim_random_normals(sim_random_t *stream, double *deviates, int count)
{
    for (int done = 0; done < count; done += AT_ONCE) {
        const int left = count - done;
        draw_some(stream, deviates + done, (left < AT_ONCE) ? left : AT_ONCE);
    }
}

double sim_law_draw(sim_law_t law, double limit, sim_random_t *stream)
{
    switch (law) {
    case SIM_LAW_UNIFORM:
        return limit * sim_random_symmetric(stream);
    case SIM_LAW_SIGMA3:
        return limit / 3.0 * sim_random_normal(stream);
    default:
        return limit * sim_random_normal(stream);
    }
}
