/* procedure_faults.h - ways to break a run of the procedure, and what must come of each. */
#ifndef TUMBLE_TESTS_UNIT_PROCEDURE_FAULTS_H
#define TUMBLE_TESTS_UNIT_PROCEDURE_FAULTS_H

#include "procedure_bench.h"

/* `before` acts before the start, `during` when the position at `index` is in `state`. */
typedef struct {
    tumble_reason_t reason;
    tumble_state_t failed_in;
    void (*before)(bench_t *bench);
    void (*during)(bench_t *bench);
    tumble_state_t state;
    uint8_t index;
    bool timeout;
} fault_case_t;

extern const fault_case_t fault_cases[];
extern const size_t fault_case_count;

/* Two of the acts. */
void schedule_without_a_position(bench_t *b);
void schedule_of_one_mounting(bench_t *b);

#endif
