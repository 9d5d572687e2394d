/* tumble-bench: the firmware calibrates a simulated block on a simulated stand, in one deterministic process. */
#define _POSIX_C_SOURCE 200809L

#include "bench/campaign.h"
#include "bench/config.h"
#include "bench/config_file.h"
#include "bench/gain_file.h"
#include "bench/interrupt.h"
#include "bench/options.h"
#include "bench/report.h"
#include "bench/session.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static int refuse(const char *what)
{
    (void)fprintf(stderr, "tumble-bench: %s\n", what);
    return BENCH_EXIT_USAGE;
}

/* False: one line about it has been printed. */
static bool read_scenario(bench_config_t *config, const char *path)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    const char *const name = is_stdin ? "standard input" : path;
    FILE *const file = is_stdin ? stdin : fopen(path, "r");
    bench_mistake_t mistake = {0};
    if (file == NULL) {
        (void)fprintf(stderr, "tumble-bench: %s: %s\n", name, strerror(errno));
        return false;
    }
    const bool good = bench_config_read(config, file, &mistake);
    if (!good && mistake.line > 0U) {
        (void)fprintf(stderr, "tumble-bench: %s:%u: %s\n", name, mistake.line, mistake.what);
    } else if (!good) {
        (void)fprintf(stderr, "tumble-bench: %s: %s\n", name, mistake.what);
    }
    if (!is_stdin) {
        (void)fclose(file);
    }
    return good;
}

static bool prepare(bench_config_t *config, const bench_options_t *options)
{
    bench_config_defaults(config);
    if (options->scenario != NULL && !read_scenario(config, options->scenario)) {
        return false;
    }
    const char *const unread =
        (options->gain_record != NULL) ? bench_gain_file_read(options->gain_record, &config->gains) : NULL;
    if (unread != NULL) {
        (void)fprintf(stderr, "tumble-bench: %s: %s\n", options->gain_record, unread);
        return false;
    }
    const char *const wrong = bench_config_complete(config);
    if (wrong != NULL) {
        const char *const name = (options->scenario != NULL) ? options->scenario : "the defaults";
        (void)fprintf(stderr, "tumble-bench: %s: %s\n", name, wrong);
    }
    return wrong == NULL;
}

/* All processors, but no more than there are runs. */
static void choose_jobs(bench_options_t *options)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    if (options->jobs == 0U) {
        options->jobs = (processors < 1) ? 1U : (processors > BENCH_MAX_JOBS) ? BENCH_MAX_JOBS : (uint32_t)processors;
    }
    if (options->jobs > options->runs) {
        options->jobs = (uint32_t)options->runs;
    }
}

static int run(bench_options_t *options)
{
    static bench_config_t config;
    if (!prepare(&config, options)) {
        return BENCH_EXIT_USAGE;
    }
    bench_interrupt_watch();
    if (options->runs == 0U) {
        return bench_session(&config, options, stdout);
    }
    choose_jobs(options);
    return bench_campaign(&config, options, stdout);
}

int main(int count, char *arguments[])
{
    bench_options_t options;
    char wrong[200];
    if (!bench_options_read(&options, count, arguments, wrong)) {
        return refuse(wrong);
    }
    if (options.help) {
        (void)fputs(bench_options_help, stdout);
        return BENCH_EXIT_PASS;
    }
    if (options.keys) {
        bench_config_print_keys(stdout);
        return BENCH_EXIT_PASS;
    }
    const int code = run(&options);
    if (fflush(stdout) != 0) {
        (void)refuse("standard output cannot be written");
        return BENCH_EXIT_FAULT;
    }
    return code;
}
