/* hostile_invariants.h - the watch over a life (hostile_watch.h) at work: whoever lives it tells it what happens. */
#ifndef TUMBLE_WORLD_HOSTILE_INVARIANTS_H
#define TUMBLE_WORLD_HOSTILE_INVARIANTS_H

#include "world/hostile_state.h"

void bench_watch_init(bench_life_t *life);

/* After every event of the world: the table and the sets. */
void bench_watch_look(bench_life_t *life);

/* The procedure has moved on. */
void bench_watch_change(bench_life_t *life, const tumble_progress_t *progress);

/* Something that may move the table has been commanded; a run has ended or ABORT was taken. */
void bench_watch_commanded(bench_life_t *life);
void bench_watch_ended(bench_life_t *life);

void bench_watch_excuse(bench_life_t *life, bench_excuse_t excuse);
bool bench_watch_has_excuse(const bench_life_t *life, bench_excuse_t excuse);

/* Every readable object of the computer. */
void bench_watch_read_all(bench_life_t *life);

/* The sets (hostile_sets.c): after every step of the computer; and the power is back. */
void bench_watch_sets(bench_life_t *life);
void bench_watch_power_on(bench_life_t *life);

/* Somebody has given a command about the proposal, or it was refused. For some seconds the proposal may go, or not. */
void bench_watch_decide(bench_life_t *life, tumble_command_t command, bool refused);
void bench_watch_may_go(bench_life_t *life, bool may);

/* Service level, run number, means (hostile_rules.c). A request to an SDO server of the computer; a write that it took;
 * a frame of the block; a sample that went into a mean. */
void bench_watch_request(bench_life_t *life, const tumble_can_frame_t *frame);
void bench_watch_written(bench_life_t *life, uint16_t index, uint8_t subindex);
void bench_watch_block_frame(bench_life_t *life, const tumble_can_frame_t *frame);
void bench_watch_sample(bench_life_t *life, tumble_taken_t taken, const tumble_block_sample_t *sample);

/* The state has changed: a run begins; it may have begun. All means that there are. After every event. Power is back, or
 * the computer was reset: `number` too. */
void bench_watch_count_run(bench_life_t *life, bool begins, bool may_begin);
void bench_watch_means(bench_life_t *life);
void bench_watch_rules(bench_life_t *life);
void bench_watch_begin_again(bench_life_t *life);

void bench_watch_break(bench_life_t *life, bench_broken_t kind, double value, uint32_t what);

#endif
