/* node.h - tumble-node: the navigation computer in real time on a CAN interface. */
#ifndef TUMBLE_LINUX_NODE_H
#define TUMBLE_LINUX_NODE_H

#include "events.h"
#include "folder.h"
#include "navcomp/keeper.h"
#include "node_log.h"
#include "node_options.h"
#include "nv_file.h"
#include "outlet.h"
#include "port_linux.h"
#include "world/config.h"
#include "world/world.h"

typedef struct {
    const node_options_t *options;
    /* The bench's record of a run, so that its reports serve here as well: of it only the configuration, the firmware,
     * its progress and the time are in use, no simulation. */
    bench_world_t world;
    port_linux_t port;
    nv_file_t nv; /* in use if the options name a file; and so are these five */
    tumble_keeper_t keeper;
    tumble_keeper_config_t keeper_config;
    tumble_stand_memory_t stand_memory;
    tumble_inclinations_memory_t inclinations_memory;
    tumble_whole_work_t whole_work;
    events_t events;
    bench_folder_t folder;
    node_log_t log;
    outlet_t documents;      /* to standard output */
    outlet_t progress;       /* not open: nobody wants to know */
    uint64_t epoch_us;       /* UTC at the port's time 0: bus.log */
    tumble_progress_t fault; /* the first that the run has not got over; TUMBLE_REASON_NONE: there is none */
    bool in_first_fault;     /* it is the one in which the run waits now */
    uint32_t faulted_run;    /* its number */
    uint64_t faulted_us;     /* since when it is in FAULT; SIM_NEVER: it is not */
    uint64_t ending_us;      /* since when it waits for the table to rest; SIM_NEVER: not yet */
    uint64_t latest_us;      /* the longest that a step came after its time */
    uint32_t refused;        /* commands, as last counted */
    bool reported;           /* the run that has ended */
    bool left;               /* nobody will give a command after a fault */
} node_t;

/* Serve until the end; the exit code of the program. Documents go to standard output. */
int node_run(const bench_config_t *config, const node_options_t *options);

/* The document of a run: schema "tumble.node/1"; as tumble.bench/1, without what only a simulation knows, and with
 * counters of the interface: frames_foreign, kernel_received, kernel_sent, kernel_dropped, kernel_busy, error_frames,
 * bus_offs, interface_downs; receive_buffer_bytes; latest_step_us. On one line. The reason of a run that was aborted in
 * FAULT is the command; `cause` {failed_in, reason, reason_number, reason_sentence, drive_code} is that of its first
 * fault, whatever followed from it; null where there was none or the run got over it. */
void node_report(const node_t *node, FILE *out);

/* What waits for its reader goes, as far as it can; that something was left out is told once. */
void node_outputs_retry(node_t *node);

/* Standard output cannot be written: says so, and returns the exit code. */
int node_outputs_refuse(void);

/* The end of documents and progress. A result is waited for: whoever reads the documents may be slow, and a signal ends
 * it. Returns `code`, or that of documents which have not gone. */
int node_outputs_end(node_t *node, int code);

#endif
