/* The procedure with the stand-optimal estimator: it solves with the record, and never without a right one. */
#include "gain_bench.h"
#include "procedure_bench.h"
#include "tumble/core.h"

static gain_bytes_t record;
static tumble_optimal_t work;
static tumble_optimal_source_t source;
static tumble_lent_t lent;

/* Gains of least squares, column by column from its answer to a unit mean; a perfect stand. */
static void tabulate_least_squares(void)
{
    static tumble_means_t unit;
    empty_gains(&tumble_schedule_paper, 2, &record);
    for (unsigned column = 0; column < 54U; column++) {
        tumble_coefficients_t answer;
        double rows[TUMBLE_COEFFICIENTS];
        memset(&unit, 0, sizeof unit);
        memset(unit.measured, true, sizeof unit.measured);
        unit.u_v[column / 3U][column % 3U] = 1.0;
        ASSERT_STATUS(TUMBLE_OK, tumble_estimate_least_squares(&tumble_schedule_paper, &unit, &answer, NULL));
        memcpy(rows, answer.k_v_per_g, sizeof answer.k_v_per_g);
        memcpy(rows + 9, answer.u0_v, sizeof answer.u0_v);
        for (unsigned row = 0; row < TUMBLE_COEFFICIENTS; row++) {
            set_number(&record, gain_index(&tumble_schedule_paper, row, column), rows[row]);
        }
    }
    seal(&record);
}

static void set_up(void)
{
    tabulate_least_squares();
    source = (tumble_optimal_source_t){record.bytes, record.size, &work};
    lent = (tumble_lent_t){.estimator = TUMBLE_ESTIMATE_OPTIMAL,
                           .check = tumble_optimal_check,
                           .estimate = tumble_optimal_estimate,
                           .source = &source};
    bench_init(&bench);
    bench.config.estimate = TUMBLE_ESTIMATE_OPTIMAL;
    bench.config.lent = &lent;
}

static tumble_coefficients_t coefficients_of_a_run(void)
{
    tumble_result_t result;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
    bench_start_to_done(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_result(&bench.procedure, &result));
    TEST_ASSERT_TRUE(result.pass);
    return *result.coefficients;
}

static void test_a_run_is_solved_with_the_gains_of_the_record(void)
{
    const tumble_coefficients_t found = coefficients_of_a_run();
    bench_init(&bench);
    bench.config.estimate = TUMBLE_ESTIMATE_LEAST_SQUARES;
    const tumble_coefficients_t expected = coefficients_of_a_run();
    assert_coefficients(&expected, &found, 1e-14);
}

static void assert_never_begins(tumble_status_t expected)
{
    tumble_reason_t reason = TUMBLE_REASON_NONE;
    ASSERT_STATUS(expected, tumble_procedure_validate(&bench.config, &reason));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_REASON_CONFIGURATION", tumble_reason_name(reason));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_CONFIGURATION);
    TEST_ASSERT_EQUAL_UINT(0, bench.stand.moves);
    tumble_result_t result;
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_result(&bench.procedure, &result));
}

#define NEVER_BEGINS(status, because)                                                                                  \
    do {                                                                                                               \
        ROW(#because);                                                                                                 \
        set_up();                                                                                                      \
        because;                                                                                                       \
        assert_never_begins(status);                                                                                   \
    } while (0)

/* Without the estimator; with a damaged record, with erased flash, with a record of another schedule. */
static void test_a_run_does_not_begin_without_a_right_record(void)
{
    tumble_schedule_t shorter = tumble_schedule_paper;
    shorter.position_count = 17;
    NEVER_BEGINS(TUMBLE_E_ARGUMENT, bench.config.lent = NULL);
    NEVER_BEGINS(TUMBLE_E_CRC, record.bytes[500] ^= 4U);
    NEVER_BEGINS(TUMBLE_E_GAIN_RECORD, memset(record.bytes, 0xFF, sizeof record.bytes));
    NEVER_BEGINS(TUMBLE_E_GAIN_TABLE, empty_gains(&shorter, 2, &record));
}

static void test_a_schedule_that_is_not_valid_is_told_first(void)
{
    tumble_reason_t reason = TUMBLE_REASON_NONE;
    tumble_schedule_t none = tumble_schedule_paper;
    none.position_count = 0;
    bench.config.schedule = &none;
    ASSERT_STATUS(TUMBLE_E_SCHEDULE_SIZE, tumble_procedure_validate(&bench.config, &reason));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_REASON_SCHEDULE", tumble_reason_name(reason));
}

/* Damaged while the table turned: what was measured is kept, and no result comes of it. */
static void test_a_record_that_is_damaged_on_the_way_gives_no_result(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench_run_to_position(&bench, 12, TUMBLE_STATE_AVERAGE);
    record.bytes[2000] ^= 1U;
    bench_run(&bench);
    TEST_ASSERT_EQUAL_STRING("TUMBLE_STATE_FAULT", tumble_state_name(bench_state_of(&bench)));
    ASSERT_STATUS(TUMBLE_E_CRC, bench_progress(&bench).status);
    tumble_result_t result;
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_result(&bench.procedure, &result));
}
