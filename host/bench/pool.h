/* pool.h - runs of a campaign on several processes, taken in the order of their numbers.
 *
 * Every run leaves a record of a fixed size. Workers send theirs through pipes; whoever began takes them one by one,
 * number 0 first, so what he makes of them does not depend on the number of processes.
 */
#ifndef TUMBLE_BENCH_POOL_H
#define TUMBLE_BENCH_POOL_H

#include <stdint.h>
#include <stdio.h>

typedef struct {
    void *context;                                             /* handed to both */
    uint64_t count;                                            /* runs, numbered from 0 */
    uint32_t jobs;                                             /* processes, 1 to BENCH_MAX_JOBS; 1: all in this one */
    void *record;                                              /* room for one, */
    uint32_t bytes;                                            /* of this size */
    void (*run)(void *context, uint64_t number, void *record); /* in some process */
    void (*take)(void *context, uint64_t number, const void *record); /* in this one, in order */
} bench_pool_t;

typedef struct {
    double wall_s;
    double cpu_s; /* of all processes */
} bench_pool_times_t;

/* All runs. BENCH_EXIT_PASS; BENCH_EXIT_FAULT: a process cannot be started or has died, which is told on standard error;
 * BENCH_EXIT_INTERRUPTED. */
int bench_pool_run(const bench_pool_t *pool, bench_pool_times_t *times);

#endif
