/* random.h - the random numbers of a run: one generator, many streams, the same numbers on every host.
 *
 * The generator is xoshiro256** (Blackman and Vigna, "Scrambled linear pseudorandom number generators", 2021). Every
 * cause of randomness has streams of its own, named by (seed, cause, index), so one draw more or less anywhere shifts
 * no number anywhere else. A stream's state is four outputs of splitmix64 (Steele, Lea, Flood, 2014), started at a
 * value into which seed, cause and index have been mixed by splitmix64's own finalizer. So seeds may be small and next
 * to each other: 1, 2, 3 and so on give streams that have nothing to do with one another.
 *
 * Normal deviates come from the inverse distribution function: one uniform draw gives one normal deviate, always, and
 * the function uses + - x / and the square root alone, so neither rejection nor a library's logarithm can make two
 * hosts differ. Largest deviate: 8.2.
 */
#ifndef TUMBLE_SIMULATION_RANDOM_H
#define TUMBLE_SIMULATION_RANDOM_H

#include <stdint.h>

/* Part of a seed's meaning: new causes go to the end. */
typedef enum {
    SIM_CAUSE_AXIS_TILT = 1, /* alpha1 */
    SIM_CAUSE_LEVEL,         /* alpha2 */
    SIM_CAUSE_REMOUNT,       /* alpha3; index: number of the mounting, 0 when one yaw serves all */
    SIM_CAUSE_ANGLE,         /* alpha4; index: position in the schedule */
    SIM_CAUSE_ANGLE_BETWEEN, /* the same for angles that are not positions of the schedule */
    SIM_CAUSE_NOISE,         /* of a sample; index: channel */
    SIM_CAUSE_BLOCK,         /* K and U0; index: coefficient, row by row, then U0 */
    SIM_CAUSE_FAULT_NOISE,   /* what a fault adds to a sample; index: channel */
    SIM_CAUSE_BUS_FAULT,     /* which frames a fault picks, which bit it flips; index: number of the fault */
    SIM_CAUSE_SETTLING,      /* phase of the table's oscillation */
    SIM_CAUSE_POWER_ON,      /* where the table stands before homing */
    SIM_CAUSE_CAMPAIGN,      /* a run of the fault campaign; index: what is drawn (world/fault_campaign.h) */
    SIM_CAUSE_PLATFORM,      /* theta_h of the platform */
    SIM_CAUSE_SEAT,          /* theta_h, then theta_n of the seat; index: number of the mounting */
    SIM_CAUSE_ENCODER,       /* the four numbers of its errors */
    SIM_CAUSE_DRIFT,         /* over the run, of each channel */
    SIM_CAUSE_INCLINATION    /* beta, then tau of setting it; index: number of the mounting */
} sim_cause_t;

typedef struct {
    uint64_t s[4]; /* not all zero */
} sim_random_t;

/* Begin the stream (seed, cause, index). */
void sim_random_open(sim_random_t *stream, uint64_t seed, sim_cause_t cause, uint32_t index);

/* 64 uniform bits. */
static inline uint64_t sim_random_u64(sim_random_t *stream)
{
    uint64_t *const s = stream->s;
    const uint64_t product = s[1] * 5U;
    const uint64_t result = ((product << 7) | (product >> 57)) * 9U;
    const uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = (s[3] << 45) | (s[3] >> 19);
    return result;
}

/* Uniform in (0, 1): odd multiples of 2^-53, so neither end is ever reached and p and 1 - p are equally likely. */
static inline double sim_random_unit(sim_random_t *stream)
{
    return ((double)(sim_random_u64(stream) >> 12) + 0.5) * 0x1p-52;
}

/* Uniform in (-1, 1). */
double sim_random_symmetric(sim_random_t *stream);

/* Normal with mean 0 and standard deviation 1. */
double sim_random_normal(sim_random_t *stream);

/* The next `count` of what sim_random_normal would give. */
void sim_random_normals(sim_random_t *stream, double *deviates, int count);

/* Inverse of the normal distribution function for 0 < p < 1, relative error about 1e-15
 * (Wichura, "Algorithm AS 241: the percentage points of the normal distribution", 1988, PPND16). */
double sim_normal_quantile(double p);

/* The generator that seeds the streams: advances `state` and returns 64 bits. */
uint64_t sim_splitmix64(uint64_t *state);

/* What a declared error limit means. */
typedef enum {
    SIM_LAW_SIGMA1 = 0, /* the limit is a standard deviation of a normal law */
    SIM_LAW_SIGMA3,     /* three of them */
    SIM_LAW_UNIFORM     /* half the width of a uniform law */
} sim_law_t;

/* One error of a source with this limit; 0 for a limit of 0. One draw from the stream in either case. */
double sim_law_draw(sim_law_t law, double limit, sim_random_t *stream);

#endif
