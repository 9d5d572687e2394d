/* fault_script.h - begins and ends the faults of a scenario at their moments. */
#ifndef TUMBLE_WORLD_FAULT_SCRIPT_H
#define TUMBLE_WORLD_FAULT_SCRIPT_H

#include "world/scene.h"

/* Faults that begin at a time are set; the others wait for their position. */
void bench_fault_script_init(bench_world_t *world);

/* The procedure has come to another state, position or attempt. */
void bench_fault_script_look(bench_world_t *world, const tumble_progress_t *progress);

/* Somebody mends what is broken: all faults in force that would last for good are over. */
void bench_fault_script_mend(bench_world_t *world);

/* A fault begins or ends. */
void bench_fault_script_on_alarm(bench_world_t *world);

#endif
