#include "bench/campaign.h"

#include "bench/json.h"
#include "bench/pool.h"
#include "bench/report.h"

#include <math.h>
#include <string.h>

/* What is kept of a run: numbers only, fit to be sent through a pipe between processes. */
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
    bench_travel_t travel;
    uint32_t positions;
    uint64_t measured; /* one bit per position */
    double mean_v[TUMBLE_MAX_POSITIONS][TUMBLE_CHANNELS];
} record_t;

_Static_assert(TUMBLE_MAX_POSITIONS <= 64, "one bit per position");

typedef struct {
    uint64_t runs;
    uint64_t known;
    uint64_t passed;
    uint64_t failed; /* gravity check */
    uint64_t faulty;
    uint64_t reasons[TUMBLE_REASON_COUNT];
    uint64_t frames;
    uint64_t virtual_us;
    bench_travel_t travel;
    double sum[TUMBLE_COEFFICIENTS]; /* of estimate less truth */
    double square_sum[TUMBLE_COEFFICIENTS];
    double wall_s;
    double cpu_s;
} statistics_t;

static void take_result(record_t *record, const bench_world_t *world)
{
    tumble_result_t result;
    record->known = tumble_navcomp_result(&world->navcomp, &result) == TUMBLE_OK;
    if (record->known) {
        record->pass = result.pass;
        record->found = *result.coefficients;
        record->max_abs_delta_g_g = bench_largest_delta_g(result.check);
    }
}

static void sum_up(record_t *record, const bench_world_t *world)
{
    memset(record, 0, sizeof *record);
    record->seed = world->seed;
    record->exit = bench_exit_code(world);
    record->state = world->progress.state;
    record->reason = world->progress.reason;
    record->truth = world->truth.block;
    record->virtual_us = world->clock.now_us;
    record->frames = world->bus.load.frames;
    record->travel = bench_travel(world);
    record->positions = world->config->scenario.schedule.position_count;
    take_result(record, world);
    for (uint8_t i = 0; i < world->config->scenario.schedule.position_count; i++) {
        double error_v[TUMBLE_CHANNELS];
        if (bench_mean(world, i, record->mean_v[i], error_v)) {
            record->measured |= UINT64_C(1) << i;
        }
    }
}

static void put_block(bench_json_t *json, const tumble_coefficients_t *block)
{
    bench_json_vector(json, "K", &block->k_v_per_g[0][0], TUMBLE_CHANNELS * TUMBLE_CHANNELS);
    bench_json_vector(json, "U0", block->u0_v, TUMBLE_CHANNELS);
}

static void put_result(bench_json_t *json, const record_t *record)
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

static void put_means(bench_json_t *json, const record_t *record)
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

static void put_line(const record_t *record, bool with_means, FILE *out)
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
    bench_report_table(&record->travel, &json);
    if (with_means) {
        put_means(&json, record);
    }
    bench_json_close(&json, '}');
    (void)fputc('\n', out);
}

static void add(statistics_t *statistics, const record_t *record)
{
    bench_travel_add(&statistics->travel, &record->travel, statistics->runs == 0U);
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

static void put_errors(bench_json_t *json, const char *name, const statistics_t *statistics, int first, int count)
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

static void put_reasons(bench_json_t *json, const statistics_t *statistics)
{
    bench_json_open(json, "reasons", '{');
    for (int i = 0; i < TUMBLE_REASON_COUNT; i++) {
        if (statistics->reasons[i] > 0U) {
            bench_json_whole(json, tumble_reason_name((tumble_reason_t)i), statistics->reasons[i]);
        }
    }
    bench_json_close(json, '}');
}

static void put_summary(const statistics_t *statistics, const bench_options_t *options, FILE *out)
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
    bench_report_table(&statistics->travel, &json);
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

typedef struct {
    const bench_config_t *config;
    const bench_options_t *options;
    bench_world_t world;
    statistics_t statistics;
    FILE *out;
} campaign_t;

/* One run from beginning to end. */
static void run_one(void *context, uint64_t number, void *record)
{
    static const bench_watcher_t NOBODY = {0};
    campaign_t *const campaign = context;
    bench_world_t *const world = &campaign->world;
    if (bench_world_init(world, campaign->config, campaign->options->seed + number, &NOBODY) == TUMBLE_OK) {
        bench_world_run(world);
    }
    sum_up(record, world);
}

static void take(void *context, uint64_t number, const void *record)
{
    campaign_t *const campaign = context;
    (void)number;
    add(&campaign->statistics, record);
    if (!campaign->options->summary) {
        put_line(record, campaign->options->means, campaign->out);
    }
}

static int exit_of(const statistics_t *statistics)
{
    if (statistics->faulty > 0U) {
        return BENCH_EXIT_FAULT;
    }
    return (statistics->failed > 0U) ? BENCH_EXIT_LIMITS : BENCH_EXIT_PASS;
}

int bench_campaign(const bench_config_t *config, const bench_options_t *options, FILE *out)
{
    static campaign_t campaign;
    static record_t record;
    bench_pool_times_t times = {0};
    campaign.config = config;
    campaign.options = options;
    campaign.out = out;
    const bench_pool_t pool = {.context = &campaign,
                               .count = options->runs,
                               .jobs = options->jobs,
                               .record = &record,
                               .bytes = sizeof record,
                               .run = run_one,
                               .take = take};
    const int code = bench_pool_run(&pool, &times);
    if (code != BENCH_EXIT_PASS) {
        return code;
    }
    campaign.statistics.wall_s = times.wall_s;
    campaign.statistics.cpu_s = times.cpu_s;
    if (options->summary) {
        put_summary(&campaign.statistics, options, out);
    }
    return exit_of(&campaign.statistics);
}
