/* report.h - what a run has found, and how it goes, as JSON.
 *
 * The document of a run, on one line, has the schema docs/schemas/tumble.node-1.schema.json: what a simulated run has in
 * tumble.bench/1 as well, without what only a simulation knows. docs/real-bus.md lists the counters of the interface.
 *
 * A run as it goes: one JSON line per event, for whoever shows it to people.
 *
 *     event "state": the procedure has moved on: virtual_s, state, mounting, position, index, count, finished, attempt,
 *         reason, angle_deg (of the table; null while it is not known: before homing, after a fault of the axis)
 *     event "average": a tenth more of a mean is there: as above, and samples, wanted, mean_v (3),
 *         standard_error_v (3)
 *     event "question": a person is needed: kind "mounting" (with mounting), "angle" (with angle_deg) or "fault" (with
 *         reason and its sentence); in the interactive mode time stands still until the answer is there
 *     event "refused": the answer cannot be understood, or the firmware does not accept it: what
 *     event "end": end ("done", "fault", ...), exit
 */
#ifndef TUMBLE_NODE_REPORT_H
#define TUMBLE_NODE_REPORT_H

#include "computer.h"
#include "world/world.h"

#include <stdio.h>

/* The exit code of a run that has ended. */
int bench_exit_code(const bench_world_t *world);

/* The document; `cause`: TUMBLE_REASON_NONE, there is none. */
void node_report(const bench_world_t *world, const computer_t *computer, const tumble_progress_t *cause, FILE *out);

/* The events. */
void bench_progress_state(const bench_world_t *world, const tumble_progress_t *progress, FILE *out);
void bench_progress_average(const bench_world_t *world, tumble_taken_t taken, FILE *out);

void bench_progress_question(const bench_world_t *world, const bench_question_t *question, FILE *out);
void bench_progress_refused(const char *what, FILE *out);
void bench_progress_end(const bench_world_t *world, FILE *out);

#endif
