/* sim_bench.h - runs of the bench for tests: a scenario as text, and the world when it has ended. */
#ifndef TUMBLE_TESTS_UNIT_SIM_BENCH_H
#define TUMBLE_TESTS_UNIT_SIM_BENCH_H

#include "bench/config.h"
#include "bench/config_file.h"
#include "bench/report.h"
#include "bench/world.h"
#include "support.h"

#include <stdio.h>
#include <string.h>

static bench_config_t config;
static bench_world_t world;
static bench_mistake_t mistake;

/* Read lines into `config`. Null: taken; else what is wrong. */
static inline const char *read_lines(const char *text)
{
    FILE *const file = tmpfile();
    TEST_ASSERT_NOT_NULL(file);
    (void)fputs(text, file);
    rewind(file);
    memset(&mistake, 0, sizeof mistake);
    bench_config_defaults(&config);
    const bool good = bench_config_read(&config, file, &mistake);
    (void)fclose(file);
    return good ? bench_config_complete(&config) : mistake.what;
}

static inline void run_lines(const char *text, uint64_t seed, const bench_watcher_t *watcher)
{
    static const bench_watcher_t NOBODY = {0};
    const char *const wrong = read_lines(text);
    TEST_ASSERT_NULL_MESSAGE(wrong, text);
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, seed, (watcher != NULL) ? watcher : &NOBODY));
    bench_world_run(&world);
}

static inline tumble_coefficients_t found(void)
{
    tumble_result_t result;
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_result(&world.navcomp, &result));
    return *result.coefficients;
}

#endif
