/* What outsiders cannot change by SDO while a run is on, or a drive is there: what the axis and its watching hang on. */
#include "navcomp_sdo.h"

/* Whom we watch, the process data of the axis, and what these have brought. */
typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint32_t value;
} object_write_t;

static const object_write_t held[] = {
    {0x1016, 1, 4, 0},          {0x1016, 2, 4, 0},          {0x1017, 0, 2, 0},          {0x1029, 1, 1, 2},
    {0x1400, 1, 4, 0x80000182}, {0x1401, 1, 4, 0x80000000}, {0x1401, 2, 1, 254},        {0x1601, 0, 1, 0},
    {0x1800, 1, 4, 0x80000202}, {0x1800, 3, 2, 100},        {0x1801, 1, 4, 0x80000000}, {0x1A01, 0, 1, 0},
    {0x2040, 4, 2, 0x0427},     {0x2040, 5, 4, 12345},
};

static uint32_t write_object(const object_write_t *write)
{
    uint8_t bytes[4];
    tumble_put_u32(bytes, write->value);
    return sdo_write(write->index, write->subindex, bytes, write->size);
}

static void assert_held(void)
{
    for (size_t i = 0; i < sizeof held / sizeof held[0]; i++) {
        TEST_ASSERT_EQUAL_HEX32_MESSAGE(TUMBLE_ABORT_DEVICE_STATE, write_object(&held[i]), "held");
    }
}

static void test_a_run_keeps_what_the_axis_hangs_on(void)
{
    static const object_write_t state_pdo = {0x1802, 5, 2, 500};
    power_on_for(1.0);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    assert_held();
    TEST_ASSERT_EQUAL(TUMBLE_STATE_AVERAGE, bench_run(&bench, TUMBLE_STATE_AVERAGE, 60.0));
    assert_held();
    TEST_ASSERT_EQUAL_HEX32(0, write_object(&state_pdo)); /* that is for outsiders */
    TEST_ASSERT_EQUAL_UINT32(500, read_number(0x1802, 5, 2));
    TEST_ASSERT_EQUAL_HEX32(0x000201F4, read_number(0x1016, 1, 4));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
}

/* In segments too; and a run that has failed may go on, so it is held as well. */
static void test_a_failed_run_and_a_drive_that_is_there_keep_it(void)
{
    power_on_for(1.0);
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_AVERAGE, bench_run(&bench, TUMBLE_STATE_AVERAGE, 60.0));
    bench.block.dead = true;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_FAULT, bench_run(&bench, TUMBLE_STATE_DONE, 60.0));
    assert_held();
    const uint8_t begin[8] = {0x21, 0x16, 0x10, 1, 4};
    const uint8_t segment[8] = {0x07, 0, 0, 0, 0}; /* four bytes of seven, the last */
    uint8_t answer[8];
    ask(begin, answer);
    TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
    ask(segment, answer);
    TEST_ASSERT_EQUAL_HEX8(0x80, answer[0]);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, tumble_get_u32(&answer[4]));
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_ABORT));
    assert_held(); /* the table can be turned between runs, too; */
    unlock();
    assert_held(); /* at no level may that be taken away */
}

static void test_without_a_drive_it_is_free(void)
{
    bench.drive.dead = true;
    bench_power_on(&bench);
    bench.fake.to_firmware.count = 0; /* its boot-up message */
    bench_pass(&bench, 1.0);
    unlock();
    for (size_t i = 0; i < sizeof held / sizeof held[0]; i++) {
        TEST_ASSERT_NOT_EQUAL_MESSAGE(TUMBLE_ABORT_DEVICE_STATE, write_object(&held[i]), "still held");
    }
}

/* SYNC, EMCY, TIME, the drive's, other nodes', the block's; reserved ones. */
static const uint32_t of_others[] = {0x080, 0x081, 0x082, 0x083, 0x100, 0x182, 0x202, 0x282, 0x383, 0x580, 0x600,
                                     0x680, 0x683, 0x693, 0x700, 0x001, 0x101, 0x581, 0x601, 0x6E1, 0x701};

static uint32_t write_id(uint16_t index, uint32_t id)
{
    return write_object(&(object_write_t){index, 1, 4, id});
}

static uint32_t write_time(uint16_t index, uint8_t subindex, uint32_t value)
{
    return write_object(&(object_write_t){index, subindex, 2, value});
}

static void test_what_is_free_takes_no_identifier_of_others(void)
{
    static const uint32_t own[] = {0x181, 0x281, 0x481, 0x681, 0x6C1};
    power_on_for(1.0);
    for (uint16_t pdo = 0x1802; pdo <= 0x1804U; pdo++) {
        TEST_ASSERT_EQUAL_HEX32(0, write_id(pdo, 0x80000181U));
        for (size_t i = 0; i < sizeof of_others / sizeof of_others[0]; i++) {
            TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, write_id(pdo, of_others[i]));
        }
    }
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++) {
        TEST_ASSERT_EQUAL_HEX32(0, write_id(0x1802, own[i]));
        TEST_ASSERT_EQUAL_HEX32(0, write_id(0x1802, 0x80000000U));
    }
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_id(0x1802, 0x693)); /* whoever opens the level knows the bus */
}

static void test_what_is_free_leaves_the_bus_to_others(void)
{
    power_on_for(1.0);
    for (uint16_t pdo = 0x1802; pdo <= 0x1804U; pdo++) {
        TEST_ASSERT_EQUAL_HEX32(0, write_id(pdo, 0x80000000U));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, write_time(pdo, 3, 0));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, write_time(pdo, 3, 99));
        TEST_ASSERT_EQUAL_HEX32(0, write_time(pdo, 3, 100));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, write_time(pdo, 5, 1));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, write_time(pdo, 5, 9));
        TEST_ASSERT_EQUAL_HEX32(0, write_time(pdo, 5, 0));
        TEST_ASSERT_EQUAL_HEX32(0, write_time(pdo, 5, 10));
    }
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_time(0x1802, 3, 0));
    TEST_ASSERT_EQUAL_HEX32(0, write_time(0x1802, 5, 1));
}

static const around_t around_each = {bench_begin, NULL};
