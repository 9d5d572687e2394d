/* The keeper's objects as an outsider sees them by SDO: the sets, the state, what may be changed. */
#include "keeper_sdo.h"

/* Both tables, object by object. */
static void test_every_object_answers(void)
{
    const unsigned before = count_answers(&tumble_keeper_table);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    const unsigned with_one = count_answers(&tumble_keeper_table);
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    const unsigned with_both = count_answers(&tumble_keeper_table);
    printf(
        "values that answer: %u, with an active set %u, with a proposal %u; rows %u and %u, the latter of %u bytes\n",
        before, with_one, with_both, (unsigned)tumble_navcomp_table.count, (unsigned)tumble_keeper_table.count,
        (unsigned)(tumble_keeper_table.count * sizeof(tumble_entry_t)));
    TEST_ASSERT_TRUE((before < with_one) && (with_one < with_both));
    TEST_ASSERT_TRUE(count_answers(&tumble_navcomp_table) > 100U);
}

static void check_set(tumble_which_set_t which)
{
    const tumble_set_t set = set_of(which);
    const uint16_t at = (uint16_t)which;
    uint8_t bytes[64] = {0};
    uint8_t size = 0;
    ASSERT_READS({(uint16_t)(0x2100U + at), 1, 4, set.sequence}, {(uint16_t)(0x2100U + at), 2, 4, set.restores},
                 {(uint16_t)(0x2100U + at), 3, 1, set.origin}, {(uint16_t)(0x2100U + at), 4, 1, set.estimator},
                 {(uint16_t)(0x2100U + at), 5, 2, set.flags});
    TEST_ASSERT_EQUAL_HEX32(0, sdo_read((uint16_t)(0x2100U + at), 6, bytes, &size));
    TEST_ASSERT_EQUAL_UINT8(7, size);
    TEST_ASSERT_EQUAL_MEMORY("TB-0001", bytes, 7);
    TEST_ASSERT_TRUE(set.date_utc_s == read_u64((uint16_t)(0x2100U + at), 7));
    TEST_ASSERT_TRUE(set.temperature_c == read_f64((uint16_t)(0x2100U + at), 8));
    TEST_ASSERT_TRUE(set.gravity_m_s2 == read_f64((uint16_t)(0x2100U + at), 9));
    ASSERT_READS({(uint16_t)(0x2100U + at), 10, 4, set.samples}, {(uint16_t)(0x2100U + at), 11, 4, set.schedule_crc},
                 {(uint16_t)(0x2100U + at), 12, 4, set.stand_crc}, {(uint16_t)(0x2100U + at), 13, 4, set.reasons},
                 {(uint16_t)(0x2100U + at), 15, 1, (uint8_t)set.temperature_min_half_c},
                 {(uint16_t)(0x2100U + at), 16, 1, (uint8_t)set.temperature_max_half_c});
    assert_told(set.coefficients.k_v_per_g, set.coefficients.u0_v, (uint16_t)(0x2104U + at), (uint16_t)(0x2108U + at));
    assert_told(set.uncertainty.k_v_per_g, set.uncertainty.u0_v, (uint16_t)(0x210CU + at), (uint16_t)(0x2110U + at));
    TEST_ASSERT_TRUE(set.max_abs_fit_g == read_f64((uint16_t)(0x2114U + at), 1));
    TEST_ASSERT_TRUE(set.max_abs_check_g == read_f64((uint16_t)(0x2114U + at), 2));
    TEST_ASSERT_TRUE(set.limit_g == read_f64((uint16_t)(0x2114U + at), 3));
    TEST_ASSERT_EQUAL_UINT32(set.fit_positions, read_number((uint16_t)(0x2114U + at), 5, 1));
    TEST_ASSERT_EQUAL_UINT32(set.check_positions, read_number((uint16_t)(0x2114U + at), 6, 1));
}

/* Each of the four is there on its own indices, and nowhere else. */

static void test_the_sets(void)
{
    for (uint16_t index = 0x2100; index <= 0x2117U; index++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(index, 1));
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 1800000000));
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    check_set(TUMBLE_SET_ACTIVE);
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    check_set(TUMBLE_SET_ACTIVE);
    check_set(TUMBLE_SET_PROPOSAL);
    check_set(TUMBLE_SET_PREVIOUS);
    ASSERT_READS({0x2100, 1, 4, 2}, {0x2102, 1, 4, 3}, {0x2103, 1, 4, 1});
    for (uint16_t index = 0x2101; index <= 0x2117U; index = (uint16_t)(index + 4U)) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(index, 1)); /* no factory set */
    }
}

/* Numbers that the set does not know are refused, their neighbours are not. */

static void test_what_a_set_does_not_know_is_refused(void)
{
    keeper_config.uncertainty = NULL;
    settings.gravity_m_s2 = 0.0;
    bench.block.temperature_half_c = INT8_MAX; /* as warm as can be told, or warmer */
    keeper_power_cycle_for(1.0);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_and_judge());
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2102, 8));
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2102, 14));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2102, 15));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2102, 16));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2102, 9));
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2106, 9));
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x210A, 3));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x210E, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2112, 3));
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2116, 1));
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2116, 3));
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2116, 6));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2023, 1));
    const uint32_t bits =
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_FIRST);
    TEST_ASSERT_NOT_EQUAL(0, read_number(0x2102, 13, 4) & bits);
}

