#define _POSIX_C_SOURCE 200809L

#include "bench/campaign.h"

#include "bench/campaign_report.h"
#include "bench/interrupt.h"
#include "bench/record.h"
#include "bench/report.h"

#include <errno.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

typedef struct {
    pid_t process;
    int pipe;
} worker_t;

/* One run from beginning to end. */
static void run_one(bench_world_t *world, const bench_config_t *config, uint64_t seed, bench_record_t *record)
{
    static const bench_watcher_t NOBODY = {0};
    if (bench_world_init(world, config, seed, &NOBODY) == TUMBLE_OK) {
        bench_world_run(world);
    }
    bench_record_take(record, world);
}

static bool write_all(int fd, const void *data, size_t size)
{
    const char *at = data;
    while (size > 0U) {
        const ssize_t written = write(fd, at, size);
        if (written < 0) {
            return false;
        }
        at += written;
        size -= (size_t)written;
    }
    return true;
}

static bool read_all(int fd, void *data, size_t size)
{
    char *at = data;
    while (size > 0U) {
        const ssize_t got = read(fd, at, size);
        if (got <= 0) {
            return false;
        }
        at += got;
        size -= (size_t)got;
    }
    return true;
}

/* The worker's whole life: every jobs-th seed, from its own on. */
static void work(const bench_config_t *config, const bench_options_t *options, uint32_t number, int pipe)
{
    static bench_world_t world;
    bench_record_t record;
    for (uint64_t i = number; i < options->runs; i += options->jobs) {
        run_one(&world, config, options->seed + i, &record);
        if (!write_all(pipe, &record, sizeof record)) {
            _exit(1);
        }
    }
    _exit(0);
}

static bool hire(worker_t *worker, const bench_config_t *config, const bench_options_t *options, uint32_t number)
{
    int ends[2];
    if (pipe(ends) != 0) {
        return false;
    }
    worker->process = fork();
    if (worker->process == 0) {
        (void)close(ends[0]);
        (void)signal(SIGINT, SIG_DFL);
        (void)signal(SIGTERM, SIG_DFL);
        (void)signal(SIGHUP, SIG_DFL);
        work(config, options, number, ends[1]);
    }
    (void)close(ends[1]);
    worker->pipe = ends[0];
    return worker->process > 0;
}

static void dismiss(const worker_t *workers, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        (void)close(workers[i].pipe);
        (void)kill(workers[i].process, SIGTERM);
        (void)waitpid(workers[i].process, NULL, 0);
    }
}

static void take(bench_statistics_t *statistics, const bench_options_t *options, const bench_record_t *record,
                 FILE *out)
{
    bench_statistics_add(statistics, record);
    if (!options->summary) {
        bench_campaign_line(record, options->means, out);
    }
}

/* All runs, in the order of their seeds. False: a worker is gone, or the user has had enough. */
static bool collect(bench_statistics_t *statistics, const bench_config_t *config, const bench_options_t *options,
                    const worker_t *workers, FILE *out)
{
    static bench_world_t world;
    bench_record_t record;
    for (uint64_t i = 0; i < options->runs; i++) {
        if (options->jobs == 1U) {
            run_one(&world, config, options->seed + i, &record);
        } else if (!read_all(workers[i % options->jobs].pipe, &record, sizeof record)) {
            return false;
        }
        if (bench_interrupted()) {
            return false;
        }
        take(statistics, options, &record, out);
    }
    return true;
}

static double seconds_of(clockid_t which)
{
    struct timespec now;
    (void)clock_gettime(which, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double cpu_seconds(int who)
{
    struct rusage usage;
    (void)getrusage(who, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
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
    static bench_statistics_t statistics;
    worker_t workers[BENCH_MAX_JOBS];
    uint32_t hired = 0;
    const double started_s = seconds_of(CLOCK_MONOTONIC);
    while (options->jobs > 1U && hired < options->jobs) {
        if (!hire(&workers[hired], config, options, hired)) {
            (void)fprintf(stderr, "tumble-bench: cannot start a process: %s\n", strerror(errno));
            dismiss(workers, hired);
            return BENCH_EXIT_FAULT;
        }
        hired++;
    }
    const bool complete = collect(&statistics, config, options, workers, out);
    dismiss(workers, hired);
    if (!complete) {
        if (!bench_interrupted()) {
            (void)fprintf(stderr, "tumble-bench: a process of the campaign has died\n");
        }
        return bench_interrupted() ? BENCH_EXIT_INTERRUPTED : BENCH_EXIT_FAULT;
    }
    statistics.wall_s = seconds_of(CLOCK_MONOTONIC) - started_s;
    statistics.cpu_s = cpu_seconds(RUSAGE_SELF) + cpu_seconds(RUSAGE_CHILDREN);
    if (options->summary) {
        bench_campaign_summary(&statistics, options, out);
    }
    return exit_of(&statistics);
}
