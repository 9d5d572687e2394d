/* An NMT reset of the node in the middle of what the keeper is about, and what is refused until that is over. */
#include "keeper_sdo.h"

static void reset_application(void)
{
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 0.0);
    bench_event(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, run_state());
}

/* The run had begun, and what is left of the one before it was about to go: it goes. */
static void test_a_run_reset_as_it_begins_leaves_none_to_go_on_with(void)
{
    start_and_cut(6);
    assert_resumable(6);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    reset_application();
    settle_memory();
    assert_resumable(0);
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME));
    assert_resumable_after_power(0);
}

/* Nor does it keep the next from starting by itself. */
static void test_it_starts_by_itself_after_a_reset(void)
{
    settings.flags = TUMBLE_SETS_STARTS;
    start_and_cut(6);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    reset_application();
    assert_starts_after((double)settings.pause_s - 1.0, 0);
    assert_starts_after(3.0, 1);
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_IDLE, run_state());
}

/* Until that is erased nobody can go on with it either. */
static void test_what_is_about_to_go_cannot_be_resumed(void)
{
    start_and_cut(6);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    reset_application();
    memory.busy_every = 1;
    for (int i = 0; i < 100; i++) {
        assert_resumable(0);
        ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME));
        bench_event(&bench);
    }
    memory.busy_every = 0;
    while (state_of_keeper().busy) {
        assert_resumable(0);
        ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME));
        bench_event(&bench);
    }
}

/* A run under way is one that can be gone on with, as after a loss of power. */
static void test_a_run_reset_later_can_be_gone_on_with(void)
{
    start_to_average(6);
    settle_memory();
    reset_application();
    bench_pass(&bench, 1.0);
    assert_resumable(6);
    resume_to_commit();
}

/* What was being put back is forgotten with the rest, and can be asked for again. */
static void test_a_reset_ends_going_on(void)
{
    start_and_cut(6);
    bench_pass(&bench, 1.0);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_RESUME));
    bench_event(&bench);
    reset_application();
    assert_state_after(1.0, TUMBLE_STATE_IDLE);
    TEST_ASSERT_EQUAL_UINT32(0, keeper.counters.resumed);
    assert_resumable(6);
    resume_to_end();
    TEST_ASSERT_EQUAL_UINT32(12, bench_counters(&bench).procedure.positions);
}

/* Nor is it lost that there was one, while the node went by other numbers. */
static void test_a_reset_brings_back_what_fits_the_run(void)
{
    settings.flags = TUMBLE_SETS_STARTS;
    start_and_cut(6);
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2050, 1, 34));
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME));
    assert_resumable(0);
    reset_application();
    settle_memory();
    assert_resumable(6);
    bench_pass(&bench, 300.0);
    TEST_ASSERT_EQUAL_UINT32(0, keeper.counters.self_started); /* it waits for who looks */
    resume_to_end();
}

/* A run goes by what was saved, or not at all. */
static void test_no_start_before_what_was_saved_is_in_force(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2050, 1, 34));
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1010, SAVE));
    reset_application();
    TEST_ASSERT_EQUAL_UINT32(BENCH_SAMPLES, bench.navcomp.procedure_config.samples);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, command(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, run_state());
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.refused);
    settle_memory();
    TEST_ASSERT_EQUAL_UINT32(34, bench.navcomp.procedure_config.samples);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_IDLE, run_state());
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.refused);
    /* While a run is on it is saved, or read, no more. */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_and_wait(0x1010, SAVE));
}

/* The same when the memory was busy at power-on. */
static void test_no_start_while_a_busy_memory_is_waited_for(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2050, 1, 34));
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1010, SAVE));
    memory.busy_every = 1;
    keeper_power_cycle_for(5.0);
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_START));
    memory.busy_every = 0;
    settle_memory();
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL_UINT32(34, bench.navcomp.procedure_config.samples);
}

/* A memory that cannot be read holds nothing to wait for, nor does one without room. */
static void test_a_start_where_nothing_can_be_read(void)
{
    memory.read_fails_at = 0;
    reset_application();
    bench_pass(&bench, 1.0);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT));
    memory.read_fails_at = NV_NEVER;
    memory.nv.size_bytes = 8U * MEMORY_SECTOR;
    keeper_power_cycle();
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
}

/* What is being saved is in force already. */
static void test_a_start_while_it_is_being_saved(void)
{
    uint8_t request[8] = {0x23, 0x10, 0x10, 1};
    tumble_put_u32(&request[4], SAVE);
    unlock();
    const tumble_can_frame_t frame = fake_frame(0x601, 8, request);
    fake_port_give(&bench.fake, &frame);
    bench_event(&bench);
    TEST_ASSERT_TRUE(state_of_keeper().busy);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
}

static const around_t around_each = {keeper_sdo_power_on, NULL};
