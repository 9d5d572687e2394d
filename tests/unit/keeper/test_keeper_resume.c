/* Loss of power in a run: the checkpoint, going on from it, and what must not be gone on with. */
#include "keeper_bench.h"

#define CHECKPOINT_AT (MEMORY_SECTOR * TUMBLE_REGION_CHECKPOINT)

/* The scripted block's pattern sums to nothing over a position, so the same samples come whenever they are taken. */
static void test_cut_at_every_position_the_result_is_the_same(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    const tumble_set_t whole = set_of(TUMBLE_SET_ACTIVE);
    for (uint8_t index = 1; index < POSITIONS; index++) {
        keeper_power_on();
        start_and_cut(index);
        assert_resumable(index);
        TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, run_state());
        resume_to_end();
        const tumble_set_t set = set_of(TUMBLE_SET_ACTIVE);
        TEST_ASSERT_EQUAL_MEMORY(&whole.coefficients, &set.coefficients, sizeof set.coefficients);
        TEST_ASSERT_EQUAL_MEMORY(&whole.uncertainty, &set.uncertainty, sizeof set.uncertainty);
        ASSERT_SAME_DOUBLE(whole.max_abs_fit_g, set.max_abs_fit_g);
        ASSERT_SAME_DOUBLE(whole.closure_v, set.closure_v);
        TEST_ASSERT_EQUAL_HEX16(whole.flags | TUMBLE_SET_RESUMED, set.flags);
        TEST_ASSERT_EQUAL_UINT32(whole.samples, set.samples);
        TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.resumed);
        TEST_ASSERT_EQUAL_UINT32(POSITIONS - index, bench_counters(&bench).procedure.positions);
        TEST_ASSERT_EQUAL_UINT32((POSITIONS - index) * BENCH_SAMPLES, bench_counters(&bench).procedure.averaged);
    }
}

static void test_a_busy_memory_is_waited_for(void)
{
    for (uint32_t every = 2; every < 5U; every++) {
        keeper_power_on();
        start_and_cut(7);
        memory.busy_every = every;
        resume_to_commit();
        TEST_ASSERT_EQUAL_UINT32(11, bench_counters(&bench).procedure.positions);
    }
}

static void test_cut_twice(void)
{
    start_and_cut(4);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_RESUME));
    run_to_average(13);
    settle_memory();
    assert_goes_on(13);
}

/* Power fails when all is measured and nothing is stored: the result comes without the table. */
static void test_cut_before_the_result_is_stored(void)
{
    start_to_average(17);
    while (run_state() != TUMBLE_STATE_DONE) {
        bench_event(&bench);
    }
    for (int i = 0; (i < 100) && ((keeper.saved >> 17U) == 0U); i++) {
        bench_event(&bench);
    }
    /* The step that saw DONE took the result; the last mean is on its way into the checkpoint. */
    while (tumble_checkpoint_busy(&keeper.checkpoint)) {
        (void)tumble_checkpoint_step(&keeper.checkpoint);
    }
    keeper_power_cycle();
    const uint8_t resumable = state_of_keeper().resumable;
    TEST_ASSERT_GREATER_OR_EQUAL_UINT8(17, resumable);
    resume_to_commit();
}

/* The run is in the store and its checkpoint is still there: it is no run to go on with. */
static void test_a_committed_run_is_not_gone_on_with(void)
{
    static uint8_t kept[2U * MEMORY_SECTOR];
    start_to_average(17);
    settle_memory();
    memcpy(kept, &memory.bytes[CHECKPOINT_AT], sizeof kept);
    end_and_settle();
    memcpy(&memory.bytes[CHECKPOINT_AT], kept, sizeof kept);
    assert_resumable_after_power(0);
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME));
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.not_resumed);
}

