/* stand_options.h - the command line of tumble-stand. */
#ifndef TUMBLE_LINUX_STAND_OPTIONS_H
#define TUMBLE_LINUX_STAND_OPTIONS_H

#include "stand_operator.h"

#include "arguments.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    const char *interface;
    const char *scenario; /* file, "-" for standard input, null for the defaults */
    uint64_t seed;
    stand_operator_kind_t operator;
    bench_asks_t asks;
} stand_options_t;

extern const char stand_options_help[];

/* False: one line on standard error has said what does not fit. */
bool stand_options_read(stand_options_t *options, int count, char *arguments[]);

#endif
