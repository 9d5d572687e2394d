/* When a run is due, the calendar, settings, the trend. */
#include "keeper_bench.h"

uint64_t tumble_keeper_whole_s(uint64_t us); /* private to the keeper */

#define UTC_S 1800000000U

static uint8_t due(void)
{
    return state_of_keeper().due;
}

/* The calendar. */

/* Against the division of 64 bits, which the firmware leaves out. From 2^53 on a double has not every microsecond. */
static void test_whole_seconds_are_those_of_a_division(void)
{
    for (uint64_t us = 1; us < (UINT64_MAX / 4U); us = (us * 3U) + 7U) {
        const uint64_t first_s = us / 1000000U;
        for (uint64_t whole_s = first_s; whole_s < (first_s + 64U); whole_s++) {
            TEST_ASSERT_EQUAL_UINT64(whole_s, tumble_keeper_whole_s(whole_s * 1000000U));
            TEST_ASSERT_EQUAL_UINT64(whole_s, tumble_keeper_whole_s((whole_s * 1000000U) + 999999U));
        }
    }
}

static void test_utc_is_kept_by_the_clock(void)
{
    TEST_ASSERT_EQUAL_UINT64(0, state_of_keeper().utc_s);
    bench_pass(&bench, 7.0);
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, UTC_S));
    bench_pass(&bench, 100.0);
    TEST_ASSERT_UINT64_WITHIN(1, UTC_S + 100U, state_of_keeper().utc_s);
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 5)); /* before the power-on of this clock */
    bench_pass(&bench, 1.0);
    TEST_ASSERT_UINT64_WITHIN(1, 6, state_of_keeper().utc_s);
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, TUMBLE_SETS_MAX_UTC_S));
    TEST_ASSERT_UINT64_WITHIN(1, TUMBLE_SETS_MAX_UTC_S, state_of_keeper().utc_s);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_keeper_set_utc(&keeper, TUMBLE_SETS_MAX_UTC_S + 1U));
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 0));
    TEST_ASSERT_EQUAL_UINT64(0, state_of_keeper().utc_s);
}

static void test_due_by_date(void)
{
    settings.interval_s = 86400;
    keeper_power_cycle();
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_NO_SET, due());
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, UTC_S));
    (void)run_and_judge();
    const uint64_t date_s = set_of(TUMBLE_SET_ACTIVE).date_utc_s;
    TEST_ASSERT_EQUAL_HEX8(0, due());
    keeper_power_cycle();
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, date_s + 86398U));
    TEST_ASSERT_EQUAL_HEX8(0, due());
    TEST_ASSERT_UINT32_WITHIN(1, 2, state_of_keeper().due_in_s);
    bench_pass(&bench, 3.0);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_TIME, due());
    TEST_ASSERT_EQUAL_UINT32(0, state_of_keeper().due_in_s);
    TEST_ASSERT_UINT32_WITHIN(2, 86401, state_of_keeper().age_s);
    drift(1e-5);
    (void)run_and_judge();
    TEST_ASSERT_EQUAL_HEX8(0, due());
}

/* Without a calendar it counts from power-on, and from the last change of the active set. */
static void test_due_by_uptime(void)
{
    settings.interval_s = 100;
    keeper_power_cycle();
    (void)run_and_judge();
    TEST_ASSERT_EQUAL_UINT64(0, set_of(TUMBLE_SET_ACTIVE).date_utc_s);
    bench_pass(&bench, 98.0);
    TEST_ASSERT_EQUAL_HEX8(0, due());
    bench_pass(&bench, 3.0);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_TIME, due());
    keeper_power_cycle();
    TEST_ASSERT_EQUAL_HEX8(0, due());
    bench_pass(&bench, 101.0);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_TIME, due());
}

static void test_due_by_temperature(void)
{
    settings.temperature_half_c = 6;
    keeper_power_cycle();
    (void)run_and_judge(); /* at 25 degrees C */
    bench.block.temperature_half_c = 56;
    bench_pass(&bench, 5.0);
    TEST_ASSERT_EQUAL_HEX8(0, due());
    bench.block.temperature_half_c = 57;
    bench_pass(&bench, 0.4);
    TEST_ASSERT_EQUAL_HEX8(0, due()); /* 50 samples at 100 a second */
    bench_pass(&bench, 0.3);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_TEMPERATURE, due());
    bench.block.temperature_half_c = 56;
    bench_pass(&bench, 0.1);
    TEST_ASSERT_EQUAL_HEX8(0, due());
    bench.block.temperature_half_c = 43;
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_TEMPERATURE, due());
    keeper.off_temperature = UINT16_MAX; /* after eleven minutes */
    bench_pass(&bench, 0.1);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_TEMPERATURE, due());
    keeper.stale = true; /* as after any job of the store: counted anew */
    settle_memory();
    TEST_ASSERT_EQUAL_HEX8(0, due());
    drift(1e-5);
    (void)run_and_judge(); /* now the active set is of this temperature */
    ASSERT_SAME_DOUBLE(21.5, set_of(TUMBLE_SET_ACTIVE).temperature_c);
    TEST_ASSERT_EQUAL_HEX8(0, due());
}

