/* The invariants of the computer's own counts: service level, run number, samples of a mean. */
#include "world/hostile_invariants.h"

#include "core/averaging_state.h"
#include "core/bytes.h"
#include "navcomp/service.h"
#include "simulation/block_encode.h"

#include <math.h>
#include <string.h>

#define LEVEL_US 60000000U
#define LATE_US 200000U /* the firmware looks at its clock every 100 ms at least */
#define KEY_OBJECT 0x2006U
#define PLACE_DEG 0.5 /* errors of the stand, and its swing */

/* Service level: nothing but its key opens it, and what it protects is refused without it. */

static bool is_protected(uint16_t index, uint8_t subindex)
{
    static const uint16_t PROTECTED[] = {0x1010, 0x1011, 0x1016, 0x1017, 0x1029, 0x1400, 0x1401, 0x1600, 0x1601,
                                         0x1800, 0x1801, 0x1A00, 0x1A01, 0x2123, 0x2124, 0x2125, 0x2126};
    for (uint32_t i = 0; i < sizeof PROTECTED / sizeof PROTECTED[0]; i++) {
        if (index == PROTECTED[i]) {
            return true;
        }
    }
    return (index == 0x2050U && subindex == 5U) || (index == 0x2122U && subindex == 6U);
}

void bench_watch_request(bench_life_t *life, const tumble_can_frame_t *frame)
{
    bench_watch_t *const watch = &life->watch;
    const uint64_t now_us = life->world.clock.now_us;
    const bool is_write = frame->length == 8U && (frame->data[0] & 0xE2U) == 0x22U; /* in this one frame */
    if (is_write && tumble_get_u16(&frame->data[1]) == KEY_OBJECT && frame->data[3] == 1U) {
        const uint32_t key = tumble_get_u32(&frame->data[4]);
        watch->level_until_us = (key == TUMBLE_SERVICE_KEY) ? now_us + LEVEL_US
                                : (key == 0U)               ? 0U
                                                            : watch->level_until_us;
    }
    watch->locked = is_write && now_us > watch->level_until_us + LATE_US;
}

void bench_watch_written(bench_life_t *life, uint16_t index, uint8_t subindex)
{
    if (life->watch.locked && is_protected(index, subindex)) {
        bench_watch_break(life, BENCH_BROKEN_LEVEL, 0.0, (uint32_t)index << 8 | subindex);
    }
}

static void look_at_level(bench_life_t *life)
{
    bench_watch_t *const watch = &life->watch;
    const uint64_t now_us = life->world.clock.now_us;
    if (!tumble_service_is_open(&life->world.navcomp) || now_us <= watch->level_until_us) {
        watch->open_us = SIM_NEVER;
    } else if (watch->open_us == SIM_NEVER) {
        watch->open_us = now_us;
    } else if (now_us - watch->open_us > LATE_US) {
        bench_watch_break(life, BENCH_BROKEN_LEVEL, 0.0, (uint32_t)KEY_OBJECT << 8 | 2U);
    }
}

/* The run number: one more with each run that begins, and with nothing else. */

static void look_at_number(bench_life_t *life)
{
    const uint32_t runs = tumble_service_runs(&life->world.navcomp);
    if (runs < life->watch.runs || runs > life->watch.runs + 1U) {
        bench_watch_break(life, BENCH_BROKEN_RUN, (double)runs, life->watch.runs);
    }
}

void bench_watch_count_run(bench_life_t *life, bool begins, bool may_begin)
{
    bench_watch_t *const watch = &life->watch;
    const uint32_t runs = tumble_service_runs(&life->world.navcomp);
    const uint32_t least = begins ? 1U : 0U;
    const uint32_t most = (begins || may_begin) ? 1U : 0U;
    if (runs < watch->runs + least || runs > watch->runs + most) {
        bench_watch_break(life, BENCH_BROKEN_RUN, (double)runs, watch->runs);
    }
    watch->runs = runs;
}

/* Means: of so many samples as are configured, all different, all of frames that came, at this position of the table. */

void bench_watch_block_frame(bench_life_t *life, const tumble_can_frame_t *frame)
{
    bench_collected_t *const collected = &life->watch.collected;
    collected->frames[collected->next++ % BENCH_RECENT] = *frame;
}

