/* sim_bench.h - runs of the bench for tests: a scenario as text, and the world when it has ended. */
#ifndef TUMBLE_TESTS_UNIT_SIM_BENCH_H
#define TUMBLE_TESTS_UNIT_SIM_BENCH_H

#include "support.h"
#include "world/config.h"
#include "world/config_file.h"
#include "world/report.h"
#include "world/world.h"

extern bench_config_t config;
extern bench_world_t world;
extern bench_mistake_t mistake;

/* Read lines into `config`. Null: taken; else what is wrong. */
const char *read_lines(const char *text);

void run_lines(const char *text, uint64_t seed, const bench_watcher_t *watcher);
void run_to_a_move(void); /* to the fourth position, until the table turns */
tumble_coefficients_t found(void);

/* Done, and the gravity check is good. */
bool has_passed(void);

#endif
