/* stand.h - tumble-stand: drive, block and operator of the simulation, in real time on a CAN interface.
 *
 * The document is one line: docs/schemas/tumble.stand-1.schema.json, counters in docs/gateway.md.
 */
#ifndef TUMBLE_STAND_STAND_H
#define TUMBLE_STAND_STAND_H

#include "stand_log.h"
#include "world/config.h"

/* Serve until told to end; the exit code of the program. The document goes to standard output. */
int stand_run(const bench_config_t *config, const stand_options_t *options);

#endif
