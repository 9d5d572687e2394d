/* procedure_bench.h - a procedure on a fake stand with a synthetic block, in virtual time.
 *
 * The stand turns in 100 ms and records what it is told. The block is mounted as the fields say, obeys U = U0 + K a
 * on the ideal geometry at the table's true angle, and gives a sample every 10 ms. Faults are fields: set one, run,
 * look.
 */
#ifndef TUMBLE_TESTS_UNIT_PROCEDURE_BENCH_H
#define TUMBLE_TESTS_UNIT_PROCEDURE_BENCH_H

#include "procedure/procedure.h"
#include "support.h"

#define SAMPLE_US 10000U
#define MOVE_US 100000U
#define V_PER_COUNT 1e-6
#define MAX_MOVES 256

typedef struct {
    tumble_stand_state_t state;
    tumble_stand_fault_t fault;
    tumble_stand_report_t report; /* fault_code alone */
    double angle_deg;
    double error_deg; /* added to what is reported */
    double target_deg;
    uint64_t arrives_us;
    double moves_deg[MAX_MOVES];
    unsigned moves;
    unsigned homes;
    unsigned stops;
    unsigned clears;
    bool never_arrives;
    bool refuses_moves;
    bool refuses_homing;
    unsigned refuses_clears; /* so many more */
    bool stays_faulty;       /* clear_fault does not help */
    bool loses_home;         /* clear_fault leads to READY */
} fake_stand_t;

typedef struct {
    double k_v_per_g[3][3];
    double u0_v[3];
    int32_t noise_counts; /* uniform, plus or minus */
    uint8_t channel[3];   /* which one comes out where */
    double sign[3];
    const tumble_mounting_t *truth; /* how it really sits, by mounting; null: as the schedule has it */
    double slip_deg;                /* of the block against the table's report */
    double drift_v;                 /* added to every output */
    int32_t add_counts;             /* to channel 0, every other sample */
    bool dead[3];
    bool silent;
    bool frozen_time;
    bool frozen_counter;
    uint8_t status;
    int8_t temperature_half_c;
    int8_t warming_half_c; /* added every sample */
    uint16_t lose_every;   /* 0: never */
    uint16_t corrupt_every;
    uint16_t counter;
    uint16_t timestamp_ms;
    dice_t dice;
} fake_block_t;

typedef struct {
    tumble_procedure_t procedure;
    tumble_procedure_config_t config;
    tumble_averaging_config_t averaging;
    tumble_stand_t table;
    fake_stand_t stand;
    fake_block_t block;
    uint64_t now_us;
    uint64_t step_us; /* a step every so many us; 0: none but for the computing at the end */
    uint8_t mounted;  /* index of the mounting that is really on the table */
    bool operator_is_away;
    uint8_t operator_mounts; /* UINT8_MAX: what is asked for; else this one, whatever is asked for */
    unsigned confirmations;
    uint32_t highest_ordinal; /* of the last sample taken */
    uint8_t last_index;
    uint32_t visited; /* states seen after a step, one bit each */
} bench_t;

extern bench_t bench; /* the one under test; who compares runs has more */

void bench_break_stand(bench_t *b, tumble_stand_fault_t fault, uint16_t code);
tumble_block_sample_t bench_make_sample(bench_t *b);
tumble_progress_t bench_progress(const bench_t *b);
tumble_state_t bench_state_of(const bench_t *b);

/* 10 ms: the table turns, the procedure steps, the block samples, the operator works. */
void bench_tick(bench_t *b);
void bench_ticks(bench_t *b, unsigned count);
unsigned bench_ticks_in(bench_t *b, tumble_state_t state); /* until it leaves this state: so many */

tumble_reason_t bench_reason_of(const bench_t *b);
bool bench_has_ended(const bench_t *b);

/* Run until it has ended, or this state is reached; fails when neither happens in ten minutes of virtual time. */
void bench_run_to(bench_t *b, tumble_state_t state);

void bench_run(bench_t *b);

/* Run until the position at `index` is in this state. */
void bench_run_to_position(bench_t *b, uint8_t index, tumble_state_t state);

void bench_init(bench_t *b);
void bench_start(bench_t *b);
void bench_run_to_done(bench_t *b);
void bench_start_to_done(bench_t *b);
tumble_result_t bench_result(const bench_t *b);

/* With `bench`, before each case: ready; started. */
void begin(void);
void begin_run(void);

const tumble_procedure_counters_t *counters(void); /* of `bench` */

#define ASSERT_ENDED(bench, expected_state, expected_reason)                                                           \
    do {                                                                                                               \
        TEST_ASSERT_EQUAL_STRING(tumble_reason_name(expected_reason), tumble_reason_name(bench_reason_of(bench)));     \
        TEST_ASSERT_EQUAL_STRING(tumble_state_name(expected_state), tumble_state_name(bench_state_of(bench)));         \
    } while (0)

/* Run, and see how it ends. */
#define ASSERT_ENDS(bench, expected_state, expected_reason)                                                            \
    do {                                                                                                               \
        bench_run(bench);                                                                                              \
        ASSERT_ENDED(bench, expected_state, expected_reason);                                                          \
    } while (0)

#endif
