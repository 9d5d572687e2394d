/* keeper_bench.h - a navigation computer with a keeper, on a memory of the test's own; around it the scripted drive and
 * block of navcomp_bench.h. The memory is what outlives power: `keeper_power_cycle` forgets everything else.
 *
 * The scripted block is free of noise, so a run on an unchanged block gives the same bits again; `drift` makes it a new one.
 */
#ifndef TUMBLE_TESTS_KEEPER_BENCH_H
#define TUMBLE_TESTS_KEEPER_BENCH_H

#include "keeper_memory.h"
#include "navcomp/uncertainty.h"
#include "navcomp_bench.h"

#define POSITIONS 18U /* of the schedule */

extern tumble_stand_record_t declared_stand;
extern tumble_declared_t declared;
extern bool board_inhibits;

/* A fresh memory, and everything around it; nothing is powered on. */
void keeper_prepare(void);

/* Power fails and comes back: drive, block and computer begin anew, clock and memory go on. */
void keeper_power_cycle(void);

void keeper_power_on(void);
tumble_sets_state_t state_of_keeper(void);
tumble_state_t run_state(void);
tumble_status_t tell(tumble_command_t command);

/* ACCEPT of the proposal that is there, by its name. */
tumble_status_t accept_proposal(void);

/* Something else than before: the biases move by so many V. */
void drift(double by_v);

/* Until the memory is at rest. */
void settle_memory(void);
void settle_and_power_cycle(void);
void settle_to(tumble_verdict_t verdict);
void assert_verdict(tumble_verdict_t verdict); /* as it is now */
void assert_objects(uint16_t objections);

/* A command that is taken, and then so many seconds, or until the memory is at rest. */
void obey_for(double seconds, tumble_command_t command);
void decide(tumble_command_t command);

void assert_state_after(double seconds, tumble_state_t state);
void assert_starts_after(double seconds, uint32_t self_started); /* runs that it has begun by itself */
void assert_resumable(uint8_t positions);
void assert_resumable_after_power(uint8_t positions);
void keeper_power_cycle_for(double seconds);

/* A whole run; and what becomes of it. */
void run_to_done(void);
tumble_verdict_t run_and_judge(void);
void assert_verdict_after(double drift_v, tumble_verdict_t verdict);
void hold_one(void); /* a first set, and a proposal that waits for an operator */

tumble_set_t set_of(tumble_which_set_t which);

/* Until so many positions are finished, and then the one after them averages. */
void run_to_average(uint8_t index);
void start_to_average(uint8_t index);

/* A run that loses power when so many positions are finished. */
void start_and_cut(uint8_t index);

/* The run that is under way. */
void end_and_settle(void);

void resume_to_end(void);
void resume_to_commit(void);

/* After a loss of power so many positions are there, the others are measured, and the result is committed. */
void assert_goes_on(uint8_t kept);

#endif
