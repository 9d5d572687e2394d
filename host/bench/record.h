/* record.h - what a campaign keeps of a run: numbers only, fit to be sent through a pipe between processes. */
#ifndef TUMBLE_BENCH_RECORD_H
#define TUMBLE_BENCH_RECORD_H

#include "bench/world.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint64_t seed;
    int32_t exit;
    tumble_state_t state;
    tumble_reason_t reason;
    bool known; /* there is a result */
    bool pass;
    tumble_coefficients_t found;
    tumble_coefficients_t truth;
    double max_abs_delta_g_g;
    uint64_t virtual_us;
    uint64_t frames;
    uint32_t positions;
    uint64_t measured; /* one bit per position */
    double mean_v[TUMBLE_MAX_POSITIONS][TUMBLE_CHANNELS];
} bench_record_t;

_Static_assert(TUMBLE_MAX_POSITIONS <= 64, "one bit per position");

/* Sum up a run that has ended. */
void bench_record_take(bench_record_t *record, const bench_world_t *world);

#endif
