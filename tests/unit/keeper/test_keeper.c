/* The keeper: from a result to the active set or a proposal, and the commands about sets. */
#include "keeper_bench.h"

#include "core/bytes.h"

static void test_a_good_result_becomes_the_active_set(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, keeper.sequence);
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 1800000000));
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
    const tumble_set_t set = set_of(TUMBLE_SET_ACTIVE);
    tumble_result_t result;
    tumble_uncertainty_t u;
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_result(&bench.navcomp, &result));
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_uncertainty(&bench.navcomp, TUMBLE_ALL_COEFFICIENTS, &u));
    TEST_ASSERT_EQUAL_MEMORY(result.coefficients, &set.coefficients, sizeof set.coefficients);
    TEST_ASSERT_EQUAL_MEMORY(&u, &set.uncertainty, sizeof u);
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_SET_HAS_TEMPERATURE | TUMBLE_SET_HAS_GRAVITY | TUMBLE_SET_HAS_UNCERTAINTY |
                                TUMBLE_SET_HAS_CHECK | TUMBLE_SET_HAS_TEMPERATURE_RANGE,
                            set.flags); /* no noise: both mountings come back to where they began */
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ORIGIN_COMMITTED, set.origin);
    TEST_ASSERT_EQUAL_STRING("TB-0001", (const char *)set.block_serial);
    ASSERT_SAME_DOUBLE(25.0, set.temperature_c);
    ASSERT_SAME_DOUBLE(9.81, set.gravity_m_s2);
    ASSERT_SAME_DOUBLE(3e-4, set.limit_g);
    ASSERT_SAME_DOUBLE(result.check->max_abs_fit_g, set.max_abs_fit_g);
    TEST_ASSERT_EQUAL_UINT8(18, set.fit_positions);
    TEST_ASSERT_EQUAL_UINT32(18U * BENCH_SAMPLES, set.samples);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ESTIMATE_REFINED, set.estimator);
    TEST_ASSERT_EQUAL_UINT32(0, set.reasons);
    TEST_ASSERT_NOT_EQUAL(0, set.schedule_crc);
    TEST_ASSERT_NOT_EQUAL(0, set.stand_crc);
    const uint64_t elapsed_s = bench.fake.now_us / 1000000U;
    TEST_ASSERT_UINT64_WITHIN(2, 1800000000U + elapsed_s, set.date_utc_s);
    const tumble_sets_counters_t *counters = &keeper.counters;
    TEST_ASSERT_EQUAL_UINT32(1, counters->judged);
    TEST_ASSERT_EQUAL_UINT32(1, counters->committed);
    TEST_ASSERT_EQUAL_UINT32(18, counters->checkpoints);
    TEST_ASSERT_EQUAL_UINT32(0, counters->failures);
    TEST_ASSERT_EQUAL_UINT8(1, tumble_history_count(&keeper.history));
}

/* The last position of the first mounting repeats its first one. */
static void test_the_set_tells_how_far_a_mounting_did_not_close(void)
{
    start_to_average(7);
    drift(1e-5);
    end_and_settle();
    const tumble_set_t set = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_BITS_HIGH(TUMBLE_SET_HAS_CLOSURE, set.flags);
    TEST_ASSERT_DOUBLE_WITHIN(1e-10, 1e-5, set.closure_v);
}

static void test_it_is_still_there_after_power_fails(void)
{
    (void)run_and_judge();
    const tumble_set_t before = set_of(TUMBLE_SET_ACTIVE);
    keeper_power_cycle();
    const tumble_set_t after = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_MEMORY(&before, &after, sizeof after);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
    assert_resumable(0);
    assert_verdict(TUMBLE_VERDICT_NONE);
}

static void test_an_implausible_change_waits_for_an_operator(void)
{
    (void)run_and_judge();
    const tumble_set_t active = set_of(TUMBLE_SET_ACTIVE);
    drift(2e-3); /* 1e-3 g, ten times what a month may do */
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_and_judge());
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE));
    const tumble_set_t still = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_MEMORY(&active, &still, sizeof active);
    const tumble_set_t proposal = set_of(TUMBLE_SET_PROPOSAL);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE), proposal.reasons);
    TEST_ASSERT_TRUE(state_of_keeper().has_proposal);

    decide(TUMBLE_COMMAND_ACCEPT);
    assert_verdict(TUMBLE_VERDICT_ACCEPTED);
    TEST_ASSERT_EQUAL_UINT32(2, keeper.sequence);
    const tumble_set_t accepted = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_MEMORY(&proposal.coefficients, &accepted.coefficients, sizeof accepted.coefficients);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ORIGIN_ACCEPTED, accepted.origin);
    TEST_ASSERT_FALSE(state_of_keeper().has_proposal);
    TEST_ASSERT_EQUAL_UINT8(2, tumble_history_count(&keeper.history));
}

