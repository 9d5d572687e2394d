/* The keeper's objects as an outsider sees them by SDO: saved parameters, positions, history, stand, broadcast. */
#include "keeper_sdo.h"

static void change_parameters(void)
{
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2050, 1, 34));
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2122, 2, 86400));
    TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2125, 12, 0.25F));
}

static bool are_changed(void)
{
    const bool changed = read_number(0x2050, 1, 4) == 34U;
    TEST_ASSERT_EQUAL(changed, read_number(0x2122, 2, 4) == 86400U);
    TEST_ASSERT_EQUAL(changed, read_f32(0x2125, 12) == 0.25F);
    return changed;
}

static void test_parameters_outlast_power_when_they_are_saved(void)
{
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x1010, 1, 4));
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x1011, 1, 4));
    change_parameters();
    keeper_power_cycle();
    TEST_ASSERT_FALSE(are_changed());
    change_parameters();
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1010, SAVE));
    keeper_power_cycle();
    TEST_ASSERT_TRUE(are_changed());
    ASSERT_READS({0x2170, 1, 4, 1}, {0x2170, 2, 4, 0}, {0x2170, 3, 4, 49});
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1011, LOAD));
    TEST_ASSERT_TRUE(are_changed()); /* until the reset */
    keeper_power_cycle();
    TEST_ASSERT_FALSE(are_changed());
}

/* The record is made in the bytes that sets are read to. So as long as it is written none is read, and after that it is both
 * whole and saved. */
static void test_a_set_that_is_read_meanwhile_spoils_nothing(void)
{
    tumble_set_t set;
    (void)run_and_judge();
    change_parameters();
    ASSERT_STATUS(TUMBLE_OK, tumble_store_read(&keeper.store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_LATER, tumble_parameters_save(&keeper.parameters));
    int refused = 0;
    while (tumble_parameters_busy(&keeper.parameters)) {
        ASSERT_STATUS(TUMBLE_E_PORT_BUSY, tumble_store_read(&keeper.store, TUMBLE_SET_ACTIVE, &set));
        ASSERT_STATUS(TUMBLE_E_PORT_BUSY, tumble_store_discard(&keeper.store));
        refused++;
        tumble_navcomp_step(&bench.navcomp);
        bench.fake.now_us += 1000;
    }
    TEST_ASSERT_GREATER_THAN(5, refused);
    ASSERT_STATUS(TUMBLE_OK, tumble_store_read(&keeper.store, TUMBLE_SET_ACTIVE, &set));
    keeper_power_cycle();
    TEST_ASSERT_TRUE(are_changed());
}

static void test_a_reset_of_the_node_is_as_good_as_power_off(void)
{
    change_parameters();
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1010, SAVE));
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2050, 1, 5));
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2122, 2, 5));
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 1.0);
    TEST_ASSERT_TRUE(are_changed());
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1011, LOAD));
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 1.0);
    TEST_ASSERT_FALSE(are_changed());
}

static void test_saving_is_refused_with_the_right_code(void)
{
    static const uint32_t wrong[] = {0, 0x73617665U /* "evas" */, LOAD, SAVE + 1U, 0xFFFFFFFFU};
    unlock();
    for (size_t i = 0; i < (sizeof wrong / sizeof wrong[0]); i++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_STORE, write_and_wait(0x1010, wrong[i]));
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_STORE, write_and_wait(0x1011, SAVE));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX, write_u32(0x1010, 2, SAVE));
    nv_refuse(&memory, NV_NEVER);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_HARDWARE, write_and_wait(0x1010, SAVE));
    nv_arm(&memory, nv_no_fault);
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1010, SAVE));
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x2170, 1, 4));
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_and_wait(0x1010, SAVE));
}

static void test_a_smaller_memory_has_no_room_for_parameters(void)
{
    memory.nv.size_bytes = 8U * MEMORY_SECTOR;
    power_on_for(1.0);
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x1010, 1, 4));
    unlock();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_STORE, write_and_wait(0x1010, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_HARDWARE, write_and_wait(0x1010, SAVE));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_HARDWARE, write_and_wait(0x1011, LOAD));
}

