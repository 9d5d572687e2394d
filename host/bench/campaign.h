/* campaign.h - thousands of runs, each of its own seed, on several processes.
 *
 * Lines come in the order of the seeds, whatever the number of processes, so the same campaign prints the same bytes.
 * One line per run: seed, exit, state, reason, pass, K (9 numbers), U0 (3), max_abs_delta_g_g (null without a result),
 * truth {K, U0}, virtual_s, frames, table {at_rest, lowest_deg, highest_deg} (bench/report.h); with --means also means
 * (3 numbers per position, in the schedule's order; null where not measured).
 *
 * The summary, schema "tumble.campaign/1": runs, first_seed, exits {code: runs}, reasons {name: runs}, K and U0
 * {mean_error, rms_error}: lists over the runs with a result; frames, virtual_s, table (the extremes of all runs; at_rest: all ended so); and, different every time: jobs,
 * wall_s, cpu_s, calibrations_per_s and frames_per_s (of wall time), frames_per_cpu_s, calibrations_per_cpu_s.
 */
#ifndef TUMBLE_BENCH_CAMPAIGN_H
#define TUMBLE_BENCH_CAMPAIGN_H

#include "bench/config.h"
#include "bench/options.h"

#include <stdio.h>

/* Run it; the exit code of the program. Messages about the system's failures go to standard error. */
int bench_campaign(const bench_config_t *config, const bench_options_t *options, FILE *out);

#endif