/* By itself. */

static void test_it_starts_by_itself_when_told_so(void)
{
    settings.interval_s = 100;
    keeper_power_cycle();
    (void)run_and_judge();
    bench_pass(&bench, 200.0);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, run_state()); /* it was not told */
    settings.flags = TUMBLE_SETS_STARTS;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_configure(&keeper, &settings));
    drift(1e-5);
    bench_pass(&bench, 0.5);
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_DONE, run_state());
    end_and_settle();
    TEST_ASSERT_EQUAL_UINT32(2, keeper.sequence);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.self_started);
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
}

/* A run that is refused or given up is not begun again before the pause is over. */
static void test_it_pauses_between_starts_by_itself(void)
{
    settings.flags = TUMBLE_SETS_STARTS;
    settings.pause_s = 120;
    keeper_power_cycle_for(1.0);
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_IDLE, run_state());
    bench_pass(&bench, 2.0);
    obey_for(119.0, TUMBLE_COMMAND_ABORT);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_ABORT, run_state());
    bench_pass(&bench, 1.5);
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_ABORT, run_state());
    TEST_ASSERT_EQUAL_UINT32(2, keeper.counters.self_started);
    /* One that somebody began and gave up is not begun again at once either. */
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT));
    obey_for(5.0, TUMBLE_COMMAND_START);
    obey_for(119.0, TUMBLE_COMMAND_ABORT);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_ABORT, run_state());
}

static void test_a_proposal_or_a_run_to_resume_keeps_it_from_starting(void)
{
    settings.interval_s = 10;
    keeper_power_cycle();
    (void)run_and_judge();
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    settings.flags = TUMBLE_SETS_STARTS;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_configure(&keeper, &settings));
    assert_starts_after(100.0, 0);
    obey_for(1.0, TUMBLE_COMMAND_DISCARD);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.self_started);
    run_to_average(4);
    settle_and_power_cycle();
    assert_state_after(100.0, TUMBLE_STATE_IDLE);
    assert_resumable(4);
}

/* Somebody must look at the table first: it was not seen to stop, or somebody else turns it. */
static void test_a_table_that_wants_a_look_keeps_it_from_starting(void)
{
    static const tumble_stand_fault_t faults[] = {TUMBLE_STAND_FAULT_FOREIGN, TUMBLE_STAND_FAULT_STOP};
    const tumble_can_frame_t foreign = fake_frame(0x202, 6, (const uint8_t[8]){0x0F});
    settings.flags = TUMBLE_SETS_STARTS;
    settings.pause_s = 60;
    keeper_power_cycle();
    for (uint32_t i = 0; i < 2U; i++) {
        assert_starts_after(1.0, i + 1U);
        obey_for(3.0, TUMBLE_COMMAND_ABORT);
        fake_port_give(&bench.fake, &foreign);
        bench_pass(&bench, 1.0);
        bench.axis.fault = (uint8_t)faults[i];
        TEST_ASSERT_EQUAL_INT(faults[i], bench_progress(&bench).stand_fault);
        assert_starts_after(200.0, i + 1U);
        TEST_ASSERT_EQUAL_INT(faults[i], bench_progress(&bench).stand_fault);
        ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_CLEAR_FAULT));
    }
}

/* Settings. */

static void refuse(tumble_sets_settings_t bad, const char *what)
{
    TEST_ASSERT_EQUAL_MESSAGE(TUMBLE_E_ARGUMENT, tumble_keeper_configure(&keeper, &bad), what);
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&settings, &keeper.settings, sizeof settings, what);
}

static void test_settings_are_taken_whole_or_not_at_all(void)
{
    tumble_sets_settings_t bad = settings;
    bad.gravity_m_s2 = 9.69;
    refuse(bad, "gravity low");
    bad.gravity_m_s2 = 9.91;
    refuse(bad, "gravity high");
    bad.gravity_m_s2 = NOT_A_NUMBER;
    refuse(bad, "gravity none");
    bad = settings;
    bad.pause_s = 59;
    refuse(bad, "pause");
    bad = settings;
    bad.temperature_samples = 0;
    refuse(bad, "samples");
    bad = settings;
    bad.flags = 2;
    refuse(bad, "flags");
    bad = settings;
    bad.limits.coverage = 0.5F;
    refuse(bad, "limits");
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_keeper_configure(&keeper, NULL));
    settings.gravity_m_s2 = 0.0;
    settings.interval_s = 7;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_configure(&keeper, &settings));
    TEST_ASSERT_EQUAL_UINT32(7, keeper.settings.interval_s);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_keeper_configure(&keeper, &settings));
}

/* The trend. */

