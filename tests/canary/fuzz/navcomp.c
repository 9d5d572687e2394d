/* Planted: the z counts of an open mean are sorted into eighths of their range, and the last eighth was forgotten. To
 * get here a frame must pass its checksum while a run averages; to fail, two in a row must carry values that the block
 * never sends.
 */
#include "tumble/core.h"

#define RANGE_COUNTS 8388608
#define COUNTS_PER_BIN_BITS 21
#define BINS 7

tumble_status_t __real_tumble_averaging_add(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                            const tumble_sample_t *sample);
tumble_status_t __wrap_tumble_averaging_add(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                            const tumble_sample_t *sample);

static uint32_t bins[BINS];

tumble_status_t __wrap_tumble_averaging_add(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                            const tumble_sample_t *sample)
{
    const tumble_status_t status = __real_tumble_averaging_add(averaging, config, sample);
    if ((status == TUMBLE_OK) && (tumble_averaging_samples(averaging) >= 2U)) {
        bins[(sample->counts[2] + RANGE_COUNTS) >> COUNTS_PER_BIN_BITS]++;
    }
    return status;
}
