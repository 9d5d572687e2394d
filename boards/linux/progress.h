/* progress.h - a run as it goes, one JSON line per event, for whoever shows it to people.
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
#ifndef TUMBLE_LINUX_PROGRESS_H
#define TUMBLE_LINUX_PROGRESS_H

#include "world/world.h"

#include <stdint.h>
#include <stdio.h>

void bench_progress_state(const bench_world_t *world, const tumble_progress_t *progress, FILE *out);
void bench_progress_average(const bench_world_t *world, tumble_taken_t taken, FILE *out);

void bench_progress_question(const bench_world_t *world, const bench_question_t *question, FILE *out);
void bench_progress_refused(const char *what, FILE *out);
void bench_progress_end(const bench_world_t *world, FILE *out);

#endif