static void test_the_positions_and_their_means(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2150, 2));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write_byte(0x2150, 1, 36));
    (void)run_and_judge();
    const tumble_averaging_t *averages = tumble_procedure_averages(tumble_navcomp_procedure(&bench.navcomp));
    for (uint8_t p = 0; p < 18U; p++) {
        double mean[3];
        double error[3];
        ASSERT_STATUS(TUMBLE_OK, tumble_averaging_mean(averages, p, mean, error));
        TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2150, 1, p));
        TEST_ASSERT_EQUAL_UINT32(p, read_number(0x2150, 1, 1));
        TEST_ASSERT_EQUAL_UINT32(BENCH_SAMPLES, read_number(0x2150, 2, 4));
        for (uint8_t c = 0; c < 3U; c++) {
            TEST_ASSERT_TRUE(mean[c] * 1e-6 == read_f64(0x2150, (uint8_t)(3U + c)));
            TEST_ASSERT_TRUE(error[c] * 1e-6 == read_f64(0x2150, (uint8_t)(6U + c)));
        }
        ASSERT_READS({0x2151, 1, 1, 18}, {0x2151, 2, 1, tumble_schedule_paper.positions[p].mounting},
                     {0x2151, 3, 1, tumble_schedule_paper.positions[p].number}, {0x2151, 4, 1, 0});
        TEST_ASSERT_TRUE(tumble_schedule_paper.positions[p].angle.deg == read_f64(0x2151, 5));
    }
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2150, 1, 18));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2150, 3));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2151, 2));
    TEST_ASSERT_EQUAL_UINT32(18, read_number(0x2151, 1, 1));
}

static void test_history_and_trend(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 1800000000));
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2160, 2, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2160, 3));
    (void)run_and_judge();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2163, 1));
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 1802629746)); /* a month later */
    assert_verdict_after(2e-5, TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_EQUAL_UINT32(2, read_number(0x2160, 2, 1));
    for (uint8_t age = 0; age < 2U; age++) {
        tumble_history_entry_t entry;
        ASSERT_STATUS(TUMBLE_OK, tumble_history_read(&keeper.history, age, &entry));
        TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2160, 1, age));
        TEST_ASSERT_EQUAL_UINT32(2U - age, read_number(0x2160, 3, 4));
        TEST_ASSERT_TRUE(entry.date_utc_s == read_u64(0x2160, 4));
        TEST_ASSERT_TRUE(entry.temperature_c == read_f32(0x2160, 5));
        TEST_ASSERT_EQUAL_UINT32(TUMBLE_ORIGIN_COMMITTED, read_number(0x2160, 6, 1));
        TEST_ASSERT_EQUAL_UINT32(TUMBLE_ESTIMATE_REFINED, read_number(0x2160, 7, 1));
        for (uint8_t c = 0; c < 12U; c++) {
            TEST_ASSERT_TRUE(entry.value[c] == read_f32(0x2161, (uint8_t)(c + 1U)));
            TEST_ASSERT_TRUE(entry.u[c] == read_f32(0x2162, (uint8_t)(c + 1U)));
        }
    }
    for (uint8_t c = 0; c < 12U; c++) {
        tumble_trend_t trend;
        ASSERT_STATUS(TUMBLE_OK, tumble_keeper_trend(&keeper, c, &trend));
        TEST_ASSERT_TRUE(trend.per_month == read_f64(0x2163, (uint8_t)(c + 1U)));
        TEST_ASSERT_TRUE(trend.u_per_month == read_f64(0x2164, (uint8_t)(c + 1U)));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2e-5, read_f64(0x2163, 10));
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2160, 1, 2));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2161, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write_byte(0x2160, 1, 64));
}

/* What an entry does not know is not there to read; everything else is. */
static void test_an_entry_of_the_history_without_temperature_or_uncertainty(void)
{
    static const tumble_history_entry_t bare = {.sequence = 7, .origin = TUMBLE_ORIGIN_COMMITTED};
    ASSERT_STATUS(TUMBLE_OK, tumble_history_append(&keeper.history, &bare));
    settle_memory();
    TEST_ASSERT_EQUAL_UINT32(7, read_number(0x2160, 3, 4));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2160, 5));
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_ORIGIN_COMMITTED, read_number(0x2160, 6, 1));
    TEST_ASSERT_TRUE(read_f32(0x2161, 1) == 0.0F);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2162, 1));
}

static void test_the_stand_as_it_is_seen(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2140, 1));
    (void)run_and_judge();
    for (uint8_t sub = 1; sub <= 5U; sub = (uint8_t)(sub + 2U)) {
        const double value = read_f64(0x2140, sub);
        const double u = read_f64(0x2140, (uint8_t)(sub + 1U));
        TEST_ASSERT_TRUE((u > 0.0) && (value < 3.0 * u) && (value > -3.0 * u));
    }
    const tumble_stand_view_t *view = tumble_stand_view(&bench.navcomp, &stand_memory);
    TEST_ASSERT_NOT_NULL(view);
    const uint32_t looked_at = stand_memory.mark.looked_at;
    stand_memory.view.number[0] = 123.0; /* not computed again for the same result */
    TEST_ASSERT_TRUE(read_f64(0x2140, 1) == 123.0);
    drift(1e-5);
    (void)run_and_judge();
    TEST_ASSERT_TRUE(read_f64(0x2140, 1) != 123.0);
    TEST_ASSERT_NOT_EQUAL(looked_at, stand_memory.mark.looked_at);
}

