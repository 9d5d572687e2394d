/* run_log.h - events of a run and of its result (event_log.h), as tumble-node has them and tumble-gateway sees them. */
#ifndef TUMBLE_LINUX_RUN_LOG_H
#define TUMBLE_LINUX_RUN_LOG_H

#include "tumble/navcomp.h"
#include "tumble/sets.h"

#include <stdbool.h>

/* The procedure has come to this state: a line "fault" with its remedy, or "state". `cause`: the fault that the run has
 * not got over, TUMBLE_REASON_NONE if there is none. `waits`: after a fault for a command. */
void run_log_state(const tumble_progress_t *now, const tumble_progress_t *cause, bool waits);

/* What has become of a result, or of a command about sets: `verdict`, and with it `counter`, `objections` or `status`;
 * nothing else is looked at. A line "commit", "held", "repeated", "discarded" or "memory". */
void run_log_verdict(const tumble_sets_state_t *state);

#endif
