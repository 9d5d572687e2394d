#include "bench/campaign_report.h"

#include "bench/json.h"
#include "bench/report.h"

#include <math.h>

static void put_block(bench_json_t *json, const tumble_coefficients_t *block)
{
    bench_json_vector(json, "K", &block->k_v_per_g[0][0], TUMBLE_CHANNELS * TUMBLE_CHANNELS);
    bench_json_vector(json, "U0", block->u0_v, TUMBLE_CHANNELS);
}

static void put_result(bench_json_t *json, const bench_record_t *record)
{
    bench_json_flag(json, "pass", record->pass);
    if (record->known) {
        put_block(json, &record->found);
        bench_json_number(json, "max_abs_delta_g_g", record->max_abs_delta_g_g);
        return;
    }
    bench_json_null(json, "K");
    bench_json_null(json, "U0");
    bench_json_null(json, "max_abs_delta_g_g");
}

static void put_means(bench_json_t *json, const bench_record_t *record)
{
    bench_json_open(json, "means", '[');
    for (uint32_t i = 0; i < record->positions; i++) {
        const bool measured = (record->measured >> i & 1U) != 0U;
        for (int c = 0; c < TUMBLE_CHANNELS; c++) {
            if (measured) {
                bench_json_number(json, NULL, record->mean_v[i][c]);
            } else {
                bench_json_null(json, NULL);
            }
        }
    }
    bench_json_close(json, ']');
}

void bench_campaign_line(const bench_record_t *record, bool with_means, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_whole(&json, "seed", record->seed);
    bench_json_whole(&json, "exit", (uint64_t)record->exit);
    bench_json_text(&json, "state", tumble_state_name(record->state));
    bench_json_text(&json, "reason", tumble_reason_name(record->reason));
    put_result(&json, record);
    bench_json_open(&json, "truth", '{');
    put_block(&json, &record->truth);
    bench_json_close(&json, '}');
    bench_json_number(&json, "virtual_s", (double)record->virtual_us * 1e-6);
    bench_json_whole(&json, "frames", record->frames);
    if (with_means) {
        put_means(&json, record);
    }
    bench_json_close(&json, '}');
    (void)fputc('\n', out);
}

void bench_statistics_add(bench_statistics_t *statistics, const bench_record_t *record)
{
    statistics->runs++;
    statistics->passed += (record->exit == BENCH_EXIT_PASS) ? 1U : 0U;
    statistics->failed += (record->exit == BENCH_EXIT_LIMITS) ? 1U : 0U;
    statistics->faulty += (record->exit == BENCH_EXIT_FAULT) ? 1U : 0U;
    statistics->reasons[record->reason]++;
    statistics->frames += record->frames;
    statistics->virtual_us += record->virtual_us;
    if (!record->known) {
        return;
    }
    statistics->known++;
    for (int i = 0; i < TUMBLE_COEFFICIENTS; i++) {
        const bool of_k = i < TUMBLE_CHANNELS * TUMBLE_CHANNELS;
        const int row = of_k ? i / TUMBLE_CHANNELS : i - TUMBLE_CHANNELS * TUMBLE_CHANNELS;
        const int column = i % TUMBLE_CHANNELS;
        const double error = of_k ? record->found.k_v_per_g[row][column] - record->truth.k_v_per_g[row][column]
                                  : record->found.u0_v[row] - record->truth.u0_v[row];
        statistics->sum[i] += error;
        statistics->square_sum[i] += error * error;
    }
}

static void put_errors(bench_json_t *json, const char *name, const bench_statistics_t *statistics, int first, int count)
{
    const double runs = (double)statistics->known;
    bench_json_open(json, name, '{');
    bench_json_open(json, "mean_error", '[');
    for (int i = first; i < first + count; i++) {
        bench_json_number(json, NULL, statistics->sum[i] / runs);
    }
    bench_json_close(json, ']');
    bench_json_open(json, "rms_error", '[');
    for (int i = first; i < first + count; i++) {
        bench_json_number(json, NULL, sqrt(statistics->square_sum[i] / runs));
    }
    bench_json_close(json, ']');
    bench_json_close(json, '}');
}

static void put_reasons(bench_json_t *json, const bench_statistics_t *statistics)
{
    bench_json_open(json, "reasons", '{');
    for (int i = 0; i < TUMBLE_REASON_COUNT; i++) {
        if (statistics->reasons[i] > 0U) {
            bench_json_whole(json, tumble_reason_name((tumble_reason_t)i), statistics->reasons[i]);
        }
    }
    bench_json_close(json, '}');
}

void bench_campaign_summary(const bench_statistics_t *statistics, const bench_options_t *options, FILE *out)
{
    const double runs = (double)statistics->runs;
    const double frames = (double)statistics->frames;
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.campaign/1");
    bench_json_whole(&json, "runs", statistics->runs);
    bench_json_whole(&json, "first_seed", options->seed);
    bench_json_open(&json, "exits", '{');
    bench_json_whole(&json, "0", statistics->passed);
    bench_json_whole(&json, "1", statistics->failed);
    bench_json_whole(&json, "3", statistics->faulty);
    bench_json_close(&json, '}');
    put_reasons(&json, statistics);
    put_errors(&json, "K", statistics, 0, TUMBLE_CHANNELS * TUMBLE_CHANNELS);
    put_errors(&json, "U0", statistics, TUMBLE_CHANNELS * TUMBLE_CHANNELS, TUMBLE_CHANNELS);
    bench_json_whole(&json, "frames", statistics->frames);
    bench_json_number(&json, "virtual_s", (double)statistics->virtual_us * 1e-6);
    bench_json_whole(&json, "jobs", options->jobs);
    bench_json_number(&json, "wall_s", statistics->wall_s);
    bench_json_number(&json, "cpu_s", statistics->cpu_s);
    bench_json_number(&json, "calibrations_per_s", runs / statistics->wall_s);
    bench_json_number(&json, "frames_per_s", frames / statistics->wall_s);
    bench_json_number(&json, "calibrations_per_cpu_s", runs / statistics->cpu_s);
    bench_json_number(&json, "frames_per_cpu_s", frames / statistics->cpu_s);
    bench_json_close(&json, '}');
    (void)fputc('\n', out);
}