/* No inclinations; and of `inclined` nothing but the noise is told of the stand. What a run of it shows:
 * tests/integration/test_inclined_bench.py. */
static void test_the_inclinations_of_a_run_of_another_estimator(void)
{
    static tumble_inclinations_memory_t inclinations;
    keeper_config.inclinations_view = tumble_inclinations_view;
    keeper_config.inclinations_memory = &inclinations;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2141, 1));
    (void)run_and_judge();
    for (uint8_t sub = 1; sub <= 14U; sub++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2141, sub));
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX, refusal_of(0x2141, 15));
    bench.navcomp.procedure_config.estimate = TUMBLE_ESTIMATE_INCLINED; /* for the next run; nobody lends it */
    TEST_ASSERT_NULL(tumble_inclinations_view(&bench.navcomp, &inclinations));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2140, 1));
    TEST_ASSERT_TRUE(read_f64(0x2140, 9) > 0.0);
}

/* A channel that is declared to be next to silent is as much a part of it as another. */
static void test_a_channel_without_noise_hides_no_other(void)
{
    (void)run_and_judge();
    const double usual[] = {read_f64(0x2140, 1), read_f64(0x2140, 3), read_f64(0x2140, 5)};
    declared_stand.channel_noise_v[0] = 1e-300;
    stand_memory.mark.looked_at = 0;
    for (uint8_t i = 0; i < 3U; i++) {
        const double value = read_f64(0x2140, (uint8_t)(1U + (2U * i)));
        const double u = read_f64(0x2140, (uint8_t)(2U + (2U * i)));
        TEST_ASSERT_TRUE((u > 0.0) && (u < 1e-3));
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, usual[i], value);
    }
}

/* An NMT reset zeroes the procedure's counters, and the run after it has as many positions as the one before. */
static void test_the_stand_of_a_run_after_a_reset(void)
{
    (void)run_and_judge();
    const uint32_t number = bench.navcomp.run_number;
    TEST_ASSERT_EQUAL_UINT32(1, number);
    (void)read_f64(0x2140, 1);
    stand_memory.view.number[0] = 123.0;
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 1.0);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2140, 1));
    drift(1e-5);
    (void)run_and_judge();
    TEST_ASSERT_EQUAL_UINT32(2, bench.navcomp.run_number);
    TEST_ASSERT_TRUE(read_f64(0x2140, 1) != 123.0);
}

static void test_a_board_that_does_not_look_at_the_stand(void)
{
    keeper_config.stand_view = NULL;
    (void)run_and_judge();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2140, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2141, 1));
}

static unsigned listen_for_pdo(double seconds, uint8_t last[8])
{
    const uint64_t end_us = bench.fake.now_us + (uint64_t)(seconds * 1e6);
    unsigned heard = 0;
    tumble_can_frame_t frame;
    while (bench.fake.now_us < end_us) {
        tumble_navcomp_step(&bench.navcomp);
        while (fake_port_take(&bench.fake, &frame)) {
            if (frame.id == 0x681U) {
                TEST_ASSERT_EQUAL_UINT8(8, frame.length);
                memcpy(last, frame.data, 8);
                heard++;
            }
            bench_hear(&bench, &frame);
        }
        bench_play(&bench);
        bench.fake.now_us += 1000;
    }
    return heard;
}

static void test_the_calibration_counter_is_broadcast(void)
{
    uint8_t last[8] = {0};
    TEST_ASSERT_TRUE(listen_for_pdo(5.0, last) >= 2U);
    TEST_ASSERT_EQUAL_UINT32(0, tumble_get_u32(last));
    hold_one();
    TEST_ASSERT_TRUE(listen_for_pdo(5.0, last) >= 2U);
    TEST_ASSERT_EQUAL_UINT32(1, tumble_get_u32(last));
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE), tumble_get_u16(&last[4]));
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_VERDICT_HELD, last[6]);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, command(TUMBLE_COMMAND_ACCEPT));
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2002, 4, read_number(0x2102, 14, 4)));
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_ACCEPT));
    TEST_ASSERT_TRUE(listen_for_pdo(0.4, last) >= 1U); /* not by the event timer alone */
    TEST_ASSERT_EQUAL_UINT32(2, tumble_get_u32(last));
}

static void test_without_a_keeper_there_are_none_of_these_objects(void)
{
    keeper_prepare();
    bench.config.keeping = NULL;
    bench.config.keeper = NULL;
    power_on_for(1.0);
    for (uint8_t i = 0; i < tumble_keeper_table.count; i++) {
        const tumble_entry_t *entry = &tumble_keeper_table.entries[i];
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT, refusal_of(entry->index, entry->subindex));
    }
    uint8_t last[8];
    TEST_ASSERT_EQUAL_UINT(0, listen_for_pdo(5.0, last));
}

static const around_t around_each = {keeper_sdo_power_on, NULL};