static void test_a_proposal_can_be_discarded(void)
{
    hold_one();
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_DISCARD));
    assert_verdict(TUMBLE_VERDICT_WORKING);
    settle_to(TUMBLE_VERDICT_DISCARDED);
    TEST_ASSERT_FALSE(state_of_keeper().has_proposal);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_ACCEPT));
}

static void test_rollback_brings_the_set_before_back(void)
{
    (void)run_and_judge();
    const tumble_set_t first = set_of(TUMBLE_SET_ACTIVE);
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_ROLLBACK)); /* to what? */
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    decide(TUMBLE_COMMAND_ROLLBACK);
    assert_verdict(TUMBLE_VERDICT_ROLLED_BACK);
    const tumble_set_t now = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_MEMORY(&first.coefficients, &now.coefficients, sizeof now.coefficients);
    TEST_ASSERT_EQUAL_UINT32(3, keeper.sequence); /* it grows, so that consumers notice */
    TEST_ASSERT_EQUAL_UINT8(3, tumble_history_count(&keeper.history));
}

static void test_rollback_is_refused_while_a_proposal_waits(void)
{
    (void)run_and_judge();
    drift(1e-5);
    hold_one();
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_ROLLBACK));
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.refused);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_DISCARD));
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_ROLLBACK)); /* one command at a time */
    settle_memory();
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ROLLBACK));
}

static void test_commands_about_sets_wait_for_the_end_of_a_run(void)
{
    hold_one();
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_ACCEPT));
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_DISCARD));
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_ROLLBACK));
    TEST_ASSERT_EQUAL_UINT32(3, keeper.counters.refused);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT));
    ASSERT_STATUS(TUMBLE_OK, accept_proposal());
}

/* Noise makes no two runs alike. The scripted block has none: what it says again is a replay. */
static void test_the_same_result_is_not_stored_twice(void)
{
    (void)run_and_judge();
    const uint32_t before = keeper.store.commits;
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_REPEATED, run_and_judge());
    TEST_ASSERT_BITS_HIGH(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_REPLAYED), state_of_keeper().objections);
    TEST_ASSERT_EQUAL_UINT32(before, keeper.store.commits);
    TEST_ASSERT_FALSE(state_of_keeper().has_proposal);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
}

static void test_nor_is_one_of_the_history(void)
{
    for (int i = 0; i < 5; i++) {
        TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
        drift(1e-5);
    }
    drift(-5e-5); /* as the first, which no slot holds any more */
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_REPEATED, run_and_judge());
    TEST_ASSERT_EQUAL_UINT32(5, keeper.sequence);
}

static void test_nor_is_a_proposal(void)
{
    (void)run_and_judge();
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_REPEATED, run_and_judge());
    TEST_ASSERT_TRUE(state_of_keeper().has_proposal);
}

static void test_the_first_set_waits_unless_the_settings_say_otherwise(void)
{
    settings.limits.flags = TUMBLE_COMMIT_BY_ITSELF;
    keeper_power_cycle();
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_and_judge());
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_FIRST));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_store_read(&keeper.store, TUMBLE_SET_ACTIVE, &(tumble_set_t){0}));
    decide(TUMBLE_COMMAND_ACCEPT);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
}

static void test_without_a_declared_stand_nothing_is_committed(void)
{
    keeper_config.uncertainty = NULL;
    keeper_power_cycle();
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_and_judge());
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN));
}

static void test_another_block_is_held(void)
{
    (void)run_and_judge();
    keeper_config.sets.serial = "TB-0002";
    keeper_power_cycle();
    assert_verdict_after(1e-6, TUMBLE_VERDICT_HELD);
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_BLOCK));
}

/* A position measured again in DONE makes a new result of the run. */
static void test_a_position_repeated_makes_a_new_result(void)
{
    (void)run_and_judge();
    drift(1e-5);
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_POSITION, 12));
    end_and_settle();
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_EQUAL_UINT32(2, keeper.counters.judged);
    TEST_ASSERT_EQUAL_UINT32(2, keeper.sequence);
}

/* DONE and a START by SDO in one and the same step: the result is looked at for some steps more, and needs its means. So
 * the new run has to wait. */
static void test_a_result_overtaken_by_a_start_is_not_lost(void)
{
    const tumble_can_frame_t heartbeat = {.id = 0x702, .length = 1, .data = {TUMBLE_NMT_OPERATIONAL}};
    const tumble_can_frame_t start = {.id = 0x601, .length = 8, .data = {0x2F, 0x02, 0x20, 0x02, TUMBLE_COMMAND_START}};
    start_to_average(17);
    while ((bench_progress(&bench).run.samples < (BENCH_SAMPLES - 1U)) || (bench.fake.to_firmware.count < 2U)) {
        bench_event(&bench); /* until the last sample waits */
    }
    for (int i = 0; i < 6; i++) { /* each lets the procedure go on by one: the parts of SOLVE, VERIFY, PROPOSE, DONE */
        fake_port_give(&bench.fake, &heartbeat);
    }
    fake_port_give(&bench.fake, &start);
    bench_event(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, run_state());
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.refused);
    ASSERT_STATUS(TUMBLE_E_STATE, bench_command(&bench, TUMBLE_COMMAND_REPEAT_POSITION, 3));
    ASSERT_STATUS(TUMBLE_E_STATE, bench_command(&bench, TUMBLE_COMMAND_REPEAT_MOUNTING, 1));
    TEST_ASSERT_EQUAL_UINT32(3, keeper.counters.refused);
    settle_memory();
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.judged);
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
}

