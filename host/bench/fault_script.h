/* fault_script.h - begins and ends the faults of a scenario at their moments. */
#ifndef TUMBLE_BENCH_FAULT_SCRIPT_H
#define TUMBLE_BENCH_FAULT_SCRIPT_H

#include "procedure/procedure.h"
#include "simulation/scenario.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct bench_world bench_world_t;

typedef struct {
    uint64_t begin_us; /* SIM_NEVER: not due */
    uint64_t end_us;
    uint32_t times; /* how often it has begun */
    bool in_force;
} bench_fault_state_t;

typedef struct {
    bench_fault_state_t states[SIM_MAX_FAULTS];
} bench_fault_script_t;

/* Faults that begin at a time are set; the others wait for their position. */
void bench_fault_script_init(bench_world_t *world);

/* The procedure has come to another state, position or attempt. */
void bench_fault_script_look(bench_world_t *world, const tumble_progress_t *progress);

/* Somebody mends what is broken: all faults in force that would last for good are over. */
void bench_fault_script_mend(bench_world_t *world);

/* A fault begins or ends. */
void bench_fault_script_on_alarm(bench_world_t *world);

#endif
