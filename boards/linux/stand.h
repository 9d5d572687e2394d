/* stand.h - tumble-stand: drive, block and operator of the simulation, in real time on a CAN interface. */
#ifndef TUMBLE_LINUX_STAND_H
#define TUMBLE_LINUX_STAND_H

#include "stand_options.h"
#include "world/config.h"

/* Serve until told to end; the exit code of the program. The document, schema "tumble.stand/1", goes to standard
 * output: interface, seed, truth, faults, virtual_s and table as of tumble.bench/1; angle_deg: where the table is; operator
 * {answers, refusals}; counters: of the simulated bus (bus_...) and of the interface. */
int stand_run(const bench_config_t *config, const stand_options_t *options);

#endif
