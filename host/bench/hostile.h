/* hostile.h - a campaign of hostile lives: --campaign N.
 *
 * Each seed draws a life (hostile_draw.h): a stand, a drive with its habits, a run or two, commands, faults, frames of a
 * stranger, losses of power. The firmware with its keeper lives through it in virtual time (hostile_life.h), and the
 * simulation's truth is held against the invariants (hostile_watch.h). What breaks one ends its life, is told in one line
 * on standard error, replays alone with --campaign 1 --seed THAT, and is shrunk to the fewest events: the first
 * BENCH_HOSTILE_SHRUNK of a campaign. -v tells the shrunk list as well.
 *
 * The document, schema "tumble.hostile/1":
 *     runs, first_seed
 *     violated: how many lives; violations {kind: lives}; first: list of {seed, kind, at_s, what, drawn (events), world,
 *     events: list of texts}, in the order of the seeds
 *     faults {kind: times come to pass}, events {kind: times}, flipped_bits
 *     ends {state: {reason: times}} of DONE, FAULT and ABORT
 *     homings; sets {committed (by themselves), judged (of those, not excused), held}; lives_with_commit
 *     excuses {name: lives}
 *     table {at_rest, lowest_deg, highest_deg}: where the tables of all lives have been (report.h); at_rest: all ended so
 *     virtual_s, frames, steps
 *     speed {jobs, wall_s, cpu_s, ms_per_life (of processor time)}: the last member, and different every time
 *
 * Exit code 0: nothing is violated; 3: something is; 130: interrupted.
 *
 * The simulated bus has data frames of 11-bit identifiers alone, so there are neither remote frames (RTR) nor 29-bit ones:
 * a port drops both before the firmware sees them.
 */
#ifndef TUMBLE_BENCH_HOSTILE_H
#define TUMBLE_BENCH_HOSTILE_H

#include "bench/options.h"

#include <stdio.h>

#define BENCH_HOSTILE_SHRUNK 10U

/* Run it; the exit code of the program. */
int bench_hostile(const bench_options_t *options, FILE *out);

#endif
