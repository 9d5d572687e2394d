/* session.h - one run with everything that goes with it: folder, progress, answers, pace, guests. */
#ifndef TUMBLE_BENCH_SESSION_H
#define TUMBLE_BENCH_SESSION_H

#include "bench/config.h"
#include "bench/options.h"

#include <stdio.h>

/* Run it and print its document to `out`; the exit code of the program. One line on standard error says what went wrong
 * outside the run itself. */
int bench_session(const bench_config_t *config, const bench_options_t *options, FILE *out);

#endif
