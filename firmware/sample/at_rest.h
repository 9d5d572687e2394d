/* at_rest.h - mean and scatter of so many samples in a row, on a table that somebody else has brought to rest.
 *
 * It serves the check of a stand without a calibration: how well the table comes back to a place, how much it is tilted
 * there, how much noise there is. The sums are integers and exact, so neither number depends on the order of the
 * samples: the mean is one correctly rounded division, the variance is right to some units of the last place.
 *
 * A sample passes the gates that the samples of a run pass (core/accumulator.h). A refused sample is counted as spoilt
 * and the measurement goes on without it; the user decides how many are too many. Samples that never came are counted
 * as spoilt when the next one comes.
 *
 * The caller owns the object; nothing is allocated, nothing waits. Not re-entrant on one object.
 */
#ifndef TUMBLE_SAMPLE_AT_REST_H
#define TUMBLE_SAMPLE_AT_REST_H

#include "sample/block_sample.h"
#include "tumble/core.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_AT_REST_MIN_SAMPLES 2U

static_assert(UINT16_MAX <= TUMBLE_MAX_SAMPLES, "the sums of tumble/core.h hold as many samples");

/* Private; all zero: nothing is measured. */
typedef struct {
    uint16_t wanted;
    uint16_t spoilt;
    uint32_t dropped; /* before the last sample */
    tumble_average_t mean;
    tumble_open_position_t open;
} tumble_at_rest_t;

static_assert(sizeof(tumble_at_rest_t) <= 112, "it must stay small");

/* What has been measured. */
typedef struct {
    double mean_v[TUMBLE_CHANNELS];
    double deviation_v[TUMBLE_CHANNELS]; /* standard deviation of one sample, n - 1 */
    uint16_t wanted;
    uint16_t taken;
    uint16_t spoilt; /* stays at UINT16_MAX */
} tumble_at_rest_view_t;

/* Forget what was measured and begin anew: TUMBLE_AT_REST_MIN_SAMPLES or more are wanted, or 0: none.
 * Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT (1 sample is wanted): then nothing has changed. */
tumble_status_t tumble_at_rest_begin(tumble_at_rest_t *at_rest, uint16_t wanted);

/* Every sample that comes; what is not wanted (any more) is not looked at. `dropped`: how many frames of the block came
 * again or too late and were dropped before they got here, in all, modulo 2^32. */
void tumble_at_rest_take(tumble_at_rest_t *at_rest, const tumble_averaging_config_t *config,
                         const tumble_block_sample_t *sample, uint32_t dropped);

/* The numbers of samples and, once all that were wanted have come, their means and deviations. `v_per_count` finite,
 * not 0.
 * Returns TUMBLE_OK, or TUMBLE_E_TOO_FEW: some are still missing, and means and deviations are 0. */
tumble_status_t tumble_at_rest_view(const tumble_at_rest_t *at_rest, double v_per_count, tumble_at_rest_view_t *view);

#endif
