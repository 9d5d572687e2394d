#include "sim_bench.h"

#include <stdio.h>
#include <string.h>

bench_config_t config;
bench_world_t world;
bench_mistake_t mistake;

const char *read_lines(const char *text)
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

void run_lines(const char *text, uint64_t seed, const bench_watcher_t *watcher)
{
    static const bench_watcher_t NOBODY = {0};
    const char *const wrong = read_lines(text);
    TEST_ASSERT_NULL_MESSAGE(wrong, text);
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, seed, (watcher != NULL) ? watcher : &NOBODY));
    bench_world_run(&world);
}

void run_to_a_move(void)
{
    while (world.progress.state != TUMBLE_STATE_MOVE || world.progress.index != 3U || bench_world_is_at_rest(&world)) {
        TEST_ASSERT_TRUE(bench_world_advance(&world));
    }
}

tumble_coefficients_t found(void)
{
    tumble_result_t result;
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_result(&world.navcomp, &result));
    return *result.coefficients;
}
