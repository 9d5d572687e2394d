#include "bench/hostile_report.h"

#include "bench/json.h"

void bench_hostile_add(bench_hostile_sum_t *sum, const bench_hostile_record_t *record)
{
    const bench_life_counts_t *const counts = &record->counts;
    if (record->virtual_us > 0U) { /* there was a world */
        bench_travel_add(&sum->travel, &record->travel, sum->virtual_us == 0U);
    }
    sum->runs++;
    sum->violated += (record->violation.kind != BENCH_HOLDS) ? 1U : 0U;
    sum->violations[record->violation.kind]++;
    for (uint32_t i = 0; i < SIM_FAULT_KINDS; i++) {
        sum->faults[i] += counts->faults[i];
    }
    for (uint32_t i = 0; i < BENCH_HOSTILE_KINDS; i++) {
        sum->events[i] += counts->events[i];
    }
    for (uint32_t i = 0; i < TUMBLE_STATE_COUNT * TUMBLE_REASON_COUNT; i++) {
        sum->ends[i / TUMBLE_REASON_COUNT][i % TUMBLE_REASON_COUNT] +=
            counts->ends[i / TUMBLE_REASON_COUNT][i % TUMBLE_REASON_COUNT];
    }
    for (uint32_t i = 0; i < BENCH_EXCUSES; i++) {
        sum->excuses[i] += record->excuses >> i & 1U;
    }
    sum->flips += counts->flips;
    sum->committed += counts->committed;
    sum->judged += counts->judged;
    sum->held += counts->held;
    sum->homings += counts->homings;
    sum->lives_with_commit += (counts->committed > 0U) ? 1U : 0U;
    sum->virtual_us += record->virtual_us;
    sum->frames += record->frames;
    sum->steps += record->steps;
}

static void put_shrunk(bench_json_t *json, const bench_shrunk_t *shrunk)
{
    const bench_text_t what = bench_text_violation(&shrunk->violation);
    bench_json_open(json, NULL, '{');
    bench_json_whole(json, "seed", shrunk->seed);
    bench_json_text(json, "kind", bench_broken_name(shrunk->violation.kind));
    bench_json_number(json, "at_s", 1e-6 * (double)shrunk->violation.at_us);
    bench_json_text(json, "what", what.text);
    bench_json_whole(json, "drawn", shrunk->drawn);
    bench_json_text(json, "world", shrunk->world.text);
    bench_json_open(json, "events", '[');
    for (uint32_t i = 0; i < shrunk->count; i++) {
        bench_json_text(json, NULL, shrunk->events[i].text);
    }
    bench_json_close(json, ']');
    bench_json_close(json, '}');
}

static void put_violations(bench_json_t *json, const bench_hostile_sum_t *sum)
{
    bench_json_whole(json, "violated", sum->violated);
    bench_json_open(json, "violations", '{');
    for (uint32_t i = 1; i < BENCH_VIOLATION_KINDS; i++) {
        bench_json_whole(json, bench_broken_name((bench_broken_t)i), sum->violations[i]);
    }
    bench_json_close(json, '}');
    bench_json_open(json, "first", '[');
    for (uint32_t i = 0; i < sum->shrunk_count; i++) {
        put_shrunk(json, &sum->shrunk[i]);
    }
    bench_json_close(json, ']');
}

static void put_injected(bench_json_t *json, const bench_hostile_sum_t *sum)
{
    bench_json_open(json, "faults", '{');
    for (uint32_t i = 0; i < SIM_FAULT_KINDS; i++) {
        bench_json_whole(json, sim_fault_word((sim_fault_kind_t)i), sum->faults[i]);
    }
    bench_json_close(json, '}');
    bench_json_open(json, "events", '{');
    for (uint32_t i = 0; i < BENCH_HOSTILE_KINDS; i++) {
        bench_json_whole(json, bench_hostile_name((bench_hostile_t)i), sum->events[i]);
    }
    bench_json_close(json, '}');
    bench_json_whole(json, "flipped_bits", sum->flips);
    bench_json_open(json, "excuses", '{');
    for (uint32_t i = 0; i < BENCH_EXCUSES; i++) {
        bench_json_whole(json, bench_excuse_name((bench_excuse_t)i), sum->excuses[i]);
    }
    bench_json_close(json, '}');
}

static void put_ends(bench_json_t *json, const bench_hostile_sum_t *sum)
{
    static const tumble_state_t STATES[] = {TUMBLE_STATE_IDLE, TUMBLE_STATE_DONE, TUMBLE_STATE_FAULT,
                                            TUMBLE_STATE_ABORT};
    bench_json_open(json, "ends", '{');
    for (uint32_t i = 0; i < sizeof STATES / sizeof STATES[0]; i++) {
        bench_json_open(json, tumble_state_name(STATES[i]), '{');
        for (uint32_t r = 0; r < TUMBLE_REASON_COUNT; r++) {
            if (sum->ends[STATES[i]][r] > 0U) {
                bench_json_whole(json, tumble_reason_name((tumble_reason_t)r), sum->ends[STATES[i]][r]);
            }
        }
        bench_json_close(json, '}');
    }
    bench_json_close(json, '}');
    bench_json_whole(json, "homings", sum->homings);
    bench_json_open(json, "sets", '{');
    bench_json_whole(json, "committed", sum->committed);
    bench_json_whole(json, "judged", sum->judged);
    bench_json_whole(json, "held", sum->held);
    bench_json_close(json, '}');
    bench_json_whole(json, "lives_with_commit", sum->lives_with_commit);
}

void bench_hostile_document(const bench_hostile_sum_t *sum, const bench_options_t *options,
                            const bench_pool_times_t *times, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.hostile/1");
    bench_json_whole(&json, "runs", sum->runs);
    bench_json_whole(&json, "first_seed", options->seed);
    put_violations(&json, sum);
    put_injected(&json, sum);
    put_ends(&json, sum);
    bench_report_table(&sum->travel, &json);
    bench_json_number(&json, "virtual_s", 1e-6 * (double)sum->virtual_us);
    bench_json_whole(&json, "frames", sum->frames);
    bench_json_whole(&json, "steps", sum->steps);
    bench_json_open(&json, "speed", '{');
    bench_json_whole(&json, "jobs", options->jobs);
    bench_json_number(&json, "wall_s", times->wall_s);
    bench_json_number(&json, "cpu_s", times->cpu_s);
    bench_json_number(&json, "ms_per_life", 1e3 * times->cpu_s / (double)sum->runs);
    bench_json_close(&json, '}');
    bench_json_close(&json, '}');
    (void)fputc('\n', out);
}
