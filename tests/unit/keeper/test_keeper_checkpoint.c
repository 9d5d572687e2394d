/* The checkpoint of a run on a memory that fails, or holds what is of no use. */
#include "keeper_bench.h"

/* One position measured over and over fills the log: it is begun anew, and nothing is lost. */
static void test_a_full_checkpoint_is_written_anew(void)
{
    start_to_average(3);
    settle_memory();
    keeper.checkpoint.next = TUMBLE_CHECKPOINT_CELLS;
    run_to_average(5);
    settle_and_power_cycle();
    assert_resumable(5);
}

/* The memory fails while the run goes on: the run does not mind. */
static void test_a_memory_that_fails_costs_the_checkpoint_alone(void)
{
    start_to_average(6);
    nv_refuse(&memory, NV_NEVER);
    run_to_average(9);
    nv_arm(&memory, nv_no_fault);
    end_and_settle();
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(3, keeper.counters.failures);
}

/* One that could not be begun is tried again with every mean that is finished, and then has all of them. */
static void test_a_checkpoint_that_could_not_be_begun_is_tried_again(void)
{
    nv_refuse(&memory, NV_NEVER);
    start_to_average(3);
    TEST_ASSERT_EQUAL_UINT32(4U * TUMBLE_SETS_TRIES, keeper.counters.failures);
    TEST_ASSERT_EQUAL_UINT32(4U * TUMBLE_SETS_TRIES, memory.operations);
    nv_arm(&memory, nv_no_fault);
    run_to_average(6);
    settle_memory();
    TEST_ASSERT_EQUAL_UINT32(4U * TUMBLE_SETS_TRIES, keeper.counters.failures);
    TEST_ASSERT_EQUAL_UINT32(6, keeper.counters.checkpoints);
    assert_goes_on(6);
}

/* The same for one that was begun, and then could not even be read. */
static void test_a_checkpoint_that_was_lost_is_begun_again(void)
{
    start_to_average(3);
    memory.read_fails_at = 0;
    run_to_average(6);
    TEST_ASSERT_EQUAL_UINT32(1U + (2U * TUMBLE_SETS_TRIES), keeper.counters.failures);
    memory.read_fails_at = NV_NEVER;
    run_to_average(7);
    settle_and_power_cycle();
    assert_resumable(7);
}

/* Where the one of the run before could not be erased, nothing of this run is added to it. */
static void test_the_means_of_two_runs_are_not_mixed(void)
{
    start_and_cut(6);
    nv_refuse(&memory, NV_NEVER);
    start_to_average(2);
    nv_arm(&memory, nv_no_fault);
    run_to_average(3);
    settle_and_power_cycle();
    assert_resumable(3);
}

static void write_on_checkpoint(void)
{
    while (tumble_checkpoint_busy(&keeper.checkpoint)) {
        (void)tumble_checkpoint_step(&keeper.checkpoint);
    }
}

/* What is kept of the first positions, with gravity the other way round. */
static void turn_means_round(uint8_t count)
{
    tumble_average_t means[POSITIONS];
    for (uint8_t p = 0; p < count; p++) {
        ASSERT_STATUS(TUMBLE_OK, tumble_checkpoint_read(&keeper.checkpoint, p, &means[p]));
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            means[p].sum_counts[i] = -means[p].sum_counts[i];
        }
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_checkpoint_begin(&keeper.checkpoint, keeper.checkpoint.fingerprint));
    write_on_checkpoint();
    for (uint8_t p = 0; p < count; p++) {
        ASSERT_STATUS(TUMBLE_OK, tumble_checkpoint_append(&keeper.checkpoint, p, &means[p]));
        write_on_checkpoint();
    }
}

static void assert_not_gone_on_with(uint32_t times)
{
    obey_for(0.2, TUMBLE_COMMAND_RESUME);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, run_state());
    TEST_ASSERT_EQUAL_UINT32(times, keeper.counters.not_resumed);
    assert_resumable(0);
}

/* Means that fail their check when they are put back are no run that waits for somebody. Who asks again is heard. */
static void test_what_cannot_be_put_back_is_no_run_to_go_on_with(void)
{
    start_and_cut(6);
    turn_means_round(6);
    assert_resumable_after_power(6);
    assert_not_gone_on_with(1);
    keeper.stale = true; /* as after any job of the store */
    settle_memory();
    assert_resumable(0);
    assert_not_gone_on_with(2);
    keeper.settings.flags |= TUMBLE_SETS_STARTS;
    assert_starts_after((double)TUMBLE_SETS_MIN_PAUSE_S + 1.0, 1);
}

static const around_t around_each = {keeper_power_on, NULL};