/* The same with a result that was held: the run can be gone on with, but its result is the proposal already. */
static void test_a_held_run_gives_no_second_proposal(void)
{
    static uint8_t kept[2U * MEMORY_SECTOR];
    settings.limits.flags = 0;
    keeper_power_cycle();
    start_to_average(17);
    settle_memory();
    memcpy(kept, &memory.bytes[CHECKPOINT_AT], sizeof kept);
    end_and_settle();
    assert_verdict(TUMBLE_VERDICT_HELD);
    memcpy(&memory.bytes[CHECKPOINT_AT], kept, sizeof kept);
    assert_resumable_after_power(17);
    resume_to_end();
    assert_verdict(TUMBLE_VERDICT_REPEATED);
}

/* Who wants to end waits for this, and then nothing is left to do: neither an entry of the history nor a checkpoint. */
static void test_it_is_busy_until_all_is_stored(void)
{
    static const uint8_t flags[] = {TUMBLE_COMMIT_BY_ITSELF, TUMBLE_COMMIT_BY_ITSELF | TUMBLE_COMMIT_FIRST};
    for (size_t i = 0; i < COUNT_OF(flags); i++) {
        settings.limits.flags = flags[i];
        keeper_power_cycle();
        drift(1e-5);
        run_to_done();
        while (state_of_keeper().busy || (state_of_keeper().verdict == TUMBLE_VERDICT_WORKING)) {
            bench_event(&bench);
        }
        const bool first = (flags[i] & TUMBLE_COMMIT_FIRST) != 0U;
        TEST_ASSERT_EQUAL_UINT8(first ? TUMBLE_VERDICT_COMMITTED : TUMBLE_VERDICT_HELD, state_of_keeper().verdict);
        assert_resumable_after_power(0);
        TEST_ASSERT_FALSE(keeper.checkpoint.kept);
        TEST_ASSERT_EQUAL_UINT8(first ? 1U : 0U, tumble_history_count(&keeper.history));
        TEST_ASSERT_EQUAL_UINT32(first ? 1U : 0U, keeper.history.newest);
    }
}

static void test_start_abort_and_done_leave_nothing_to_go_on_with(void)
{
    start_and_cut(6);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    settle_memory(); /* the old checkpoint goes as the run begins, not with its first position */
    assert_resumable_after_power(0);
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME));

    start_to_average(6);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT));
    settle_and_power_cycle();
    assert_resumable(0);

    (void)run_and_judge();
    assert_resumable_after_power(0);
}

/* A run that is begun while the result of the one before is still being stored keeps its own checkpoint. */
static void test_a_run_begun_at_once_keeps_its_checkpoint(void)
{
    run_to_done();
    assert_verdict(TUMBLE_VERDICT_WORKING);
    while (!tumble_store_busy(&keeper.store)) {
        bench_event(&bench); /* before that a START is refused */
    }
    assert_verdict(TUMBLE_VERDICT_WORKING);
    start_to_average(5);
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
    settle_and_power_cycle();
    assert_resumable(5);
}

/* FAULT keeps it: what was measured before a fault and then a loss of power is not lost. */
static void test_a_fault_keeps_it(void)
{
    start_to_average(6);
    bench.block.dead = true;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_run(&bench, TUMBLE_STATE_DONE, 60.0));
    settle_and_power_cycle();
    assert_resumable(6);
}

/* What must be as it was. */

static void assert_not_resumable(const char *what)
{
    keeper_power_cycle();
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(0, state_of_keeper().resumable, what);
    TEST_ASSERT_EQUAL_MESSAGE(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME), what);
    TEST_ASSERT_EQUAL_MESSAGE(TUMBLE_STATE_IDLE, run_state(), what);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(1, keeper.counters.not_resumed, what);
}

