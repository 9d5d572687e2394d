/* config_lines.h - the lines of a scenario file that may repeat (private to the reading of it).
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
#ifndef TUMBLE_BENCH_CONFIG_LINES_H
#define TUMBLE_BENCH_CONFIG_LINES_H

#include "bench/config.h"
#include "bench/config_text.h"

/* Take such a line. Null: taken. "": not a key of these. Else what is wrong with it. */
const char *bench_config_line(bench_config_t *config, const char *key, const bench_words_t *words);

#endif
