#include "sim_bench.h"

#include <string.h>

bench_config_t config;
bench_world_t world;
bench_mistake_t mistake;

const char *read_lines(const char *text)
{
    char lines[4096];
    bench_seen_t seen = {{false}};
    TEST_ASSERT_TRUE(strlen(text) < sizeof lines);
    (void)strcpy(lines, text);
    mistake = (bench_mistake_t){0};
    bench_config_defaults(&config);
    for (char *line = lines, *end; *line != '\0'; line = end) {
        end = line + strcspn(line, "\n");
        end += (*end == '\n') ? 1 : 0;
        if (end > line && end[-1] == '\n') {
            end[-1] = '\0';
        }
        mistake.line++;
        if (!bench_config_take(&config, line, &seen, &mistake)) {
            return mistake.what;
        }
    }
    return bench_config_check(&config, &seen, &mistake) ? bench_config_complete(&config) : mistake.what;
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

bool has_passed(void)
{
    tumble_result_t result;
    return world.end == WORLD_DONE && tumble_navcomp_result(&world.navcomp, &result) == TUMBLE_OK && result.pass;
}
