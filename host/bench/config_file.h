/* config_file.h - scenario files: one `key = value` a line.
 *
 *     # comment, empty lines
 *     stand.angle_rad = 4e-5
 *     block.u0 = 0.1 -0.02 0.03
 *     fault = stall at=1.3 phase=move duration=2
 *
 * Keys are those of bench_config_keys (tumble-bench --keys prints them with their ranges), each at most once. Numbers
 * are decimal (0x... where whole), separated by blanks; nothing else may stand on a line. Reading stops at the first
 * mistake. The lines that may repeat:
 *
 *     mounting = NUMBER  TILT_DEG TILT_SINE TILT_COSINE  M11 M12 M13 M21 ... M33
 *     position = MOUNTING NUMBER fit|check  ANGLE_DEG SINE COSINE
 *     fault = KIND at=MOUNTING.POSITION [phase=mount|home|move|settle|average] ...   or   fault = KIND time=SECONDS ...
 *         [delay=S] [duration=S, 0: for good] [times=N] [channels=xyz] [value=X] [count=N]
 *         [id=N] [mask=N] [probability=P]
 *     profile.receive_pdo = NUMBER COB_ID INDEX:SUBINDEX:BITS ...
 *     profile.transmit_pdo = NUMBER COB_ID INHIBIT_100US EVENT_MS INDEX:SUBINDEX:BITS ...
 *     profile.write = INDEX SUBINDEX SIZE VALUE
 *
 * Indices are hexadecimal. A schedule must be given whole: its first line replaces the paper's.
 */
#ifndef TUMBLE_BENCH_CONFIG_FILE_H
#define TUMBLE_BENCH_CONFIG_FILE_H

#include "bench/config.h"

#include <stdbool.h>
#include <stdio.h>

/* What is wrong, for one line to the user. */
typedef struct {
    unsigned line; /* 0: not of one line */
    char what[200];
} bench_mistake_t;

/* Read lines into `config`, which holds the defaults. */
bool bench_config_read(bench_config_t *config, FILE *file, bench_mistake_t *mistake);

#endif
