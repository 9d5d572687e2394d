/* options.h - the command line of tumble-bench. */
#ifndef TUMBLE_BENCH_OPTIONS_H
#define TUMBLE_BENCH_OPTIONS_H

#include "bench/arguments.h"

#include <stdbool.h>
#include <stdint.h>

#define BENCH_MAX_JOBS 64

/* Who mounts the block, and who tells the firmware so. */
typedef enum {
    BENCH_OPERATOR_BY_ITSELF = 0, /* the simulated operator does both, in the time that the scenario gives him */
    BENCH_OPERATOR_ON_CONFIRM,    /* a guest confirms, and in that moment the block is on */
    BENCH_OPERATOR_NEVER          /* nobody mounts */
} bench_operator_t;

typedef struct {
    const char *scenario;    /* file, "-" for standard input, null for the defaults */
    const char *out;         /* run folder, or null */
    const char *listen;      /* path of a socket for guests, or null */
    const char *gain_record; /* file, or null */
    uint64_t seed;
    uint64_t runs;  /* 0: one run with its document; else a campaign */
    uint64_t lives; /* 0: none; else a campaign of hostile lives */
    uint32_t jobs;
    uint32_t guests; /* wait for so many before time begins */
    int progress_fd; /* -1: none */
    double pace;     /* virtual seconds per second; 0: as fast as it goes */
    bench_operator_t operator;
    bool means;
    bool summary;
    bool interactive;
    bool verbose;
    bool keys;
    bench_asks_t asks;
} bench_options_t;

/* False: one line on standard error has said what does not fit. */
bool bench_options_read(bench_options_t *options, int count, char *arguments[]);

extern const char bench_options_help[];

#endif
