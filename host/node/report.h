/* report.h - the document of a run, on one line: schema docs/schemas/tumble.node-1.schema.json, what a simulated run has
 * in tumble.bench/1 as well (world/report.h), without what only a simulation knows. docs/gateway.md lists the counters of
 * the interface.
 */
#ifndef TUMBLE_NODE_REPORT_H
#define TUMBLE_NODE_REPORT_H

#include "computer.h"
#include "world/world.h"

#include <stdio.h>

/* `cause`: TUMBLE_REASON_NONE, there is none. */
void node_report(const bench_world_t *world, const computer_t *computer, const tumble_progress_t *cause, FILE *out);

#endif
