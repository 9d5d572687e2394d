/* gain_file.h - a gain record out of a file, in place of the firmware's non-volatile memory. */
#ifndef TUMBLE_LINUX_GAIN_FILE_H
#define TUMBLE_LINUX_GAIN_FILE_H

#include "tumble/core.h"

/* Read the file at `path` into memory of its own (one record a process) and let `source` point there. What the bytes are is
 * judged by the firmware. Null, or what went wrong. */
const char *bench_gain_file_read(const char *path, tumble_optimal_source_t *source);

#endif
