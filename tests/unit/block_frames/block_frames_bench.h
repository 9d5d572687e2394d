/* block_frames_bench.h - a receiver of the block's frames, and samples to send it. */
#ifndef TUMBLE_TESTS_UNIT_BLOCK_FRAMES_BENCH_H
#define TUMBLE_TESTS_UNIT_BLOCK_FRAMES_BENCH_H

#include "sample/block_frames.h"
#include "simulation/block_encode.h"
#include "suite.h"

#include <string.h>

static tumble_block_receiver_t receiver;
static tumble_block_sample_t got; /* the last sample received */

static inline void fresh_receiver(void)
{
    memset(&receiver, 0, sizeof receiver);
    memset(&got, 0, sizeof got);
}

static inline tumble_block_sample_t sample_of(uint16_t counter)
{
    return (tumble_block_sample_t){
        .raw = {.counts = {1000 + counter, -2000 - counter, 3000000}, .counter = counter},
        .timestamp_ms = (uint16_t)((counter * 10U) % TUMBLE_TIMESTAMP_PERIOD_MS),
        .temperature_half_c = 43,
    };
}

static inline sim_block_frames_t frames_of(uint16_t counter)
{
    const tumble_block_sample_t sample = sample_of(counter);
    sim_block_frames_t frames;
    sim_block_encode(&sample, &frames);
    return frames;
}

static inline tumble_block_event_t receive(const tumble_can_frame_t *frame)
{
    return tumble_block_receive(&receiver, frame, &got);
}

#endif
