/* profile_lines.h - the lines of a scenario file that may repeat and are about the drive: its process data and objects.
 */
#ifndef TUMBLE_WORLD_PROFILE_LINES_H
#define TUMBLE_WORLD_PROFILE_LINES_H

#include "world/config.h"
#include "world/config_keys.h"

/* Take such a line. Null: taken. "": not a key of these. Else what is wrong with it. */
const char *bench_take_profile_line(bench_config_t *config, const char *key, const bench_words_t *words);

#endif
