/* report.h - what a run has found, and how it goes, as JSON: for tumble.bench/1 of a simulated run, tumble.node/1 of a
 * computer and tumble.stand/1 of a stand on a real bus. docs/schemas says what each member means.
 */
#ifndef TUMBLE_WORLD_REPORT_H
#define TUMBLE_WORLD_REPORT_H

#include "world/json.h"
#include "world/world.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Of a program with a run that has ended. */
enum { WORLD_EXIT_PASS = 0, WORLD_EXIT_LIMITS = 1, WORLD_EXIT_FAULT = 3, WORLD_EXIT_INTERRUPTED = 130 };

int bench_exit_code(const bench_world_t *world);

/* "done", "fault", "interrupted", "too long", "left". */
const char *bench_end_name(world_end_t end);

/* Mean (V) of the position at `index` and its standard error. False: not finished. */
bool bench_mean(const bench_world_t *world, uint8_t index, double mean_v[TUMBLE_CHANNELS],
                double error_v[TUMBLE_CHANNELS]);

/* What a drive has refused, or not done in time, as a sentence: object, abort code, and in which step. */
#define BENCH_REFUSAL_BYTES 200
void bench_refusal_sentence(const tumble_stand_refusal_t *refusal, char *text, size_t size);

/* Where the table of the simulation has been since power-on, whatever its drive reports; and whether it rests now. */
typedef struct {
    double lowest_deg;
    double highest_deg;
    bool at_rest;
} bench_travel_t;

bench_travel_t bench_travel(const bench_world_t *world);

/* Members of a document. */

/* `seed` to `means`. */
void bench_report_run(const bench_world_t *world, bench_json_t *json);

/* `truth` and `faults`; `table`. */
void bench_report_truth(const bench_world_t *world, bench_json_t *json);
void bench_report_table(const bench_world_t *world, bench_json_t *json);

/* Those of `counters` that are the firmware's; that are the simulated bus's. */
void bench_report_counters(const bench_world_t *world, bench_json_t *json);
void bench_report_bus_counters(const bench_world_t *world, bench_json_t *json);

/* A run as it goes: one JSON line per event, for whoever shows it to people. All have virtual_s but `refused`. */

/* "state": the procedure has moved on: state, mounting, position, index, count, finished, attempt, reason, angle_deg (of
 * the table; null while it is not known: before homing, after a fault of the axis). */
void bench_progress_state(const bench_world_t *world, bench_json_t *json);

/* "angle": angle_deg. Returns whether the table moves. */
bool bench_progress_angle(const bench_world_t *world, bench_json_t *json);

/* "average": a tenth more of a mean is there: as "state", and samples, wanted, mean_v (3), standard_error_v (3). */
void bench_progress_average(const bench_world_t *world, uint32_t samples, bench_json_t *json);
bool bench_is_tenth(const bench_world_t *world, uint32_t samples);

/* "question": a person is needed: kind "mounting" (with mounting), "angle" (with angle_deg) or "fault" (with reason and
 * its sentence). */
void bench_progress_question(const bench_world_t *world, const bench_question_t *question, bench_json_t *json);

/* "refused": the answer cannot be understood, or the firmware does not accept it: what. */
void bench_progress_refused(const char *what, bench_json_t *json);

/* "end": end ("done", "fault", ...), exit. */
void bench_progress_end(const bench_world_t *world, bench_json_t *json);

#endif
