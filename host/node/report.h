/* report.h - what a run has found, and how it goes, as JSON.
 *
 * The document of a run, schema "tumble.node/1", on one line: what a simulated run has in tumble.bench/1 as well, without
 * what only a simulation knows.
 *     seed: of the run
 *     end: "done" | "fault" | "interrupted" | "too long" | "left"
 *     exit: the exit code that a program with this run has
 *     state, failed_in, reason, status: names of the firmware's lists
 *     reason_number, reason_sentence: the reason once more
 *     drive_code: the drive's own error code, or 0
 *     drive_refusal: {index, subindex, abort, step, sentence} or null
 *     estimator: its name in TUMBLE_ESTIMATOR_LIST
 *     K, U0: 3 x 3 in V/g, 3 in V; null without a result
 *     u_K, u_U0: their standard uncertainties; null where none can be stated
 *     noise: {block_samples, noise_v (3), declared_v, above_declared (channels)}; null where nobody looked
 *     verification: {delta_g_g: list of {mounting, position, use, delta_g_g}, max_abs_delta_g_g, max_abs_fit_g,
 *         max_abs_check_g, limit_g, pass}; null without a result
 *     closure_g: by mounting; null without a result
 *     means: list of {mounting, position, samples, u_v (3), standard_error_v (3)} of the positions finished
 *     counters: {name: integer}: the firmware's, and of the interface: frames_foreign, kernel_received, kernel_sent,
 *         kernel_dropped, kernel_busy, error_frames, bus_offs, interface_downs; receive_buffer_bytes; latest_step_us
 *     cause: {failed_in, reason, reason_number, reason_sentence, drive_code}: of the run's first fault, whatever followed
 *         from it; the reason of a run that was aborted in FAULT is the command. null where there was none or the run got
 *         over it
 *     virtual_s: when it ended
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
