#include "bench/record.h"

#include "bench/report.h"

#include <string.h>

static void take_result(bench_record_t *record, const bench_world_t *world)
{
    tumble_result_t result;
    record->known = tumble_navcomp_result(&world->navcomp, &result) == TUMBLE_OK;
    if (record->known) {
        record->pass = result.pass;
        record->found = *result.coefficients;
        record->max_abs_delta_g_g = bench_largest_delta_g(result.check);
    }
}

void bench_record_take(bench_record_t *record, const bench_world_t *world)
{
    memset(record, 0, sizeof *record);
    record->seed = world->seed;
    record->exit = bench_exit_code(world);
    record->state = world->progress.state;
    record->reason = world->progress.reason;
    record->truth = world->truth.block;
    record->virtual_us = world->clock.now_us;
    record->frames = world->bus.load.frames;
    record->positions = world->config->scenario.schedule.position_count;
    take_result(record, world);
    for (uint8_t i = 0; i < world->config->scenario.schedule.position_count; i++) {
        double error_v[TUMBLE_CHANNELS];
        if (bench_mean(world, i, record->mean_v[i], error_v)) {
            record->measured |= UINT64_C(1) << i;
        }
    }
}
