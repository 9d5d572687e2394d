/* The service level (2006h) and the run number (2007h) as outsiders see them: what is refused and when, what is told. */
#include "navcomp_sdo.h"

#include "support.h"

#define KEY TUMBLE_SERVICE_KEY

/* What was heard of them since `listen` began. */
static struct {
    unsigned pdos;
    unsigned emergencies;
    uint8_t pdo[8];       /* the last one */
    uint8_t emergency[8]; /* likewise */
} heard;

static void set_up(void)
{
    bench_init(&bench);
    power_on_for(1.0);
}

static void hear(const tumble_can_frame_t *frame)
{
    if (frame->id == 0x6C1U) {
        TEST_ASSERT_EQUAL_UINT8(7, frame->length);
        memcpy(heard.pdo, frame->data, 8);
        heard.pdos++;
    }
    if (frame->id == 0x081U) {
        memcpy(heard.emergency, frame->data, 8);
        heard.emergencies++;
    }
    bench_hear(&bench, frame);
}

static void listen(double seconds)
{
    const uint64_t end_us = bench.fake.now_us + (uint64_t)(seconds * 1e6);
    memset(&heard, 0, sizeof heard);
    while (bench.fake.now_us < end_us) {
        tumble_can_frame_t frame;
        tumble_navcomp_step(&bench.navcomp);
        while (fake_port_take(&bench.fake, &frame)) {
            hear(&frame);
        }
        bench_play(&bench);
        bench.fake.now_us += 1000U;
    }
}

static uint32_t level(void)
{
    return read_number(0x2006, 2, 1);
}

static uint32_t left_s(void)
{
    return read_number(0x2006, 3, 2);
}

static uint32_t run_number(void)
{
    return read_number(0x2007, 0, 4);
}

/* 2008h: of the state, of the result, of the running mean; UINT32_MAX: refused because there is none of that. */
static uint32_t run_of(uint8_t subindex)
{
    const uint32_t refusal = refusal_of(0x2008, subindex);
    TEST_ASSERT_TRUE(refusal == 0U || refusal == TUMBLE_ABORT_NO_DATA);
    return (refusal == 0U) ? read_number(0x2008, subindex, 4) : UINT32_MAX;
}

static void assert_runs(uint32_t state, uint32_t result, uint32_t mean)
{
    TEST_ASSERT_EQUAL_UINT32(state, run_of(1));
    TEST_ASSERT_EQUAL_UINT32(result, run_of(2));
    TEST_ASSERT_EQUAL_UINT32(mean, run_of(3));
    TEST_ASSERT_EQUAL_UINT32(state, run_number());
    TEST_ASSERT_EQUAL(refusal_of(0x2020, 5) == 0U, result != UINT32_MAX); /* it is there with what it is of */
    TEST_ASSERT_EQUAL(refusal_of(0x2010, 2) == 0U, mean != UINT32_MAX);
}

static void until_there_is_a_mean(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_STATE_AVERAGE, bench_run(&bench, TUMBLE_STATE_AVERAGE, 200.0));
    bench_pass(&bench, 0.1);
}

static void test_state_result_and_mean_say_which_run_they_are_of(void)
{
    assert_runs(0, UINT32_MAX, UINT32_MAX);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    assert_runs(1, UINT32_MAX, UINT32_MAX);
    until_there_is_a_mean();
    assert_runs(1, UINT32_MAX, 1);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, command(TUMBLE_COMMAND_START)); /* refused: no other run */
    assert_runs(1, UINT32_MAX, 1);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    assert_runs(1, 1, UINT32_MAX);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    assert_runs(2, UINT32_MAX, UINT32_MAX); /* the result of the run before is gone */
    until_there_is_a_mean();
    assert_runs(2, UINT32_MAX, 2);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_ABORT));
    bench_pass(&bench, 5.0);
    assert_runs(2, UINT32_MAX, 2); /* it can still be read */
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 5.0);
    assert_runs(2, UINT32_MAX, UINT32_MAX);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    assert_runs(3, UINT32_MAX, UINT32_MAX);
}

/* After a fault the same run goes on; measuring again out of DONE is another. */
static void test_what_goes_on_keeps_its_number(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    until_there_is_a_mean();
    bench.block.dead = true;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_run(&bench, TUMBLE_STATE_FAULT, 60.0));
    bench.block.dead = false;
    bench_pass(&bench, 5.0);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_RESUME));
    TEST_ASSERT_EQUAL_UINT32(1, run_of(1));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 900.0));
    assert_runs(1, 1, UINT32_MAX);
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2002, 1, 12)); /* of the mounting that is on the table */
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_REPEAT_POSITION));
    TEST_ASSERT_EQUAL_UINT32(2, run_of(1));
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, run_of(2));
}

static uint32_t write_limit(double limit_g)
{
    return write_f64(0x2050, 5, limit_g);
}

static double limit_g(void)
{
    return bench.navcomp.procedure_config.gravity_limit_g;
}

