#include "sample/at_rest.h"

#include "core/accumulator.h"
#include "core/arith.h"

static void spoil(tumble_at_rest_t *at_rest, uint32_t samples)
{
    const uint32_t room = (uint32_t)UINT16_MAX - at_rest->spoilt;
    at_rest->spoilt = (uint16_t)(at_rest->spoilt + ((samples < room) ? samples : room));
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
    if (at_rest->mean.samples == at_rest->wanted) {
        return;
    }
    tumble_averaging_counters_t counters = {0};
    const tumble_accumulator_t into = {&at_rest->mean, &at_rest->open, &counters};
    spoil(at_rest, ((at_rest->open.faults & HAS_COUNTER) != 0U) ? (dropped - at_rest->dropped) : 0U);
    at_rest->dropped = dropped;
    const tumble_status_t status = tumble_accumulator_take(into, config, &sample->raw);
    if (status == TUMBLE_E_UNHEALTHY) {
        (void)tumble_gate_counter(into, sample->raw.counter);
    }
    spoil(at_rest, counters.lost + ((status == TUMBLE_OK) ? 0U : 1U));
    at_rest->open.last_counter = sample->raw.counter; /* one from behind, too: so counts a block that has restarted */
}

/* Of deviations from the integer next to their mean, whichever sample was the first: (Q - D^2 / n) / (n - 1), where Q
 * and D are exact and D is at most n / 2, so that nothing cancels. */
static double variance_of(const tumble_at_rest_t *at_rest, int channel)
{
    const int64_t n = at_rest->wanted;
    const double samples = (double)at_rest->wanted;
    const int64_t sum = at_rest->mean.sum_counts[channel] - (n * at_rest->open.first[channel]);
    const double mean = (double)sum / samples;
    const int64_t middle = tumble_nearest(mean);
    const int64_t d = sum - (n * middle);
    const int64_t q = at_rest->open.square_sum[channel] - (middle * (sum + d));
    return ((double)q - ((double)(d * d) / samples)) / (samples - 1.0);
}

tumble_status_t tumble_at_rest_view(const tumble_at_rest_t *at_rest, double v_per_count, tumble_at_rest_view_t *view)
{
    const uint32_t taken = at_rest->mean.samples;
    *view = (tumble_at_rest_view_t){.wanted = at_rest->wanted, .taken = (uint16_t)taken, .spoilt = at_rest->spoilt};
    if ((at_rest->wanted == 0U) || (taken != at_rest->wanted)) {
        return TUMBLE_E_TOO_FEW;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        view->mean_v[i] = ((double)at_rest->mean.sum_counts[i] / (double)taken) * v_per_count;
        view->deviation_v[i] = tumble_sqrt(variance_of(at_rest, i)) * tumble_abs(v_per_count);
    }
    return TUMBLE_OK;
}
