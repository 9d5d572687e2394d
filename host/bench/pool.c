#define _POSIX_C_SOURCE 200809L

#include "bench/pool.h"

#include "bench/interrupt.h"
#include "bench/options.h"
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

/* The worker's whole life: every jobs-th run, from its own on. */
static void work(const bench_pool_t *pool, uint32_t number, int pipe)
{
    for (uint64_t i = number; i < pool->count; i += pool->jobs) {
        pool->run(pool->context, i, pool->record);
        if (!write_all(pipe, pool->record, pool->bytes)) {
            _exit(1);
        }
    }
    _exit(0);
}

static bool hire(worker_t *worker, const bench_pool_t *pool, uint32_t number)
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
        work(pool, number, ends[1]);
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

/* False: a worker is gone, or the user has had enough. */
static bool collect(const bench_pool_t *pool, const worker_t *workers)
{
    for (uint64_t i = 0; i < pool->count; i++) {
        if (pool->jobs == 1U) {
            pool->run(pool->context, i, pool->record);
        } else if (!read_all(workers[i % pool->jobs].pipe, pool->record, pool->bytes)) {
            return false;
        }
        if (bench_interrupted()) {
            return false;
        }
        pool->take(pool->context, i, pool->record);
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

int bench_pool_run(const bench_pool_t *pool, bench_pool_times_t *times)
{
    worker_t workers[BENCH_MAX_JOBS];
    uint32_t hired = 0;
    const double started_s = seconds_of(CLOCK_MONOTONIC);
    while (pool->jobs > 1U && hired < pool->jobs) {
        if (!hire(&workers[hired], pool, hired)) {
            (void)fprintf(stderr, "tumble-bench: cannot start a process: %s\n", strerror(errno));
            dismiss(workers, hired);
            return BENCH_EXIT_FAULT;
        }
        hired++;
    }
    const bool complete = collect(pool, workers);
    dismiss(workers, hired);
    if (!complete) {
        if (!bench_interrupted()) {
            (void)fprintf(stderr, "tumble-bench: a process of the campaign has died\n");
        }
        return bench_interrupted() ? BENCH_EXIT_INTERRUPTED : BENCH_EXIT_FAULT;
    }
    times->wall_s = seconds_of(CLOCK_MONOTONIC) - started_s;
    times->cpu_s = cpu_seconds(RUSAGE_SELF) + cpu_seconds(RUSAGE_CHILDREN);
    return BENCH_EXIT_PASS;
}
