/* report.h - what a run has found, as JSON.
 *
 * The document, schema "tumble.bench/1":
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
 *     counters: {name: integer}: the firmware's, the bus's, the simulation's
 *     truth: {K, U0, alpha1_rad, alpha2_rad, alpha3_rad (by mounting), alpha4_rad (by position),
 *             theta_h_rad, theta_n_rad (by mounting; the platform's in theta_h), encoder_rad (4), drift_v (3)}
 *     faults: list of {kind, times}: those of the scenario, and how often each has come
 *     virtual_s: when it ended
 *     table: {at_rest, lowest_deg, highest_deg}: how far the table has turned since power-on, by the simulation's truth
 */
#ifndef TUMBLE_BENCH_REPORT_H
#define TUMBLE_BENCH_REPORT_H

#include "bench/arguments.h"
#include "bench/json.h"
#include "bench/world.h"

#include <stdbool.h>
#include <stdio.h>

/* The exit code of a run that has ended. */
int bench_exit_code(const bench_world_t *world);

/* Parts of it: what the firmware did and found; what the simulation was made of and where it ended. */
void bench_report_firmware(const bench_world_t *world, bench_json_t *json);
void bench_report_simulation(const bench_world_t *world, bench_json_t *json);

/* Where the table of the simulation has been since power-on, whatever its drive reports; and whether it rests now. */
typedef struct {
    double lowest_deg;
    double highest_deg;
    bool at_rest;
} bench_travel_t;

bench_travel_t bench_travel(const bench_world_t *world);

/* The extremes of several; at rest: all of them are. `first`: `all` holds nothing yet. */
void bench_travel_add(bench_travel_t *all, const bench_travel_t *one, bool first);

/* "table": {at_rest, lowest_deg, highest_deg}. */
void bench_report_table(const bench_travel_t *travel, bench_json_t *json);

/* Members of it: of the firmware, of the simulated bus. */
void bench_report_firmware_counters(const bench_world_t *world, bench_json_t *json);
void bench_report_bus_counters(const sim_bus_t *bus, bench_json_t *json);

/* The name of a counter, null where there is no such row; and its value: of the firmware, then of the bus. */
const char *bench_counter(const bench_world_t *world, size_t row, uint64_t *value);

/* "counters": {name: integer}. */
void bench_report_counters(const bench_world_t *world, bench_json_t *json);

/* The document, with a newline. */
void bench_report_document(const bench_world_t *world, FILE *out);

/* Mean (V) of the position at `index` and its standard error. False: not finished. */
bool bench_mean(const bench_world_t *world, uint8_t index, double mean_v[TUMBLE_CHANNELS],
                double error_v[TUMBLE_CHANNELS]);

/* The larger of what a gravity check found on fit and on check positions. */
double bench_largest_delta_g(const tumble_gravity_check_t *check);

/* What a drive has refused, or not done in time, as a sentence: object, abort code, and in which step; and that step's
 * name (tumble_stand_step_t). */
#define BENCH_REFUSAL_BYTES 200
void bench_refusal_sentence(const tumble_stand_refusal_t *refusal, char *text, size_t size);
const char *bench_step_name(uint8_t step);

/* "done", "fault", "interrupted", "too long", "left". */
const char *bench_end_name(bench_end_t end);

#endif
