/* keeping.h - what a scenario says of the keeper: for programs whose firmware has non-volatile memory (tumble-node). */
#ifndef TUMBLE_WORLD_KEEPING_H
#define TUMBLE_WORLD_KEEPING_H

#include "navcomp/keeper.h"

#include <stdbool.h>

/* A configuration to be read from lines; `flags` within the settings are made of the three switches. */
typedef struct {
    char serial[TUMBLE_SET_SERIAL_BYTES + 1U]; /* of the block; empty: not told */
    bool commits;                              /* good sets by themselves */
    bool first;                                /* the first one, too */
    bool starts;                               /* runs that are due */
    tumble_sets_settings_t settings;
} bench_keeping_t;

/* Limits for a good stand: 1e-3 (ratio, rad or g) for uncertainties, 1e-4 a month for drift, three standard
 * uncertainties; sets commit themselves, but the first waits; nothing is ever due. No serial number:
 * who keeps coefficients must be told whose they are. */
void bench_keeping_defaults(bench_keeping_t *keeping);

/* Set the flags by the switches. */
void bench_keeping_complete(bench_keeping_t *keeping);

#endif
