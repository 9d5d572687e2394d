#include "sample/at_rest.h"

#include "core/arith.h"

static void spoil(tumble_at_rest_t *at_rest, uint32_t samples)
{
    const uint32_t room = (uint32_t)UINT16_MAX - at_rest->spoilt;
    at_rest->spoilt = (uint16_t)(at_rest->spoilt + ((samples < room) ? samples : room));
}

/* Follow the block's own counter: what is missing is spoilt. False: this sample came before. One from behind is
 * followed, too, for so counts a block that has restarted. */
static bool is_next(tumble_at_rest_t *at_rest, uint16_t counter)
{
    const uint16_t missing = (uint16_t)(counter - at_rest->last_counter - 1U);
    const bool known = at_rest->has_counter;
    const bool before = known && (missing >= (uint16_t)INT16_MAX);
    at_rest->last_counter = counter;
    at_rest->has_counter = true;
    if (known && !before) {
        spoil(at_rest, missing);
    }
    return !before;
}

static bool is_unsaturated(const tumble_averaging_config_t *config, const int32_t counts[TUMBLE_CHANNELS])
{
    bool good = true;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        good = good && (counts[i] > -config->saturation_counts) && (counts[i] < config->saturation_counts);
    }
    return good;
}

/* How far it lies from the first. False: too far for a table at rest, and for the sums. */
static bool deviate(const tumble_at_rest_t *at_rest, const int32_t counts[TUMBLE_CHANNELS],
                    int64_t deviation[TUMBLE_CHANNELS])
{
    bool near = true;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        deviation[i] = (at_rest->taken != 0U) ? ((int64_t)counts[i] - at_rest->first[i]) : 0;
        near = near && (deviation[i] >= -TUMBLE_MAX_DEVIATION_COUNTS) && (deviation[i] <= TUMBLE_MAX_DEVIATION_COUNTS);
    }
    return near;
}

static void add_up(tumble_at_rest_t *at_rest, const int32_t counts[TUMBLE_CHANNELS],
                   const int64_t deviation[TUMBLE_CHANNELS])
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        at_rest->first[i] = (at_rest->taken != 0U) ? at_rest->first[i] : counts[i];
        at_rest->sum[i] += deviation[i];
        at_rest->square_sum[i] += deviation[i] * deviation[i];
    }
    at_rest->taken++;
}

tumble_status_t tumble_at_rest_begin(tumble_at_rest_t *at_rest, uint16_t wanted)
{
    if ((wanted != 0U) && (wanted < TUMBLE_AT_REST_MIN_SAMPLES)) {
        return TUMBLE_E_ARGUMENT;
    }
    *at_rest = (tumble_at_rest_t){.wanted = wanted};
    return TUMBLE_OK;
}

void tumble_at_rest_take(tumble_at_rest_t *at_rest, const tumble_averaging_config_t *config,
                         const tumble_block_sample_t *sample, uint32_t dropped)
{
    int64_t deviation[TUMBLE_CHANNELS];
    if (at_rest->taken == at_rest->wanted) {
        return;
    }
    spoil(at_rest, at_rest->has_counter ? (dropped - at_rest->dropped) : 0U);
    at_rest->dropped = dropped;
    const bool good = is_next(at_rest, sample->raw.counter) && (sample->status == 0U) &&
                      is_unsaturated(config, sample->raw.counts) && deviate(at_rest, sample->raw.counts, deviation);
    if (good) {
        add_up(at_rest, sample->raw.counts, deviation);
    } else {
        spoil(at_rest, 1U);
    }
}

/* Of deviations from the integer next to their mean, whichever sample was the first: (Q - D^2 / n) / (n - 1), where Q
 * and D are exact and D is at most n / 2, so that nothing cancels. */
static double variance_of(const tumble_at_rest_t *at_rest, int channel)
{
    const int64_t n = (int64_t)at_rest->taken;
    const double mean = (double)at_rest->sum[channel] / (double)n;
    const int64_t middle = (int64_t)(mean + ((mean < 0.0) ? -0.5 : 0.5));
    const int64_t d = at_rest->sum[channel] - (n * middle);
    const int64_t q = at_rest->square_sum[channel] - (middle * (at_rest->sum[channel] + d));
    return ((double)q - ((double)(d * d) / (double)n)) / (double)(n - 1);
}

tumble_status_t tumble_at_rest_view(const tumble_at_rest_t *at_rest, double v_per_count, tumble_at_rest_view_t *view)
{
    *view = (tumble_at_rest_view_t){
        .wanted = at_rest->wanted,
        .taken = at_rest->taken,
        .spoilt = at_rest->spoilt,
    };
    if ((at_rest->wanted == 0U) || (at_rest->taken != at_rest->wanted)) {
        return TUMBLE_E_TOO_FEW;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const int64_t total = at_rest->sum[i] + ((int64_t)at_rest->taken * at_rest->first[i]);
        view->mean_v[i] = ((double)total / (double)at_rest->taken) * v_per_count;
        view->deviation_v[i] = tumble_sqrt(variance_of(at_rest, i)) * tumble_abs(v_per_count);
    }
    return TUMBLE_OK;
}
