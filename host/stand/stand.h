/* stand.h - tumble-stand: drive, block and operator of the simulation, in real time on a CAN interface.
 *
 * The document, schema "tumble.stand/1", on one line:
 *     interface, seed
 *     truth: {K, U0, alpha1_rad, alpha2_rad, alpha3_rad (by mounting), alpha4_rad (by position),
 *             theta_h_rad, theta_n_rad (by mounting; the platform's in theta_h), with a bolting beta_rad, tau_rad (by
 *             mounting), encoder_rad (4), drift_v (3)}
 *     faults: list of {kind, times}: those of the scenario, and how often each has come
 *     virtual_s: when it ended
 *     table: {at_rest, lowest_deg, highest_deg}: how far the table has turned since power-on, by the simulation's truth
 *     angle_deg: where the table is
 *     operator: {answers, refusals}
 *     counters: {name: integer}: of the simulated bus (bus_...) and of the interface
 */
#ifndef TUMBLE_STAND_STAND_H
#define TUMBLE_STAND_STAND_H

#include "stand_log.h"
#include "world/config.h"

/* Serve until told to end; the exit code of the program. The document goes to standard output. */
int stand_run(const bench_config_t *config, const stand_options_t *options);

#endif
