/* tumble-bench: the firmware calibrates a simulated block on a simulated stand, in one deterministic process. */
#define _POSIX_C_SOURCE 200809L

#include "bench/campaign.h"
#include "bench/config.h"
#include "bench/config_keys.h"
#include "bench/hostile.h"
#include "bench/interrupt.h"
#include "bench/options.h"
#include "bench/report.h"
#include "bench/session.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

static int refuse(const char *what)
{
    (void)fprintf(stderr, "tumble-bench: %s\n", what);
    return BENCH_EXIT_USAGE;
}

/* All processors, but no more than there are runs. */
static void choose_jobs(bench_options_t *options, uint64_t runs)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    if (options->jobs == 0U) {
        options->jobs = (processors < 1) ? 1U : (processors > BENCH_MAX_JOBS) ? BENCH_MAX_JOBS : (uint32_t)processors;
    }
    if (options->jobs > runs) {
        options->jobs = (uint32_t)runs;
    }
}

static int run(bench_options_t *options)
{
    static bench_config_t config;
    if (options->lives > 0U) {
        bench_interrupt_watch();
        choose_jobs(options, options->lives);
        return bench_hostile(options, stdout);
    }
    if (!bench_config_prepare(&config, options->scenario, options->gain_record)) {
        return BENCH_EXIT_USAGE;
    }
    bench_interrupt_watch();
    if (options->runs == 0U) {
        return bench_session(&config, options, stdout);
    }
    choose_jobs(options, options->runs);
    return bench_campaign(&config, options, stdout);
}

/* A standard stream that is closed must not become one of our files. What takes its place can neither be read nor
 * written, just as if it were closed. */
static void hold_standard_streams(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
        if (fcntl(fd, F_GETFD) < 0) {
            (void)open("/dev/null", (fd == STDIN_FILENO) ? O_WRONLY : O_RDONLY);
        }
    }
}

int main(int count, char *arguments[])
{
    hold_standard_streams();
    bench_options_t options;
    if (!bench_options_read(&options, count, arguments)) {
        return BENCH_EXIT_USAGE;
    }
    if (options.asks != BENCH_ASKS_WORK) {
        return bench_tell("tumble-bench", options.asks, bench_options_help) ? BENCH_EXIT_PASS : BENCH_EXIT_USAGE;
    }
    if (options.keys) {
        bench_config_print_keys(stdout);
        return BENCH_EXIT_PASS;
    }
    const int code = run(&options);
    if (fflush(stdout) != 0) {
        return refuse("standard output cannot be written");
    }
    return code;
}