static bool has_come(const bench_collected_t *collected, const tumble_can_frame_t *frame)
{
    for (uint32_t i = 0; i < BENCH_RECENT; i++) {
        if (collected->frames[i].id == frame->id && memcmp(collected->frames[i].data, frame->data, 8) == 0) {
            return true;
        }
    }
    return false;
}

static bool is_new(const bench_collected_t *collected, uint16_t counter)
{
    const uint32_t kept = (collected->count < BENCH_COUNTERS) ? collected->count : BENCH_COUNTERS;
    for (uint32_t i = 0; i < kept; i++) {
        if (collected->counters[i] == counter) {
            return false;
        }
    }
    return true;
}

/* Of the true table; a slip, and a stop too short to be refused, are excused. */
static bool is_there(const bench_life_t *life, uint8_t index)
{
    static const uint32_t EXCUSES = 1U << BENCH_EXCUSE_REWRITTEN | 1U << BENCH_EXCUSE_SLIP | 1U << BENCH_EXCUSE_SHORT;
    const bench_config_t *const config = &life->plan->config;
    const double wanted_deg = config->scenario.schedule.positions[index].angle.deg;
    const double deg = sim_axis_actual_deg(life->world.axis, life->world.clock.now_us);
    return (life->watch.excuses & EXCUSES) != 0U ||
           fabs(remainder(deg - wanted_deg, 360.0)) <= config->procedure.position_tolerance_deg + PLACE_DEG;
}

void bench_watch_sample(bench_life_t *life, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    bench_collected_t *const collected = &life->watch.collected;
    sim_block_frames_t frames;
    if (taken.ordinal == 1U) {
        collected->index = taken.index;
        collected->count = 0;
        memset(collected->sum, 0, sizeof collected->sum);
    }
    sim_block_encode(sample, &frames);
    const bool good = taken.index == collected->index && taken.ordinal == collected->count + 1U &&
                      is_new(collected, sample->raw.counter) && has_come(collected, &frames.xy) &&
                      has_come(collected, &frames.z) && is_there(life, taken.index);
    if (!good) {
        bench_watch_break(life, BENCH_BROKEN_MEAN, (double)taken.ordinal, taken.index);
    }
    collected->counters[collected->count % BENCH_COUNTERS] = sample->raw.counter;
    collected->count++;
    for (int c = 0; c < TUMBLE_CHANNELS; c++) {
        collected->sum[c] += sample->raw.counts[c];
    }
}

static bool is_collected(const bench_life_t *life, uint8_t index, const tumble_average_t *average)
{
    const bench_collected_t *const collected = &life->watch.collected;
    return collected->index == index && collected->count == average->samples &&
           (average->samples == life->plan->config.procedure.samples ||
            bench_watch_has_excuse(life, BENCH_EXCUSE_RULES)) &&
           memcmp(collected->sum, average->sum_counts, sizeof collected->sum) == 0;
}

/* A mean that is there is the one just collected, or one that was there before: back after a loss of power. */
static void look_at_mean(bench_life_t *life, uint8_t index, const tumble_average_t *average)
{
    bench_known_t *const known = &life->watch.known[index];
    for (uint32_t i = 0; i < BENCH_KNOWN; i++) {
        const tumble_average_t *const other = &known->means[i];
        if (other->samples == average->samples &&
            memcmp(other->sum_counts, average->sum_counts, sizeof other->sum_counts) == 0 &&
            memcmp(other->scatter_counts, average->scatter_counts, sizeof other->scatter_counts) == 0) {
            return;
        }
    }
    if (!is_collected(life, index, average)) {
        bench_watch_break(life, BENCH_BROKEN_MEAN, (double)average->samples, index);
        return;
    }
    known->means[known->next++ % BENCH_KNOWN] = *average;
}

void bench_watch_means(bench_life_t *life)
{
    const tumble_averaging_t *const averages =
        tumble_procedure_averages(tumble_navcomp_procedure(&life->world.navcomp));
    for (uint8_t i = 0; i < life->plan->config.scenario.schedule.position_count; i++) {
        if (tumble_averaging_has_mean(averages, i)) {
            look_at_mean(life, i, &averages->averages[i]);
        }
    }
}

void bench_watch_rules(bench_life_t *life)
{
    look_at_level(life);
    look_at_number(life);
}

void bench_watch_begin_again(bench_life_t *life)
{
    life->watch.level_until_us = 0;
    life->watch.open_us = SIM_NEVER;
    life->watch.runs = 0;
}