/* The memory. */

static void test_a_memory_that_fails_leaves_the_active_set(void)
{
    (void)run_and_judge();
    const tumble_set_t active = set_of(TUMBLE_SET_ACTIVE);
    drift(1e-5);
    nv_refuse(&memory, NV_NEVER); /* from now on */
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_FAILED, run_and_judge());
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_E_NV, state_of_keeper().status);
    TEST_ASSERT_GREATER_THAN_UINT32(0, keeper.counters.failures);
    const tumble_set_t still = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_MEMORY(&active, &still, sizeof active);
    nv_arm(&memory, nv_no_fault);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge()); /* it was never stored: it is no replay */
    TEST_ASSERT_EQUAL_UINT32(2, keeper.sequence);
}

/* The result that could not be stored is made again from the checkpoint, without the table. */
static void test_what_could_not_be_stored_is_not_lost(void)
{
    start_to_average(17);
    while (run_state() != TUMBLE_STATE_DONE) {
        bench_event(&bench);
    }
    while (keeper.job == 0U) { /* until the commit begins */
        bench_event(&bench);
    }
    nv_refuse(&memory, NV_NEVER);
    settle_to(TUMBLE_VERDICT_FAILED);
    nv_arm(&memory, nv_no_fault);
    assert_resumable_after_power(18);
    obey_for(0.1, TUMBLE_COMMAND_RESUME);
    end_and_settle();
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).procedure.moves);
}

static void test_a_memory_that_cannot_be_read_at_the_end(void)
{
    (void)run_and_judge();
    drift(1e-5);
    start_to_average(17);
    memory.read_fails_at = 0;
    end_and_settle();
    assert_verdict(TUMBLE_VERDICT_FAILED);
    memory.read_fails_at = NV_NEVER;
    keeper_power_cycle();
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
}

static void test_a_busy_memory_is_waited_for(void)
{
    for (uint32_t every = 2; every < 8U; every++) {
        memory.busy_every = every;
        keeper_power_cycle();
        settle_memory();
        assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
        TEST_ASSERT_EQUAL_UINT32(0, keeper.counters.failures);
        TEST_ASSERT_EQUAL_UINT32(every - 1U, keeper.sequence);
        TEST_ASSERT_EQUAL_UINT8(every - 1U, tumble_history_count(&keeper.history));
    }
}

/* Power fails after the mark of the set and before the entry of the history: it is caught up on. */
static void test_a_missing_entry_of_the_history_is_written_at_power_on(void)
{
    (void)run_and_judge();
    memset(&memory.bytes[MEMORY_SECTOR * TUMBLE_REGION_HISTORY], 0xFF, 2U * MEMORY_SECTOR);
    keeper_power_cycle();
    settle_memory();
    TEST_ASSERT_EQUAL_UINT8(1, tumble_history_count(&keeper.history));
    TEST_ASSERT_EQUAL_UINT32(1, tumble_history_sequence(&keeper.history));
}

static void test_what_init_refuses(void)
{
    keeper_prepare();
    bench.fake.port.nv = NULL;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_init(&bench.navcomp, &bench.config));
    keeper_prepare();
    memory.nv.sector_bytes = 2048;
    ASSERT_STATUS(TUMBLE_E_NV, tumble_navcomp_init(&bench.navcomp, &bench.config));
    static const char *const serials[] = {NULL, "", "1234567890123456789012345"};
    for (size_t i = 0; i < COUNT_OF(serials); i++) {
        keeper_prepare();
        keeper_config.sets.serial = serials[i];
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_init(&bench.navcomp, &bench.config));
    }
    keeper_prepare();
    keeper_config.sets.serial = "123456789012345678901234";
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_init(&bench.navcomp, &bench.config));
    keeper_prepare();
    settings.pause_s = 59;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_init(&bench.navcomp, &bench.config));
    keeper_prepare();
    keeper_config.sets.settings = NULL;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_init(&bench.navcomp, &bench.config));
    keeper_prepare();
    keeper.config = NULL;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_init(&bench.navcomp, &bench.config));
    keeper_prepare();
    bench.config.keeper = NULL;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_init(&bench.navcomp, &bench.config));
}

static const around_t around_each = {keeper_power_on, NULL};