static void test_block_stand_schedule_and_configuration_must_be_the_same(void)
{
    static tumble_position_t positions[18];
    tumble_schedule_t another = tumble_schedule_paper;
    keeper_config.sets.serial = "123456789012345678901234"; /* as long as it may be */
    keeper_power_cycle();
    start_and_cut(6);

    keeper_config.sets.serial = "123456789012345678901235";
    assert_not_resumable("serial");
    keeper_config.sets.serial = "123456789012345678901234";
    declared_stand.angle_rad = 5e-5;
    assert_not_resumable("stand");
    declared_stand.angle_rad = 4e-5;
    tumble_drive_profile_t profile = scripted_drive_profile;
    profile.counts_per_revolution += 1.0;
    bench.config.stand_profile = &profile;
    assert_not_resumable("drive");
    bench.config.stand_profile = &scripted_drive_profile;
    memcpy(positions, tumble_schedule_paper.positions, sizeof positions);
    positions[17].use = TUMBLE_USE_CHECK;
    another.positions = positions;
    bench.procedure.schedule = &another;
    assert_not_resumable("schedule");
    bench.procedure.schedule = &tumble_schedule_paper;
    bench.procedure.samples++;
    assert_not_resumable("samples");
    bench.procedure.samples--;
    bench.procedure.estimate = TUMBLE_ESTIMATE_AVERAGED;
    assert_not_resumable("estimate");
    bench.procedure.estimate = TUMBLE_ESTIMATE_REFINED;
    bench.averaging.max_lost++;
    assert_not_resumable("averaging");
    bench.averaging.max_lost--;

    assert_goes_on(6);
}

/* A configuration that is written over CAN between power-on and the command counts, too. */
static void test_a_configuration_written_meanwhile(void)
{
    start_and_cut(6);
    bench.navcomp.procedure_config.samples = BENCH_SAMPLES + 3U;
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME));
    bench.navcomp.procedure_config.samples = BENCH_SAMPLES;
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_RESUME));
    bench.navcomp.procedure_config.samples = BENCH_SAMPLES + 3U; /* while the means are being put back */
    assert_state_after(0.2, TUMBLE_STATE_IDLE);
    TEST_ASSERT_EQUAL_UINT32(0, keeper.counters.resumed);
}

static void test_start_overtakes_a_resumption(void)
{
    start_and_cut(6);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_RESUME));
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_RESUME)); /* once */
    bench_event(&bench);
    run_to_done();
    TEST_ASSERT_EQUAL_UINT32(POSITIONS, bench_counters(&bench).procedure.positions);
    TEST_ASSERT_EQUAL_UINT32(0, keeper.counters.resumed);
}

/* A position that is dropped on purpose does not come back after a loss of power. */
static void test_a_mean_that_was_dropped_stays_dropped(void)
{
    start_to_average(6);
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_POSITION, 2));
    settle_and_power_cycle();
    assert_resumable(5);
    TEST_ASSERT_FALSE(tumble_checkpoint_has(&keeper.checkpoint, 2));
}

static void test_a_mounting_that_was_dropped_stays_dropped(void)
{
    start_to_average(12);
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_MOUNTING, 1));
    settle_and_power_cycle();
    assert_resumable(3);
}

/* A damaged entry is a position that is measured again. */
static void test_a_damaged_entry_is_measured_again(void)
{
    start_and_cut(6);
    memory.bytes[CHECKPOINT_AT + (3U * TUMBLE_CHECKPOINT_BYTES) + 20U] ^= 0x10U;
    assert_goes_on(5);
}

/* An NMT reset of the application is as a loss of power. */
static void test_after_an_nmt_reset_the_run_can_be_gone_on_with(void)
{
    start_to_average(6);
    settle_memory();
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 0.0);
    assert_state_after(0.5, TUMBLE_STATE_IDLE);
    assert_resumable(6);
    resume_to_commit();
}

/* It is the same run: the set tells that it was interrupted, and the temperature of all of it. */
static void test_a_position_of_a_resumed_run_is_repeated(void)
{
    start_and_cut(6);
    resume_to_end();
    bench.block.temperature_half_c = 62;
    drift(1e-5);
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_POSITION, POSITIONS - 1U));
    end_and_settle();
    const tumble_set_t set = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_UINT32(2, set.sequence);
    TEST_ASSERT_BITS_HIGH(TUMBLE_SET_RESUMED, set.flags);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 25.0, set.temperature_c);
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_BITS_LOW(TUMBLE_SET_RESUMED, set_of(TUMBLE_SET_ACTIVE).flags);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 31.0, set_of(TUMBLE_SET_ACTIVE).temperature_c);
}

static const around_t around_each = {keeper_power_on, NULL};
