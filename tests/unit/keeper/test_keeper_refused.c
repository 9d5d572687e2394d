/* What a memory refuses that fails for a while is tried again, and not for ever. */
#include "keeper_bench.h"

/* From now on so many changes fail. */
static void refuse(uint32_t times)
{
    nv_refuse(&memory, times);
}

static uint32_t refused(void)
{
    return (memory.fault.at == 0U) ? memory.operations : 0U;
}

static uint32_t failures(void)
{
    return keeper.counters.failures;
}

/* The checkpoint. */

static void run_to_rest(uint8_t index)
{
    run_to_average(index);
    settle_memory();
}

static void test_a_mean_that_is_refused_once_or_twice_is_kept(void)
{
    for (uint32_t times = 1; times < TUMBLE_SETS_TRIES; times++) {
        keeper_power_on();
        ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
        run_to_rest(5);
        refuse(times);
        run_to_rest(6);
        TEST_ASSERT_EQUAL_UINT32(times + 1U, refused()); /* the last one was taken */
        TEST_ASSERT_EQUAL_UINT32(times, failures());
        TEST_ASSERT_EQUAL_UINT32(6, keeper.counters.checkpoints);
        assert_resumable_after_power(6);
        resume_to_end();
        TEST_ASSERT_EQUAL_UINT32(12, bench_counters(&bench).procedure.positions);
        assert_verdict(TUMBLE_VERDICT_COMMITTED);
    }
}

/* After so many times it waits for the next mean; when that is taken, it is, too. */
static void test_a_mean_that_is_refused_too_often_waits_for_the_next(void)
{
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    run_to_rest(5);
    refuse(2U * TUMBLE_SETS_TRIES);
    run_to_rest(6);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_SETS_TRIES, refused());
    run_to_rest(7);
    TEST_ASSERT_EQUAL_UINT32(2U * TUMBLE_SETS_TRIES, refused());
    TEST_ASSERT_EQUAL_UINT32(5, keeper.counters.checkpoints);
    run_to_rest(8);
    TEST_ASSERT_EQUAL_UINT32(2U * TUMBLE_SETS_TRIES, failures());
    TEST_ASSERT_EQUAL_UINT32(8, keeper.counters.checkpoints);
    assert_resumable_after_power(8);
}

static void test_a_memory_that_refuses_for_ever_is_asked_so_often_a_mean(void)
{
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    run_to_rest(5);
    refuse(UINT32_MAX);
    run_to_rest(9);
    TEST_ASSERT_EQUAL_UINT32(4U * TUMBLE_SETS_TRIES, refused());
    TEST_ASSERT_EQUAL_UINT32(4U * TUMBLE_SETS_TRIES, failures());
    assert_resumable_after_power(5);
}

/* What was measured again while its first mean was refused is kept as it is now. */
static void test_a_mean_that_goes_while_it_is_tried_does_not_come_back(void)
{
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    run_to_rest(5);
    refuse(TUMBLE_SETS_TRIES);
    run_to_rest(6);
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_POSITION, 5));
    bench_pass(&bench, 0.5);
    settle_memory();
    assert_resumable_after_power(5);
}

static void test_a_run_that_is_given_up_leaves_none(void)
{
    for (uint32_t times = 1; times <= TUMBLE_SETS_TRIES; times++) {
        const bool taken = times < TUMBLE_SETS_TRIES;
        keeper_power_on();
        ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
        run_to_rest(4);
        refuse(times);
        decide(TUMBLE_COMMAND_ABORT);
        TEST_ASSERT_EQUAL_UINT32(times + (taken ? 1U : 0U), refused());
        TEST_ASSERT_EQUAL_UINT32(times, failures());
        assert_resumable_after_power(taken ? 0U : 4U);
    }
}

/* Nor does it leave the one before, which could not be replaced. */
static void test_a_run_that_is_given_up_leaves_none_of_another(void)
{
    start_and_cut(6);
    refuse(1);
    decide(TUMBLE_COMMAND_START);
    refuse(1);
    decide(TUMBLE_COMMAND_ABORT);
    TEST_ASSERT_EQUAL_UINT32(2, failures());
    assert_resumable_after_power(0);
}

/* Nor does one that has begun, however long its first position takes. */
static void test_a_run_that_begins_leaves_none_of_another(void)
{
    for (uint32_t times = 1; times < TUMBLE_SETS_TRIES; times++) {
        keeper_power_on();
        start_and_cut(6);
        refuse(times);
        decide(TUMBLE_COMMAND_START);
        TEST_ASSERT_EQUAL_UINT32(times, failures());
        assert_resumable_after_power(0);
    }
}

static bool blind;

