/* node_options.h - the command line of tumble-node. */
#ifndef TUMBLE_LINUX_NODE_OPTIONS_H
#define TUMBLE_LINUX_NODE_OPTIONS_H

#include "arguments.h"

#include <stdbool.h>

typedef struct {
    const char *interface;
    const char *scenario; /* file, "-" for standard input, null for the defaults */
    const char *out;      /* run folder, or null */
    const char *gains;    /* file of a gain record, or null */
    const char *nv;       /* file of the non-volatile memory, or null: there is none */
    int progress_fd;      /* -1: none */
    double patience_s;    /* after a fault, for a command to go on */
    bool start;
    bench_asks_t asks;
} node_options_t;

extern const char node_options_help[];

/* False: one line on standard error has said what does not fit. */
bool node_options_read(node_options_t *options, int count, char *arguments[]);

#endif