static void test_the_trend_of_a_drifting_bias(void)
{
    tumble_trend_t trend;
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_keeper_trend(&keeper, 9, &trend));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_keeper_trend(&keeper, 12, &trend));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_keeper_trend(&keeper, 9, NULL));
    const double month_s = TUMBLE_MONTH_S;
    for (int month = 0; month < 6; month++) {
        ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, UTC_S + (uint64_t)(month * month_s)));
        TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
        drift(2e-5);
        keeper_power_cycle(); /* it survives */
    }
    for (uint8_t c = 9; c < 12U; c++) {
        ASSERT_STATUS(TUMBLE_OK, tumble_keeper_trend(&keeper, c, &trend));
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, 2e-5, trend.per_month);
        TEST_ASSERT_EQUAL_UINT32(4, trend.freedom);
        /* u of the slope of six months of equal weight: u / sqrt(17.5) */
        const double u = set_of(TUMBLE_SET_ACTIVE).uncertainty.u0_v[c - 9U];
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * u, u / 4.18330013267, trend.u_per_month);
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_trend(&keeper, 0, &trend));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0, trend.per_month);
    memory.read_fails_at = 0;
    ASSERT_STATUS(TUMBLE_E_NV, tumble_keeper_trend(&keeper, 0, &trend));
    memory.read_fails_at = NV_NEVER;
    tumble_history_entry_t entry;
    ASSERT_STATUS(TUMBLE_OK, tumble_history_read(&keeper.history, 0, &entry));
    ASSERT_STATUS(TUMBLE_OK, tumble_history_append(&keeper.history, &entry));
    ASSERT_STATUS(TUMBLE_E_PORT_BUSY, tumble_keeper_trend(&keeper, 0, &trend));
}

/* A run a month after the one before, in which the biases moved by so much. */
static tumble_verdict_t run_after_a_month(double moved_v)
{
    static uint64_t utc_s = UTC_S;
    utc_s += (uint64_t)TUMBLE_MONTH_S;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, utc_s));
    drift(moved_v);
    return run_and_judge();
}

static void assert_trend(double per_month, uint32_t freedom)
{
    tumble_trend_t trend;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_trend(&keeper, 9, &trend));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, per_month, trend.per_month);
    TEST_ASSERT_EQUAL_UINT32(freedom, trend.freedom);
}

static void test_what_was_given_up_is_no_drift(void)
{
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_after_a_month(2e-5));
    }
    assert_trend(2e-5, 1);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_after_a_month(5e-3));
    decide(TUMBLE_COMMAND_ACCEPT);
    decide(TUMBLE_COMMAND_ROLLBACK);
    TEST_ASSERT_EQUAL_UINT8(5, tumble_history_count(&keeper.history));
    assert_trend(2e-5, 1);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_after_a_month(-5e-3 + 4e-5));
    assert_trend(2e-5, 2);
}

static void test_an_exchange_of_the_block_is_no_drift(void)
{
    tumble_trend_t trend;
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_after_a_month(2e-5));
    }
    keeper_config.sets.serial = "TB-0002";
    keeper_power_cycle();
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_after_a_month(5e-3));
    decide(TUMBLE_COMMAND_ACCEPT);
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_keeper_trend(&keeper, 9, &trend));
    for (uint32_t i = 0; i < 3U; i++) {
        TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_after_a_month(-3e-5));
        assert_trend(-3e-5, i);
        keeper_power_cycle();
    }
}

/* A clock that was fifty years ahead: the set that it dated is told, a run is due, and no set after it is held for it. */
static void test_an_active_set_dated_after_the_present_holds_nothing(void)
{
    const uint64_t ahead_s = 50U * 31557600U;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, UTC_S + ahead_s));
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    TEST_ASSERT_EQUAL_HEX8(0, due());
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, UTC_S));
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_DATE, due());
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    assert_objects(0);
    TEST_ASSERT_EQUAL_HEX8(0, due());
    TEST_ASSERT_UINT64_WITHIN(1000, UTC_S, set_of(TUMBLE_SET_ACTIVE).date_utc_s);
}

/* Drift as where no date is known: that of a month. */
static void test_nor_does_it_excuse_a_change(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, UTC_S + (30U * (uint64_t)TUMBLE_MONTH_S)));
    (void)run_and_judge();
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, UTC_S));
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE));
}

static void test_a_clock_that_is_corrected_a_little_makes_no_run_due(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, UTC_S));
    (void)run_and_judge();
    const uint64_t date_s = set_of(TUMBLE_SET_ACTIVE).date_utc_s;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, date_s - TUMBLE_SETS_CLOCK_SLACK_S));
    bench_pass(&bench, 0.1);
    TEST_ASSERT_EQUAL_HEX8(0, due());
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, date_s - TUMBLE_SETS_CLOCK_SLACK_S - 10U));
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_DATE, due());
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 0));
    TEST_ASSERT_EQUAL_HEX8(0, due());
}

static const around_t around_each = {keeper_power_on, NULL};
