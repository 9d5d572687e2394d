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
 *             theta_h_rad, theta_n_rad (by mounting; the platform's in theta_h), with a bolting beta_rad, tau_rad (by
 *             mounting), encoder_rad (4), drift_v (3)}
 *     faults: list of {kind, times}: those of the scenario, and how often each has come
 *     virtual_s: when it ended
 *     table: {at_rest, lowest_deg, highest_deg}: how far the table has turned since power-on, by the simulation's truth
 */
#ifndef TUMBLE_LINUX_REPORT_H
#define TUMBLE_LINUX_REPORT_H

#include "json.h"
#include "world/readout.h"

/* The exit code of a run that has ended. */
int bench_exit_code(const bench_world_t *world);

/* Parts of it: what the firmware did and found; what the simulation was made of and where it ended. */
void bench_report_firmware(const bench_world_t *world, bench_json_t *json);
void bench_report_simulation(const bench_world_t *world, bench_json_t *json);

/* Members of "counters": of the firmware, of the simulated bus. */
void bench_report_firmware_counters(const bench_world_t *world, bench_json_t *json);
void bench_report_bus_counters(const sim_bus_t *bus, bench_json_t *json);

#endif