/* The read behind the change that is refused fails as well. */
static tumble_status_t read_after_all(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    const bool fails = blind && (refused() == 1U);
    blind = blind && !fails;
    return fails ? TUMBLE_E_NV : nv_read(context, offset, bytes, size);
}

/* What cannot be read is not what is not there. */
static void test_a_run_that_is_given_up_leaves_none_unread(void)
{
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    run_to_rest(4);
    blind = true;
    memory.nv.read = read_after_all;
    refuse(1);
    decide(TUMBLE_COMMAND_ABORT);
    TEST_ASSERT_FALSE(blind);
    assert_resumable_after_power(0);
}

/* The mean that is refused as the run is given up is not wanted any more. */
static void test_a_run_that_is_given_up_is_not_added_to(void)
{
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    run_to_rest(4);
    while (!tumble_checkpoint_busy(&keeper.checkpoint)) {
        bench_event(&bench);
    }
    refuse(1);
    decide(TUMBLE_COMMAND_ABORT);
    TEST_ASSERT_EQUAL_UINT32(1, failures());
    assert_resumable_after_power(0);
}

/* The history. */

/* The result is in the store, and its entry is about to be written. */
static void run_to_history(void)
{
    run_to_done();
    for (int i = 0; (i < 2000) && !tumble_history_busy(&keeper.history); i++) {
        bench_event(&bench);
    }
    TEST_ASSERT_TRUE(tumble_history_busy(&keeper.history));
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
}

static void assert_history(uint8_t entries, uint32_t newest)
{
    TEST_ASSERT_EQUAL_UINT8(entries, tumble_history_count(&keeper.history));
    TEST_ASSERT_EQUAL_UINT32(newest, tumble_history_sequence(&keeper.history));
}

static void test_an_entry_of_the_history_that_is_refused_is_written(void)
{
    for (uint32_t times = 1; times < TUMBLE_SETS_TRIES; times++) {
        keeper_power_on();
        run_to_history();
        refuse(times);
        settle_memory();
        TEST_ASSERT_EQUAL_UINT32(times, failures());
        assert_verdict(TUMBLE_VERDICT_COMMITTED);
        TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
        assert_history(1, 1);
        keeper_power_cycle();
        assert_history(1, 1);
    }
}

/* After so many times it waits for the store's next job, which need not be a commit. */
static void test_an_entry_that_is_refused_too_often_waits_for_the_next_job(void)
{
    run_to_history();
    refuse(TUMBLE_SETS_TRIES);
    settle_memory();
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_SETS_TRIES, failures());
    assert_history(0, 0);
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    assert_history(1, 1);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_SETS_TRIES, failures());
}

/* And every set that becomes active has as many tries. */
static void test_the_next_set_is_tried_as_often(void)
{
    run_to_history();
    refuse(TUMBLE_SETS_TRIES);
    settle_memory();
    drift(1e-5);
    run_to_history();
    refuse(TUMBLE_SETS_TRIES - 1U);
    settle_memory();
    TEST_ASSERT_EQUAL_UINT32((2U * TUMBLE_SETS_TRIES) - 1U, failures());
    assert_history(1, 2);
}

/* A history that could not be read looks what it holds before it takes more. */
static void test_an_entry_is_written_once_the_history_can_be_read(void)
{
    memory.read_fails_at = 0;
    keeper_power_cycle();
    memory.read_fails_at = NV_NEVER;
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    assert_history(1, 1);
}

/* Reads that fail every so many times, for ever. */

static uint32_t reads;
static uint32_t fails_every;

static tumble_status_t read_sometimes(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    reads++;
    return ((reads % fails_every) == 0U) ? TUMBLE_E_NV : nv_read(context, offset, bytes, size);
}

/* The memory comes to rest (settle_memory), whatever becomes of the result, and nothing that was active is lost. */
static void test_it_comes_to_rest_where_every_so_many_reads_fail(void)
{
    for (fails_every = 2; fails_every < 40U; fails_every++) {
        keeper_power_on();
        TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
        reads = 0;
        memory.nv.read = read_sometimes;
        for (uint32_t run = 0; run < 3U; run++) {
            const uint32_t before = keeper.sequence;
            drift(1e-5);
            const tumble_verdict_t verdict = run_and_judge();
            const bool committed = (verdict == TUMBLE_VERDICT_COMMITTED);
            TEST_ASSERT_TRUE(committed || (verdict == TUMBLE_VERDICT_FAILED));
            TEST_ASSERT_GREATER_OR_EQUAL_UINT32(before + (committed ? 1U : 0U), keeper.sequence);
            TEST_ASSERT_LESS_OR_EQUAL_UINT32(before + 1U, keeper.sequence); /* store.h, _step */
        }
    }
}

static const around_t around_each = {keeper_power_on, NULL};
