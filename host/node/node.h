/* node.h - tumble-node: the navigation computer of boards/linux with a scenario for its configuration, a log, and
 * documents of its runs. */
#ifndef TUMBLE_NODE_NODE_H
#define TUMBLE_NODE_NODE_H

#include "node_log.h"
#include "world/config.h"

/* Serve until the end; the exit code of the program. Documents go to standard output. */
int node_run(const bench_config_t *config, const node_options_t *options);

#endif
