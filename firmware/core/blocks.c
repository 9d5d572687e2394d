#include "tumble/core.h"

#include "core/arith.h"
#include "core/averaging_state.h"
#include "core/count.h"

#include <stddef.h>

#define CHANCE_SIGMAS 4.2 /* one-sided, 1.3e-5: more than declared */
#define HALF_COUNT 0.5
#define GROWN_SIGMAS 2.33 /* one-sided, 1e-2: more than the scatter */

/* What a channel shows, in counts squared. */
typedef struct {
    double variance; /* of a sample, as it matters to a mean */
    double line;     /* what each further length of the longest block adds to it */
    bool exceeds;    /* the declared noise, beyond chance */
} shown_t;

/* The scatter of samples within positions. */
typedef struct {
    double variance[TUMBLE_CHANNELS];
    double freedom;
} scatter_t;

tumble_status_t tumble_blocks_init(tumble_blocks_t *blocks, uint32_t samples)
{
    if ((blocks == NULL) || (samples < (uint32_t)TUMBLE_MIN_BLOCKED_SAMPLES)) {
        return TUMBLE_E_ARGUMENT;
    }
    *blocks = (tumble_blocks_t){.block_samples = 2};
    while ((blocks->block_samples < ((uint32_t)TUMBLE_MAX_BLOCK_SAMPLES / 2U)) &&
           ((blocks->block_samples * 2U) <= (samples / 4U))) {
        blocks->block_samples *= 2U;
    }
    return TUMBLE_OK;
}

void tumble_blocks_begin(tumble_blocks_t *blocks)
{
    for (int level = 0; level < TUMBLE_BLOCK_LENGTHS; level++) {
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            blocks->open_square_sum[level][i] = 0;
            blocks->difference[level][i] = 0;
        }
    }
    blocks->samples = 0;
}

/* Stops at the end instead of overflowing. */
static void add_up(int64_t *sum, int64_t by)
{
    *sum = (by <= (INT64_MAX - *sum)) ? (*sum + by) : INT64_MAX;
}

/* Both blocks are complete. */
static void close_pair(tumble_blocks_t *blocks, int level)
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const uint32_t difference = blocks->difference[level][i];
        const uint32_t size = (difference <= (uint32_t)INT32_MAX) ? difference : (0U - difference);
        add_up(&blocks->open_square_sum[level][i], (int64_t)size * (int64_t)size);
        blocks->difference[level][i] = 0;
    }
}

/* The samples themselves are summed and not their deviations: what they have in common cancels, modulo 2^32, too. */
void tumble_blocks_add(tumble_blocks_t *blocks, const int32_t counts[TUMBLE_CHANNELS])
{
    const uint32_t before = blocks->samples;
    blocks->samples = before + 1U;
    uint32_t length = blocks->block_samples;
    for (int level = 0; level < TUMBLE_BLOCK_LENGTHS; level++) {
        const bool is_second = (before & length) != 0U;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            const uint32_t count = (uint32_t)counts[i];
            blocks->difference[level][i] += is_second ? (0U - count) : count;
        }
        length *= 2U;
        if ((blocks->samples & (length - 1U)) == 0U) {
            close_pair(blocks, level);
        }
    }
}

void tumble_blocks_finish(tumble_blocks_t *blocks)
{
    uint32_t length = blocks->block_samples;
    for (int level = 0; level < TUMBLE_BLOCK_LENGTHS; level++) {
        length *= 2U;
        tumble_add_up(&blocks->pairs[level], blocks->samples / length);
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            add_up(&blocks->square_sum[level][i], blocks->open_square_sum[level][i]);
        }
    }
    tumble_blocks_begin(blocks);
}

static double square(double x)
{
    return x * x;
}

static void find_scatter(const tumble_averaging_t *averaging, scatter_t *found)
{
    found->freedom = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double squares = 0.0;
        double freedom = 0.0;
        for (uint8_t p = 0; p < (uint8_t)TUMBLE_MAX_POSITIONS; p++) {
            if (tumble_averaging_has_mean(averaging, p)) {
                const double own = (double)averaging->averages[p].samples - 1.0;
                freedom += own;
                squares += own * square((double)averaging->averages[p].scatter_counts[i]);
            }
        }
        found->freedom = freedom;
        found->variance[i] = tumble_is_positive(freedom) ? (squares / freedom) : 0.0;
    }
}

/* What chi-squared over its degrees of freedom exceeds as seldom as a normal number exceeds `sigmas` (Wilson and
 * Hilferty). */
static double chance_limit(double freedom, double sigmas)
{
    const double ninth = 2.0 / (9.0 * freedom);
    const double root = 1.0 - ninth + (sigmas * tumble_sqrt(ninth));
    return root * root * root;
}