static void test_a_memory_that_cannot_be_read_now_or_at_all(void)
{
    (void)run_and_judge();
    memory.busy_every = 1;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2100, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2160, 3));
    memory.busy_every = 0;
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2100, 1));
    memory.read_fails_at = 0;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_HARDWARE, refusal_of(0x2160, 3));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2104, 9)); /* of a set: ask again, twice */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2104, 9));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_HARDWARE, refusal_of(0x2104, 9));
}

static void test_uncertainties_of_the_result(void)
{
    tumble_uncertainty_t u;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2023, 1));
    (void)run_and_judge();
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_uncertainty(&bench.navcomp, TUMBLE_ALL_COEFFICIENTS, &u));
    assert_told(u.k_v_per_g, u.u0_v, 0x2023, 0x2024);
}

static void test_the_state_is_the_keepers(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 1800000000));
    hold_one();
    const tumble_sets_state_t state = state_of_keeper();
    TEST_ASSERT_TRUE(state.utc_s == read_u64(0x2120, 1));
    ASSERT_READS({0x2120, 2, 4, 1}, {0x2120, 3, 4, state.age_s}, {0x2120, 4, 4, state.due_in_s}, {0x2120, 5, 2, 0},
                 {0x2120, 6, 2, TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE)}, {0x2120, 7, 1, TUMBLE_VERDICT_HELD},
                 {0x2120, 8, 1, 0}, {0x2120, 9, 1, state.due}, {0x2120, 11, 1, 0}, {0x2120, 12, 1, 0},
                 {0x2120, 13, 1, 1}, {0x2120, 14, 1, 0}, {0x2130, 1, 4, 2}, {0x2130, 2, 4, 1}, {0x2130, 3, 4, 1},
                 {0x2130, 9, 4, 36}, {0x2131, 1, 4, 1}, {0x2131, 10, 4, 0});
}

static void test_what_the_host_tells(void)
{
    uint8_t bytes[8];
    const uint8_t five[2] = {5, 0};
    tumble_put_u64(bytes, 1800000000);
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2121, 1, bytes, 8));
    TEST_ASSERT_TRUE(read_u64(0x2121, 1) == 1800000000U);
    tumble_put_u64(bytes, TUMBLE_SETS_MAX_UTC_S + 1U);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, sdo_write(0x2121, 1, bytes, 8));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2121, 2, five, 2));
    TEST_ASSERT_EQUAL_UINT32(5, read_number(0x2121, 2, 2));
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x2120, 11, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, command(TUMBLE_COMMAND_START));
    bench_pass(&bench, 5.5);
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2120, 11, 1));
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
}

/* Every setting is read back, and refused beyond its limits and while a run is on. */

static void test_the_settings(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2122, 1, 9.75));
    TEST_ASSERT_TRUE(keeper.settings.gravity_m_s2 == 9.75);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, write_f64(0x2122, 1, 1.62));
    TEST_ASSERT_TRUE(read_f64(0x2122, 1) == 9.75);
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2122, 2, 86400));
    TEST_ASSERT_EQUAL_UINT32(86400, read_number(0x2122, 2, 4));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, write_u32(0x2122, 3, 59));
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2122, 3, 600));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, sdo_write(0x2122, 4, (const uint8_t[]){0, 0}, 2));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2122, 4, (const uint8_t[]){7, 0}, 2));
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2122, 5, 20));
    unlock();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write_byte(0x2122, 6, 2));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write_byte(0x2123, 2, 4));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, write_f32(0x2123, 1, 0.5F));
    TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2123, 1, 2.5F));
    for (uint8_t sub = 1; sub <= 12U; sub++) {
        TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2124, sub, 0.001F * (float)sub));
        TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2125, sub, 0.002F * (float)sub));
        TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2126, sub, 0.003F * (float)sub));
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, write_f32(0x2124, 1, 0.0F));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write_f32(0x2125, 12, 1.5F));
    const tumble_sets_settings_t *now = &keeper.settings;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        TEST_ASSERT_TRUE(now->limits.uncertainty[c] == 0.001F * (float)(c + 1));
        TEST_ASSERT_TRUE(now->limits.drift_per_month[c] == 0.002F * (float)(c + 1));
        TEST_ASSERT_TRUE(now->limits.drift_per_kelvin[c] == read_f32(0x2126, (uint8_t)(c + 1)));
    }
    TEST_ASSERT_EQUAL_UINT32(600, now->pause_s);
    TEST_ASSERT_EQUAL_UINT16(7, now->temperature_samples);
    TEST_ASSERT_EQUAL_UINT8(20, now->temperature_half_c);
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2122, 6, 1)); /* begins by itself, for there is no set */
    TEST_ASSERT_EQUAL_UINT8(1, now->flags);
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_u32(0x2122, 2, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_f32(0x2126, 1, 0.5F));
}

static void test_the_table_is_turned_by_sdo_between_runs(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_HOME_AXIS));
    bench_pass(&bench, 30.0);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_STAND_IN_POSITION, read_number(0x2003, 12, 1));
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2002, 3, 123.25));
    TEST_ASSERT_TRUE(read_f64(0x2002, 3) == 123.25);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_TURN_AXIS));
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_STAND_MOVING, read_number(0x2003, 12, 1));
    bench_pass(&bench, 30.0);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_STAND_IN_POSITION, read_number(0x2003, 12, 1));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 123.25, read_f64(0x2003, 10));
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2002, 3, 400.0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, command(TUMBLE_COMMAND_TURN_AXIS)); /* beyond the cable */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write_f64(0x2002, 3, 3601.0));
}

static const around_t around_each = {keeper_sdo_power_on, NULL};
