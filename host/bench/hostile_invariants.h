/* hostile_invariants.h - the watch over a life (hostile_watch.h) at work: whoever lives it tells it what happens. */
#ifndef TUMBLE_BENCH_HOSTILE_INVARIANTS_H
#define TUMBLE_BENCH_HOSTILE_INVARIANTS_H

#include "bench/hostile_state.h"

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

void bench_watch_break(bench_life_t *life, bench_broken_t kind, double value, uint32_t what);

#endif
