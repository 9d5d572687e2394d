/* node.h - tumble-node: the navigation computer of boards/linux with a scenario for its configuration, a log, and
 * documents of its runs. */
#ifndef TUMBLE_NODE_NODE_H
#define TUMBLE_NODE_NODE_H

#include "computer.h"
#include "folder.h"
#include "node_log.h"
#include "outlet.h"
#include "world/config.h"
#include "world/world.h"

typedef struct {
    const node_options_t *options;
    /* The bench's record of a run, so that its reports serve here as well: of it only the configuration, the firmware,
     * its progress and the time are in use, no simulation. */
    bench_world_t world;
    computer_t computer;
    bench_folder_t folder;
    node_log_t log;
    outlet_t documents;      /* to standard output */
    outlet_t progress;       /* not open: nobody wants to know */
    tumble_progress_t fault; /* the first that the run has not got over; TUMBLE_REASON_NONE: there is none */
    bool in_first_fault;     /* it is the one in which the run waits now */
    uint32_t faulted_run;    /* its number */
    uint64_t faulted_us;     /* since when it is in FAULT; SIM_NEVER: it is not */
    uint64_t ending_us;      /* since when it waits for the table to rest; SIM_NEVER: not yet */
    uint32_t refused;        /* commands, as last counted */
    bool reported;           /* the run that has ended */
    bool left;               /* nobody will give a command after a fault */
} node_t;

/* Serve until the end; the exit code of the program. Documents go to standard output. */
int node_run(const bench_config_t *config, const node_options_t *options);

#endif
