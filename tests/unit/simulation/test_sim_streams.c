/* The random streams as campaigns use them: seeds 1, 2, 3 and so on, one or two draws from each of many streams.
 *
 * Judged are the spread of every stream's draws over the seeds, in blocks as long as a campaign, and the correlations
 * between streams, between seeds next to each other, and crosswise, of the draws and of their squares. The same judge
 * must reject streams that are opened carelessly.
 */
#include "simulation/random.h"
#include "support.h"

#include <math.h>
#include <stdbool.h>

enum { SEEDS = 50000, BLOCK = 1000, STREAMS = 12, LAGS = 3 };

#define TOO_FAR 5.3 /* standard deviations: of the 1092 normal numbers looked at, one goes so far once in 8000 times */

typedef void (*opener_t)(sim_random_t *stream, uint64_t seed, sim_cause_t cause, uint32_t index);

typedef struct {
    sim_cause_t cause;
    uint32_t index;
} name_t;

/* Neighbours in every respect: by cause, by index, by both. */
static const name_t NAMES[STREAMS] = {
    {SIM_CAUSE_AXIS_TILT, 0}, {SIM_CAUSE_LEVEL, 0}, {SIM_CAUSE_REMOUNT, 1}, {SIM_CAUSE_REMOUNT, 2},
    {SIM_CAUSE_ANGLE, 0},     {SIM_CAUSE_ANGLE, 1}, {SIM_CAUSE_ANGLE, 2},   {SIM_CAUSE_ANGLE, 3},
    {SIM_CAUSE_ANGLE, 17},    {SIM_CAUSE_NOISE, 0}, {SIM_CAUSE_NOISE, 1},   {SIM_CAUSE_NOISE, 2},
};

static double draws[2][STREAMS][SEEDS]; /* first and second */
static double worst;

static void set_up(void)
{
    worst = 0.0;
}

/* A number that is standard normal when the streams are what they should be. */
static void note(double deviation)
{
    worst = (fabs(deviation) > worst) ? fabs(deviation) : worst;
}

static void draw_all(opener_t open)
{
    for (int n = 0; n < SEEDS; n++) {
        for (int s = 0; s < STREAMS; s++) {
            sim_random_t stream;
            open(&stream, (uint64_t)n + 1U, NAMES[s].cause, NAMES[s].index);
            draws[0][s][n] = sim_random_normal(&stream);
            draws[1][s][n] = sim_random_normal(&stream);
        }
    }
}

/* Mean and mean square; and how much the mean squares of blocks differ from each other. */
static void judge_spread(const double z[SEEDS])
{
    double sum = 0.0;
    double squares = 0.0;
    double scatter = 0.0;
    for (int block = 0; block < SEEDS / BLOCK; block++) {
        double chi2 = 0.0;
        for (int n = 0; n < BLOCK; n++) {
            const double draw = z[block * BLOCK + n];
            sum += draw;
            chi2 += draw * draw;
        }
        squares += chi2;
        scatter += (chi2 - BLOCK) * (chi2 - BLOCK) / (2.0 * BLOCK);
    }
    note(sum / sqrt(SEEDS));
    note((squares - SEEDS) / sqrt(2.0 * SEEDS));
    note((scatter - SEEDS / BLOCK) / sqrt(2.0 * SEEDS / BLOCK) / 1.3); /* chi-squared has the longer tail */
}

/* Of the draws, and of their squares less 1. */
static void judge_correlation(const double a[SEEDS], const double b[SEEDS], int lag)
{
    double sum = 0.0;
    double squares = 0.0;
    for (int n = lag; n < SEEDS; n++) {
        sum += a[n] * b[n - lag];
        squares += (a[n] * a[n] - 1.0) * (b[n - lag] * b[n - lag] - 1.0);
    }
    note(sum / sqrt(SEEDS - lag));
    note(squares / (2.0 * sqrt(SEEDS - lag)));
}

static bool are_sound(opener_t open)
{
    draw_all(open);
    for (int s = 0; s < STREAMS; s++) {
        judge_spread(draws[0][s]);
        judge_spread(draws[1][s]);
        judge_correlation(draws[0][s], draws[1][s], 0);
        for (int other = 0; other < STREAMS; other++) {
            for (int lag = (other < s) ? 0 : 1; lag <= LAGS; lag++) {
                judge_correlation(draws[0][s], draws[0][other], lag);
            }
        }
    }
    return worst < TOO_FAR;
}

static void test_streams_of_consecutive_seeds_are_independent_and_normal(void)
{
    TEST_ASSERT_TRUE(are_sound(sim_random_open));
}

/* The careless ones. */

static void open_unmixed(sim_random_t *stream, uint64_t seed, sim_cause_t cause, uint32_t index)
{
    *stream = (sim_random_t){{seed, (uint64_t)cause, index, 1}};
}

static void fill(sim_random_t *stream, uint64_t state)
{
    for (int i = 0; i < 4; i++) {
        stream->s[i] = sim_splitmix64(&state);
    }
}

/* Cause 2 of one seed is cause 1 of the next. */
static void open_sum(sim_random_t *stream, uint64_t seed, sim_cause_t cause, uint32_t index)
{
    fill(stream, seed + (uint64_t)cause + 1000U * index);
}

/* A product is no mixing. */
static void open_by_product(sim_random_t *stream, uint64_t seed, sim_cause_t cause, uint32_t index)
{
    const uint64_t product = (seed * 40 + (uint64_t)cause + index) * UINT64_C(69069);
    *stream = (sim_random_t){{product, product << 32, product << 16, ~product}};
}

static void test_carelessly_opened_streams_are_rejected(void)
{
    static const opener_t CARELESS[] = {open_unmixed, open_sum, open_by_product};
    for (size_t i = 0; i < COUNT_OF(CARELESS); i++) {
        worst = 0.0;
        TEST_ASSERT_FALSE(are_sound(CARELESS[i]));
    }
}
