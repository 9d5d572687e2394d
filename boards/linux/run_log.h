/* run_log.h - events of a run and of its result (event_log.h), as tumble-node has them and tumble-gateway sees them. */
#ifndef TUMBLE_LINUX_RUN_LOG_H
#define TUMBLE_LINUX_RUN_LOG_H

#include "tumble/navcomp.h"
#include "tumble/sets.h"

#include <stdbool.h>

/* Is `now` worth a line to somebody who was told of `before`: another state, position, attempt or reason, or a fault in
 * another state? Numbers and times that run on are not. */
bool run_log_is_news(const tumble_progress_t *now, const tumble_progress_t *before);

/* The procedure has come to this state: a line "fault" with its remedy, or "state". `cause`: the fault that the run has
 * not got over, TUMBLE_REASON_NONE if there is none; null: not known, and why a run was given up is then not said.
 * `waits`: after a fault for a command. */
void run_log_state(const tumble_progress_t *now, const tumble_progress_t *cause, bool waits);

/* Of the sets what was told last; begun as all zero. */
typedef struct {
    bool has_begun; /* what was so at first is no event */
    uint8_t verdict;
    uint32_t counter;
} run_log_sets_t;

/* What has become of a result, or of a command about sets, if that is news: a line "commit", "held", "repeated",
 * "discarded" or "memory". The counter of a set that has become active comes a moment after the verdict, and the line
 * with it. Of `state` it looks at `verdict`, `counter`, `objections` and `status`. */
void run_log_sets(run_log_sets_t *told, const tumble_sets_state_t *state);

#endif
