/* A fault of the stand around commands: how often it is cleared, and what it says of a stop. */
#include "procedure_bench.h"

/* Broken on the way to a position, and told to go on. */
static void break_and_resume(void)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_MOVE);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_STALL, 0);
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_STALL);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
}

/* As one that is still enforcing a stop. */
static void test_a_stand_that_will_not_clear_yet_is_asked_again(void)
{
    bench.stand.refuses_clears = 3;
    break_and_resume();
    bench_run_to_position(&bench, 4, TUMBLE_STATE_MOVE);
    TEST_ASSERT_EQUAL_UINT(4, bench.stand.clears);
}

static void test_a_new_fault_is_not_cleared_without_a_command(void)
{
    bench.config.preflight_timeout_ms = 1000;
    bench_run_to_position(&bench, 3, TUMBLE_STATE_MOVE);
    bench.block.silent = true; /* it stays in PREFLIGHT */
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_STALL, 0);
    bench_run(&bench);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&bench.procedure));
    bench_ticks(&bench, 10);
    TEST_ASSERT_EQUAL_UINT(1, bench.stand.clears);
    bench_break_stand(&bench, TUMBLE_STAND_FAULT_POWER, 0);
    bench_run(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_state_of(&bench));
    TEST_ASSERT_EQUAL_UINT(1, bench.stand.clears);
}

/* That the table does not stop matters more than why it was told to; of another fault this is not known. */
static void abort_and_break(tumble_stand_fault_t fault, tumble_reason_t reason)
{
    bench_run_to_position(&bench, 3, TUMBLE_STATE_MOVE);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_abort(&bench.procedure));
    bench_break_stand(&bench, fault, 0);
    bench_ticks(&bench, 2);
    TEST_ASSERT_EQUAL_STRING(tumble_reason_name(reason), tumble_reason_name(bench_reason_of(&bench)));
}

static void test_an_abort_tells_that_the_table_does_not_stop(void)
{
    abort_and_break(TUMBLE_STAND_FAULT_STOP, TUMBLE_REASON_STOP_NOT_CONFIRMED);
}

static void test_an_abort_stays_one_at_another_fault(void)
{
    abort_and_break(TUMBLE_STAND_FAULT_STALL, TUMBLE_REASON_COMMAND);
}

static const around_t around_each = {begin_run, NULL};