static void test_refused_before_and_accepted_after_unlocking(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, level());
    TEST_ASSERT_EQUAL_UINT32(0, left_s());
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_limit(1e-3));
    TEST_ASSERT_TRUE(limit_g() == 3e-4);
    TEST_ASSERT_EQUAL_HEX32(0, give_key(KEY));
    TEST_ASSERT_EQUAL_UINT32(1, level());
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_SERVICE_S, left_s());
    TEST_ASSERT_EQUAL_HEX32(0, write_limit(1e-3));
    TEST_ASSERT_TRUE(limit_g() == 1e-3);
    tumble_emcy_tell(&bench.navcomp.node.emcy, TUMBLE_EMCY_FOREIGN, TUMBLE_ERROR_PROFILE, 0);
    TEST_ASSERT_EQUAL_HEX32(0, give_key(0));
    TEST_ASSERT_EQUAL_HEX8(0x21, read_number(0x1001, 0, 1)); /* another's error stays */
    TEST_ASSERT_EQUAL_UINT32(0, level());
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_limit(2e-3));
    TEST_ASSERT_TRUE(limit_g() == 1e-3);
}

static void test_another_key_changes_nothing(void)
{
    static const uint32_t wrong[] = {1, KEY + 1U, 0x73657276U /* "vres" */, 0x65766173U /* "save" */, UINT32_MAX};
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, give_key(wrong[i]));
        TEST_ASSERT_EQUAL_UINT32(0, level());
    }
    unlock();
    bench_pass(&bench, 10.0);
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, give_key(wrong[i]));
        TEST_ASSERT_EQUAL_UINT32(1, level());
        TEST_ASSERT_EQUAL_UINT32(50, left_s()); /* nor is it prolonged */
    }
    uint8_t bytes[64];
    uint8_t size = 0;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_WRITE_ONLY, sdo_read(0x2006, 1, bytes, &size));
}

static void test_it_ends_after_its_time_unless_prolonged(void)
{
    unlock();
    const uint64_t begun_us = bench.fake.now_us;
    bench_pass(&bench, 59.0);
    TEST_ASSERT_EQUAL_UINT32(1, level());
    unlock();
    bench_pass(&bench, 59.0);
    TEST_ASSERT_EQUAL_HEX32(0, write_limit(1e-3));
    bench_pass(&bench, 0.9);
    TEST_ASSERT_EQUAL_UINT32(1, left_s());
    bench_pass(&bench, 0.2);
    TEST_ASSERT_TRUE(bench.fake.now_us > begun_us + 119000000U);
    TEST_ASSERT_EQUAL_UINT32(0, level());
    TEST_ASSERT_EQUAL_UINT32(0, left_s());
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_limit(2e-3));
}

static void test_it_ends_when_a_run_begins_and_is_not_opened_in_one(void)
{
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL_UINT32(0, level());
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, give_key(KEY));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, give_key(KEY + 1U));
    TEST_ASSERT_EQUAL_HEX32(0, give_key(0));
    bench.block.dead = true;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_run(&bench, TUMBLE_STATE_DONE, 60.0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, give_key(KEY)); /* it may go on */
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_ABORT));
    TEST_ASSERT_EQUAL_UINT32(0, level());
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_limit(1e-3));
    TEST_ASSERT_EQUAL_HEX32(0, give_key(KEY));
    TEST_ASSERT_EQUAL_HEX32(0, write_limit(1e-3));
}

static void test_a_reset_ends_it(void)
{
    for (uint8_t reset = 0x81; reset <= 0x82U; reset++) {
        unlock();
        TEST_ASSERT_EQUAL_HEX8(0x81, read_number(0x1001, 0, 1));
        reset_by_nmt(reset, 1.0);
        TEST_ASSERT_EQUAL_UINT32(0, level());
        TEST_ASSERT_EQUAL_HEX8(0, read_number(0x1001, 0, 1));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_limit(1e-3));
    }
    unlock();
    power_on_for(1.0);
    TEST_ASSERT_EQUAL_UINT32(0, level());
}

/* Told at once, and by the PDO's timer every second. */
static void test_its_changes_are_told(void)
{
    static const uint8_t opened[8] = {0x30, 0xFF, 0x81, 1, 0, 0, 0, 0};
    static const uint8_t ended[8] = {0};
    const tumble_can_frame_t key = fake_frame(0x601, 8, (const uint8_t[8]){0x23, 6, 0x20, 1, 's', 'e', 'r', 'v'});
    listen(5.0);
    TEST_ASSERT_EQUAL_UINT(0, heard.emergencies);
    TEST_ASSERT_UINT_WITHIN(1, 5, heard.pdos);
    fake_port_give(&bench.fake, &key);
    listen(0.3);
    TEST_ASSERT_EQUAL_UINT(1, heard.emergencies);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(opened, heard.emergency, 8);
    TEST_ASSERT_TRUE(heard.pdos >= 1U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){1, 60, 0, 0, 0, 0, 0}), heard.pdo, 7);
    fake_port_give(&bench.fake, &key); /* prolonged: not told again */
    listen(59.5);
    TEST_ASSERT_EQUAL_UINT(0, heard.emergencies);
    TEST_ASSERT_EQUAL_UINT8(1, heard.pdo[0]);
    listen(0.8);
    TEST_ASSERT_EQUAL_UINT(1, heard.emergencies);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(ended, heard.emergency, 8);
    TEST_ASSERT_EQUAL_UINT8(0, heard.pdo[0]);
}

