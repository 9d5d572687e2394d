#include "tumble/core.h"

#include "core/count.h"

#include <stddef.h>

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