/* Sums of (A - B)^2 / 2m. */
static double energies(const tumble_blocks_t *blocks, int level, int channel)
{
    const double length = (double)blocks->block_samples * ((level == 0) ? 1.0 : 2.0);
    return (double)blocks->square_sum[level][channel] / (2.0 * length);
}

/* The energies of both lengths together, then those of the longer one alone. The largest that exceeds the scatter beyond
 * chance counts; if it is that of the longest blocks, the noise does not end within them, and the straight line through
 * the energies of the two lengths is carried on: at least flat, at most through the origin. */
static shown_t shown_in(const tumble_blocks_t *blocks, const scatter_t *scatter, int channel, double declared)
{
    const double variance = scatter->variance[channel];
    shown_t shown = {variance, 0.0, tumble_exceeds(variance, chance_limit(scatter->freedom, CHANCE_SIGMAS) * declared)};
    const double pairs[TUMBLE_BLOCK_LENGTHS] = {(double)blocks->pairs[0], (double)blocks->pairs[1]};
    const double sums[TUMBLE_BLOCK_LENGTHS] = {energies(blocks, 0, channel), energies(blocks, 1, channel)};
    double largest = 0.0;
    for (int level = 0; (level < TUMBLE_BLOCK_LENGTHS) && (blocks->pairs[level] > 0U); level++) {
        const double freedom = (level == 0) ? (pairs[0] + pairs[1]) : pairs[1];
        const double pooled = ((level == 0) ? (sums[0] + sums[1]) : sums[1]) / freedom;
        if (tumble_exceeds(pooled, chance_limit(freedom, CHANCE_SIGMAS) * declared)) {
            shown.exceeds = true;
        }
        if (tumble_exceeds(pooled, chance_limit(freedom, GROWN_SIGMAS) * variance) && tumble_exceeds(pooled, largest)) {
            largest = pooled;
            shown.variance = pooled;
            const double steep = (level == 0) ? 0.0 : (2.0 * (pooled - (sums[0] / pairs[0])));
            const double rising = tumble_is_positive(steep) ? steep : 0.0;
            shown.line = tumble_exceeds(rising, pooled) ? pooled : rising;
        }
    }
    return shown;
}

static double mean_variance(const shown_t *shown, const tumble_blocks_t *blocks, uint32_t samples)
{
    const double lengths = (double)samples / (2.0 * (double)blocks->block_samples);
    const double further = tumble_exceeds(lengths, 1.0) ? (lengths - 1.0) : 0.0;
    return (shown->variance + (further * shown->line)) / (double)samples;
}

static bool is_within_range(const tumble_blocks_t *blocks)
{
    bool within = true;
    for (int level = 0; level < TUMBLE_BLOCK_LENGTHS; level++) {
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            within = within && (blocks->square_sum[level][i] < INT64_MAX);
        }
    }
    return within;
}

/* In counts squared, of the mean of a position. */
static double excess_at(const tumble_blocks_t *blocks, const shown_t *shown, uint32_t samples, double declared,
                        double least)
{
    const double own = tumble_larger(declared / (double)samples, least);
    const double excess = mean_variance(shown, blocks, samples) - own;
    return tumble_is_positive(excess) ? excess : 0.0;
}

/* Rounding by half a count is no noise beyond the declared one. */
tumble_status_t tumble_blocks_excess(const tumble_blocks_t *blocks, const tumble_averaging_t *averaging,
                                     const tumble_stand_record_t *stand, double v_per_count,
                                     double excess_v2[TUMBLE_MAX_POSITIONS][TUMBLE_CHANNELS])
{
    if ((blocks == NULL) || (averaging == NULL) || (stand == NULL) || (excess_v2 == NULL) ||
        !tumble_is_positive(tumble_abs(v_per_count))) {
        return TUMBLE_E_ARGUMENT;
    }
    scatter_t scatter;
    find_scatter(averaging, &scatter);
    if (!tumble_is_positive(scatter.freedom)) {
        return TUMBLE_E_TOO_FEW;
    }
    if (!is_within_range(blocks)) {
        return TUMBLE_E_DEVIATION;
    }
    const double declared = square(stand->noise_v / v_per_count);
    const double least = square(stand->least_noise_v / v_per_count);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const shown_t shown = shown_in(blocks, &scatter, i, declared + square(HALF_COUNT));
        for (uint8_t p = 0; p < (uint8_t)TUMBLE_MAX_POSITIONS; p++) {
            excess_v2[p][i] = 0.0;
            if (shown.exceeds && tumble_averaging_has_mean(averaging, p)) {
                const uint32_t samples = averaging->averages[p].samples;
                excess_v2[p][i] = square(v_per_count) * excess_at(blocks, &shown, samples, declared, least);
            }
        }
    }
    return TUMBLE_OK;
}
