#include "bench/hostile.h"

#include "bench/hostile_report.h"
#include "bench/report.h"

#include <string.h>

typedef struct {
    const bench_options_t *options;
    bench_plan_t plan;
    bench_life_t life;
    bench_hostile_sum_t sum;
} hostile_t;

static void live(hostile_t *hostile, uint64_t seed)
{
    const char *const wrong = bench_plan_draw(&hostile->plan, seed);
    if (wrong != NULL) {
        (void)fprintf(stderr, "tumble-bench: seed %llu: %s\n", (unsigned long long)seed, wrong);
        memset(&hostile->life, 0, sizeof hostile->life);
        hostile->life.watch.violation.kind = BENCH_BROKEN_BENCH;
        return;
    }
    bench_life_run(&hostile->life, &hostile->plan);
}

static void run_one(void *context, uint64_t number, void *record)
{
    hostile_t *const hostile = context;
    const bench_life_t *const life = &hostile->life;
    bench_hostile_record_t *const kept = record;
    live(hostile, hostile->options->seed + number);
    memset(kept, 0, sizeof *kept);
    kept->seed = hostile->options->seed + number;
    kept->violation = life->watch.violation;
    kept->counts = life->counts;
    kept->excuses = life->watch.excuses;
    kept->virtual_us = life->world.clock.now_us;
    if (kept->virtual_us > 0U) {
        kept->travel = bench_travel(&life->world);
    }
    kept->frames = life->world.bus.load.frames;
    kept->steps = life->world.steps;
}

/* Live it again, here, and shrink it. */
static void shrink(hostile_t *hostile, const bench_hostile_record_t *record)
{
    bench_shrunk_t *const shrunk = &hostile->sum.shrunk[hostile->sum.shrunk_count++];
    (void)bench_plan_draw(&hostile->plan, record->seed);
    shrunk->seed = record->seed;
    shrunk->drawn = hostile->plan.count;
    bench_plan_shrink(&hostile->plan, &hostile->life, record->violation.kind);
    shrunk->violation = hostile->life.watch.violation;
    shrunk->world = bench_text_world(&hostile->plan);
    shrunk->count = hostile->plan.count;
    for (uint32_t i = 0; i < hostile->plan.count; i++) {
        shrunk->events[i] = bench_text_event(&hostile->plan.events[i]);
    }
}

static void tell(const bench_hostile_record_t *record, const bench_shrunk_t *shrunk, bool verbose)
{
    const bench_text_t what = bench_text_violation(&record->violation);
    (void)fprintf(stderr, "tumble-bench: seed %llu: %s", (unsigned long long)record->seed, what.text);
    if (shrunk != NULL) {
        (void)fprintf(stderr, "; %u of %u events are enough", (unsigned)shrunk->count, (unsigned)shrunk->drawn);
    }
    (void)fputc('\n', stderr);
    if (shrunk != NULL && verbose) {
        const bench_text_t then = bench_text_violation(&shrunk->violation);
        (void)fprintf(stderr, "  %s\n", shrunk->world.text);
        for (uint32_t i = 0; i < shrunk->count; i++) {
            (void)fprintf(stderr, "  %s\n", shrunk->events[i].text);
        }
        (void)fprintf(stderr, "  with these alone: %s\n", then.text);
    }
}

static void take(void *context, uint64_t number, const void *taken)
{
    hostile_t *const hostile = context;
    const bench_hostile_record_t *const record = taken;
    (void)number;
    bench_hostile_add(&hostile->sum, record);
    if (record->violation.kind == BENCH_HOLDS) {
        return;
    }
    const bool shrinks =
        record->violation.kind != BENCH_BROKEN_BENCH && hostile->sum.shrunk_count < BENCH_HOSTILE_SHRUNK;
    if (shrinks) {
        shrink(hostile, record);
    }
    tell(record, shrinks ? &hostile->sum.shrunk[hostile->sum.shrunk_count - 1U] : NULL, hostile->options->verbose);
}

int bench_hostile(const bench_options_t *options, FILE *out)
{
    static hostile_t hostile;
    static bench_hostile_record_t record;
    bench_pool_times_t times = {0};
    hostile.options = options;
    const bench_pool_t pool = {.context = &hostile,
                               .count = options->lives,
                               .jobs = options->jobs,
                               .record = &record,
                               .bytes = sizeof record,
                               .run = run_one,
                               .take = take};
    const int code = bench_pool_run(&pool, &times);
    if (code != BENCH_EXIT_PASS) {
        return code;
    }
    bench_hostile_document(&hostile.sum, options, &times, out);
    return (hostile.sum.violated > 0U) ? BENCH_EXIT_FAULT : BENCH_EXIT_PASS;
}
