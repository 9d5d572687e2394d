/* run_log.h - events that several programs tell (event_log.h): of a run and of its result, as tumble-node has them and
 * tumble-gateway sees them, and of a CAN interface. */
#ifndef TUMBLE_PROGRAMS_RUN_LOG_H
#define TUMBLE_PROGRAMS_RUN_LOG_H

#include "can_socket.h"
#include "tumble/navcomp.h"
#include "tumble/sets.h"
#include "world/json.h"

#include <stdbool.h>
#include <stdint.h>

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

/* What to look at when the procedure has stopped for a reason, in one or two sentences: the words of docs/operations.md
 * (remedies.c). Safe for values outside the list, never null. */
const char *tumble_reason_remedy(tumble_reason_t reason);

/* Of the interface what was told last; begun as all zero. */
typedef struct {
    uint64_t downs;
    bool is_down;
} link_log_t;

/* The event "link", after every step, and only while the log is on: the interface goes, and comes back. One that went and
 * is back by now is told as both. */
void link_log_update(link_log_t *told, const can_socket_t *can);

/* The counters of the interface, as members of a document. */
void link_report(bench_json_t *json, const can_socket_counters_t *counters);

#endif
