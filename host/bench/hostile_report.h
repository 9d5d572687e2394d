/* hostile_report.h - the document of a campaign of hostile lives (hostile.h). */
#ifndef TUMBLE_BENCH_HOSTILE_REPORT_H
#define TUMBLE_BENCH_HOSTILE_REPORT_H

#include "bench/hostile.h"
#include "bench/hostile_life.h"
#include "bench/hostile_text.h"
#include "bench/pool.h"
#include "bench/report.h"

/* What is kept of a life: numbers only, fit to be sent through a pipe. */
typedef struct {
    uint64_t seed;
    bench_violation_t violation;
    bench_life_counts_t counts;
    uint32_t excuses;
    bench_travel_t travel;
    uint64_t virtual_us;
    uint64_t frames;
    uint64_t steps;
} bench_hostile_record_t;

/* One that has been shrunk. */
typedef struct {
    uint64_t seed;
    bench_violation_t violation;
    uint32_t drawn;
    bench_text_t world;
    uint32_t count;
    bench_text_t events[BENCH_PLAN_EVENTS];
} bench_shrunk_t;

typedef struct {
    uint64_t runs;
    uint64_t violated;
    uint64_t violations[BENCH_VIOLATION_KINDS];
    uint64_t faults[SIM_FAULT_KINDS];
    uint64_t events[BENCH_HOSTILE_KINDS];
    uint64_t ends[TUMBLE_STATE_COUNT][TUMBLE_REASON_COUNT];
    uint64_t excuses[BENCH_EXCUSES];
    uint64_t flips, committed, judged, held, homings, lives_with_commit;
    bench_travel_t travel;
    uint64_t virtual_us, frames, steps;
    uint32_t shrunk_count;
    bench_shrunk_t shrunk[BENCH_HOSTILE_SHRUNK];
} bench_hostile_sum_t;

void bench_hostile_add(bench_hostile_sum_t *sum, const bench_hostile_record_t *record);
void bench_hostile_document(const bench_hostile_sum_t *sum, const bench_options_t *options,
                            const bench_pool_times_t *times, FILE *out);

#endif
