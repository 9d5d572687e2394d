/* positioner_bench.h - a positioner, and the played controller at the other end of its link. */
#ifndef TUMBLE_TESTS_UNIT_POSITIONER_BENCH_H
#define TUMBLE_TESTS_UNIT_POSITIONER_BENCH_H

#include "played_positioner.h"
#include "support.h"

typedef struct {
    played_positioner_t controller;
    tumble_positioner_profile_t profile;
    tumble_positioner_t axis;
    tumble_stand_t stand;
} positioner_bench_t;

extern positioner_bench_t at; /* what the cases work on */

/* With a cable from -30 to 400 degrees. */
tumble_status_t positioner_init(const tumble_positioner_profile_t *profile);

/* Before and after each case: power on; the controller has seen nothing that it must not see. */
void positioner_begin(void);
void positioner_end(void);

/* Milliseconds as a navcomp lets them pass: a step when its time has come. */
void positioner_run_ms(unsigned ms);

/* Until the stand is in this state; fails after so many milliseconds. */
void positioner_run_to(tumble_stand_state_t state, unsigned most_ms);

void positioner_assert_fault(tumble_stand_fault_t fault);
void positioner_go_home(void);

/* Homed, and on its way there since a tenth of a second. */
void positioner_start_move(double angle_deg);

/* Clear the fault, which leads to this state. */
void positioner_clear(tumble_stand_state_t state);

#endif