static void test_runs_are_numbered(void)
{
    const tumble_can_frame_t start = fake_frame(0x601, 8, (const uint8_t[8]){0x2F, 2, 0x20, 2, TUMBLE_COMMAND_START});
    TEST_ASSERT_EQUAL_UINT32(0, run_number());
    fake_port_give(&bench.fake, &start);
    listen(0.05);
    TEST_ASSERT_TRUE(heard.pdos >= 1U);
    TEST_ASSERT_EQUAL_UINT32(1, tumble_get_u32(&heard.pdo[3]));
    TEST_ASSERT_EQUAL_UINT32(1, run_number());
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, command(TUMBLE_COMMAND_START)); /* one is on */
    TEST_ASSERT_EQUAL_UINT32(1, run_number());
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_ABORT));
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_START, 0)); /* nor is any overlooked */
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_ABORT, 0));
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_START, 0));
    TEST_ASSERT_EQUAL_UINT32(3, run_number());
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 1.0);
    TEST_ASSERT_EQUAL_UINT32(3, run_number());
    power_on_for(1.0);
    TEST_ASSERT_EQUAL_UINT32(0, run_number());
}

/* What it finds takes the place of the result before: it is a run of its own, and nobody writes its rules in it. */
static void test_a_repeated_position_out_of_done_is_a_run(void)
{
    const uint8_t last = (uint8_t)(bench.navcomp.procedure_config.schedule->position_count - 1U);
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_START, 0));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    unlock();
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_POSITION, last));
    TEST_ASSERT_FALSE(tumble_service_is_open(&bench.navcomp));
    TEST_ASSERT_EQUAL_UINT32(2, tumble_service_runs(&bench.navcomp));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_service_unlock(&bench.navcomp, KEY));
    bench.logged = 0;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    TEST_ASSERT_EQUAL_UINT32(2, tumble_service_runs(&bench.navcomp));
}

/* Each entry of the table that has the level, with the value that it has already: the level is all that keeps it out. */
static void test_every_object_of_that_level_asks_for_it(void)
{
    static const uint16_t wanted[] = {0x1016, 0x1017, 0x1029, 0x1400, 0x1401, 0x1600,
                                      0x1601, 0x1800, 0x1801, 0x1A00, 0x1A01, 0x2050};
    unsigned found = 0;
    for (uint8_t i = 0; i < tumble_navcomp_table.count; i++) {
        const tumble_entry_t *entry = &tumble_navcomp_table.entries[i];
        for (uint16_t object = 0; object <= entry->more_objects; object++) {
            const uint16_t index = (uint16_t)(entry->index + object);
            uint8_t bytes[64] = {0};
            uint8_t size = entry->size;
            if ((entry->access & TUMBLE_ACCESS_SERVICE) == 0U) {
                continue;
            }
            TEST_ASSERT_EQUAL_HEX32(0, sdo_read(index, entry->subindex, bytes, &size));
            TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, sdo_write(index, entry->subindex, bytes, size));
            for (size_t w = 0; w < COUNT_OF(wanted); w++) {
                found |= (wanted[w] == index) ? (1U << w) : 0U;
            }
        }
    }
    TEST_ASSERT_EQUAL_HEX(((1U << COUNT_OF(wanted)) - 1U), found);
}

/* What is not protected is as free as it was. */
static void test_the_others_need_none(void)
{
    uint8_t bytes[4];
    tumble_put_u32(bytes, 7);
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2050, 1, bytes, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2050, 2, (const uint8_t[]){TUMBLE_ESTIMATE_AVERAGED}, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2050, 3, bytes, 2));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2050, 4, bytes, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1003, 0, (const uint8_t[]){0}, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1802, 5, (const uint8_t[]){0xF4, 1}, 2));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1804, 5, (const uint8_t[]){0xF4, 1}, 2));
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x1803, 1, 0x80000000U)); /* not in use without a keeper */
}

/* The board's own program is not an outsider. */
static void test_writes_from_inside_go_on(void)
{
    uint8_t bytes[8];
    tumble_put_f64(bytes, 1e-3);
    TEST_ASSERT_EQUAL_HEX32(0, tumble_node_write(&bench.navcomp.node, 0x2050, 5, bytes, 8));
    TEST_ASSERT_TRUE(limit_g() == 1e-3);
    ASSERT_STATUS(TUMBLE_OK, tumble_service_unlock(&bench.navcomp, KEY));
    TEST_ASSERT_TRUE(tumble_service_is_open(&bench.navcomp));
    TEST_ASSERT_EQUAL_UINT16(60, tumble_service_left_s(&bench.navcomp));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_service_unlock(&bench.navcomp, 1));
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_START, 0));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_service_unlock(&bench.navcomp, KEY));
    TEST_ASSERT_EQUAL_UINT32(1, tumble_service_runs(&bench.navcomp));
}
