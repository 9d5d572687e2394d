#include "tumble/core.h"

#include "core/accumulator.h"
#include "core/arith.h"
#include "core/stand_record.h"

#include <stddef.h>

#define CHANCE_SIGMAS 4.2 /* one-sided, 1.3e-5: more than declared */
#define GROWN_SIGMAS 2.33 /* one-sided, 1e-2: more than the scatter */
#define HALF_COUNT 0.5
/* Samples round alike below a third of a count squared: a quarter of noise, a twelfth of rounding. */
#define THIRD_COUNTS 3.0

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

static void find_scatter(const tumble_averaging_t *averaging, scatter_t *found)
{
    *found = (scatter_t){.freedom = 0.0};
    for (uint8_t p = 0; p < (uint8_t)TUMBLE_MAX_POSITIONS; p++) {
        const tumble_average_t *average = &averaging->averages[p];
        if (tumble_averaging_has_mean(averaging, p)) {
            const double own = (double)average->samples - 1.0;
            found->freedom += own;
            for (int i = 0; i < TUMBLE_CHANNELS; i++) {
                found->variance[i] += own * tumble_square((double)average->scatter_counts[i]);
            }
        }
    }
    for (int i = 0; (i < TUMBLE_CHANNELS) && tumble_is_positive(found->freedom); i++) {
        found->variance[i] /= found->freedom;
    }
}

/* Are so many degrees of freedom, of `variance` each on the average, more than those of `known` are by chance? */
static bool is_beyond(double variance, double freedom, double sigmas, double known)
{
    return tumble_exceeds(variance * freedom, tumble_chi_squared_limit(freedom, sigmas) * known);
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
    shown_t shown = {variance, 0.0, is_beyond(variance, scatter->freedom, CHANCE_SIGMAS, declared)};
    const double pairs[TUMBLE_BLOCK_LENGTHS] = {(double)blocks->pairs[0], (double)blocks->pairs[1]};
    double largest = 0.0;
    for (int level = 0; (level < TUMBLE_BLOCK_LENGTHS) && (blocks->pairs[level] > 0U); level++) {
        const double sums[TUMBLE_BLOCK_LENGTHS] = {energies(blocks, 0, channel), energies(blocks, 1, channel)};
        const double freedom = (level == 0) ? (pairs[0] + pairs[1]) : pairs[1];
        const double pooled = ((level == 0) ? (sums[0] + sums[1]) : sums[1]) / freedom;
        shown.exceeds = shown.exceeds || is_beyond(pooled, freedom, CHANCE_SIGMAS, declared);
        if (is_beyond(pooled, freedom, GROWN_SIGMAS, variance) && tumble_exceeds(pooled, largest)) {
            largest = pooled;
            shown.variance = pooled;
            const double steep = (level == 0) ? 0.0 : (2.0 * (pooled - (sums[0] / pairs[0])));
            const double rising = tumble_is_positive(steep) ? steep : 0.0;
            shown.line = tumble_exceeds(rising, pooled) ? pooled : rising;
        }
    }
    return shown;
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

/* Of a mean, as much noise of one sample as would give it its variance, were it white. */
static double variance_over(const tumble_noise_t *noise, int channel, uint32_t samples)
{
    const double further = ((double)samples * noise->lengths_per_sample) - 1.0;
    return noise->variance_v2[channel] + (tumble_is_positive(further) ? (further * noise->line_v2[channel]) : 0.0);
}

/* Over all means that have a scatter. */
static double noise_of_means(const tumble_noise_t *noise, const tumble_averaging_t *averaging, int channel)
{
    double sum = 0.0;
    uint32_t count = 0;
    for (uint8_t p = 0; p < (uint8_t)TUMBLE_MAX_POSITIONS; p++) {
        const uint32_t samples = averaging->averages[p].samples;
        if (tumble_averaging_has_mean(averaging, p) && (samples > 1U)) {
            sum += variance_over(noise, channel, samples);
            count++;
        }
    }
    return tumble_sqrt(sum / (double)count);
}

static void estimate_noise(const tumble_blocks_t *blocks, const tumble_averaging_t *averaging,
                           const tumble_stand_record_t *stand, const scatter_t *scatter, double v2_per_count2,
                           tumble_noise_t *noise)
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double declared_v = tumble_stand_noise_v(stand, i);
        const double declared = tumble_square(declared_v) / v2_per_count2;
        noise->declared_v = tumble_larger(noise->declared_v, declared_v);
        const shown_t shown = shown_in(blocks, scatter, i, declared + tumble_square(HALF_COUNT));
        const uint32_t bit = UINT32_C(1) << (uint32_t)i;
        noise->variance_v2[i] = shown.variance * v2_per_count2;
        noise->line_v2[i] = shown.line * v2_per_count2;
        noise->noise_v[i] = noise_of_means(noise, averaging, i);
        noise->above |= shown.exceeds ? (uint8_t)bit : 0U;
        noise->undithered |= tumble_exceeds(1.0, THIRD_COUNTS * scatter->variance[i]) ? (uint8_t)bit : 0U;
    }
}

/* Rounding by half a count is no noise beyond the declared one. */
tumble_status_t tumble_blocks_noise(const tumble_blocks_t *blocks, const tumble_averaging_t *averaging,
                                    const tumble_stand_record_t *stand, double v_per_count, tumble_noise_t *noise)
{
    if ((blocks == NULL) || (averaging == NULL) || (stand == NULL) || (noise == NULL) ||
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
    const double v2_per_count2 = tumble_square(v_per_count);
    *noise = (tumble_noise_t){.rounding_v2 = v2_per_count2 / 12.0};
    if (blocks->block_samples != 0U) {
        noise->lengths_per_sample = 1.0 / (2.0 * (double)blocks->block_samples);
    }
    estimate_noise(blocks, averaging, stand, &scatter, v2_per_count2, noise);
    return TUMBLE_OK;
}

double tumble_noise_excess(const tumble_noise_t *noise, int channel, uint32_t samples, double declared_v2)
{
    const uint32_t bit = UINT32_C(1) << (uint32_t)channel;
    double excess_v2 = 0.0;
    if ((noise->above & bit) != 0U) {
        const double more_v2 = (variance_over(noise, channel, samples) / (double)samples) - declared_v2;
        excess_v2 = tumble_is_positive(more_v2) ? more_v2 : 0.0;
    }
    return ((noise->undithered & bit) != 0U) ? (excess_v2 + noise->rounding_v2) : excess_v2;
}
