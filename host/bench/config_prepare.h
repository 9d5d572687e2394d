/* config_prepare.h - from a scenario file, or none, to a configuration that is complete. */
#ifndef TUMBLE_BENCH_CONFIG_PREPARE_H
#define TUMBLE_BENCH_CONFIG_PREPARE_H

#include "bench/config.h"

#include <stdbool.h>

/* Defaults, then what the file says ("-": standard input; null: nothing) and the file of a gain record (null: none), then
 * complete and fit for the firmware. `config` must not be moved
 * afterwards. False: one line on standard error, which begins with the name of the program, has said what is wrong. */
bool bench_config_prepare(bench_config_t *config, const char *path, const char *gain_record, const char *program);

/* The same for a simulation whose firmware is elsewhere: what only the firmware needs, such as gains, is not asked for. */
bool bench_config_prepare_stand(bench_config_t *config, const char *path, const char *program);

#endif
