/* scenario_file.h - a configuration out of a scenario file, for a program on a CAN interface. */
#ifndef TUMBLE_PROGRAMS_SCENARIO_FILE_H
#define TUMBLE_PROGRAMS_SCENARIO_FILE_H

#include "world/config.h"

#include <stdbool.h>

/* Defaults, then what the file says ("-": standard input; null: nothing) and the file of a gain record (null: none), then
 * complete and fit for the firmware. `config` must not be moved afterwards. False: one line on standard error has said
 * what is wrong. */
bool bench_config_prepare(bench_config_t *config, const char *path, const char *gain_record);

/* The same for a simulation whose firmware is elsewhere: what only the firmware needs, such as gains, is not asked for. */
bool bench_config_prepare_stand(bench_config_t *config, const char *path);

#endif
