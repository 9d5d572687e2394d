/* config_file.h - scenario files: one `key = value` a line.
 *
 *     # comment, empty lines
 *     stand.angle_rad = 4e-5
 *     block.u0 = 0.1 -0.02 0.03
 *     fault = stall at=1.3 phase=move duration=2
 *
 * `tumble bench --keys` prints the keys with their ranges, each at most once, and the lines that may repeat. Numbers are decimal (0x... where whole; the INDEX of an INDEX:SUBINDEX:BITS is hexadecimal in any
 * case), separated by blanks; nothing else may stand on a line. Reading stops at the first mistake. A schedule must be
 * given whole: its first line replaces the paper's. A fault whose duration is 0 is for good.
 */
#ifndef TUMBLE_WORLD_CONFIG_FILE_H
#define TUMBLE_WORLD_CONFIG_FILE_H

#include "world/config.h"

#include <stdbool.h>

/* What is wrong, for one line to the user. */
typedef struct {
    unsigned line; /* 0: not of one line */
    char what[200];
} bench_mistake_t;

#define BENCH_MAX_KEYS 160

/* Which keys have been given. */
typedef struct {
    bool key[BENCH_MAX_KEYS];
} bench_seen_t;

/* Take one line, which is cut into its words. */
bool bench_config_take(bench_config_t *config, char *line, bench_seen_t *seen, bench_mistake_t *mistake);

/* What no single line can show, once all are taken. */
bool bench_config_check(bench_config_t *config, const bench_seen_t *seen, bench_mistake_t *mistake);

#endif
