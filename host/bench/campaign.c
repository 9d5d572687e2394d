#include "bench/campaign.h"

#include "bench/campaign_report.h"
#include "bench/pool.h"
#include "bench/record.h"
#include "bench/report.h"

typedef struct {
    const bench_config_t *config;
    const bench_options_t *options;
    bench_world_t world;
    bench_statistics_t statistics;
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
    bench_record_take(record, world);
}

static void take(void *context, uint64_t number, const void *record)
{
    campaign_t *const campaign = context;
    (void)number;
    bench_statistics_add(&campaign->statistics, record);
    if (!campaign->options->summary) {
        bench_campaign_line(record, campaign->options->means, campaign->out);
    }
}

static int exit_of(const bench_statistics_t *statistics)
{
    if (statistics->faulty > 0U) {
        return BENCH_EXIT_FAULT;
    }
    return (statistics->failed > 0U) ? BENCH_EXIT_LIMITS : BENCH_EXIT_PASS;
}

int bench_campaign(const bench_config_t *config, const bench_options_t *options, FILE *out)
{
    static campaign_t campaign;
    static bench_record_t record;
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
        bench_campaign_summary(&campaign.statistics, options, out);
    }
    return exit_of(&campaign.statistics);
}
