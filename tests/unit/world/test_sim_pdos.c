/* No PDO of node 1 under the identifier of another: what outsiders may set freely does not reach the drive. */
#include "sim_guest.h"

#include <math.h>

#define OFF 0x80000181U
#define TO_DRIVE 0x202U
#define FROM_DRIVE 0x182U
#define KEY 0x76726573U

static void assert_written(uint16_t index, uint8_t subindex, uint32_t value)
{
    write_u32(1, index, subindex, value);
    TEST_ASSERT_EQUAL_HEX32(0, answer);
}

static void assert_refused(uint16_t index, uint32_t identifier)
{
    write_u32(1, index, 1, identifier);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, answer);
}

/* Expedited, so many bytes. */
static void assert_written_short(uint16_t index, uint8_t subindex, uint8_t size, uint16_t value)
{
    const uint8_t data[8] = {(uint8_t)(0x23U | ((4U - size) << 2U)),
                             (uint8_t)index,
                             (uint8_t)(index >> 8),
                             subindex,
                             (uint8_t)value,
                             (uint8_t)(value >> 8)};
    answer = UINT32_MAX;
    guest_send(0x601, 8, data);
    pass(20000);
    TEST_ASSERT_EQUAL_HEX32(0, answer);
}

/* How far the table turns after ABORT in a run, somebody having tried to send the state to the drive. */
static double way_to_stop_deg(bool tried)
{
    begin("", &LISTENER);
    run_to_a_move();
    if (tried) {
        assert_written(0x1802, 1, OFF);
        write_u32(1, 0x1802, 1, TO_DRIVE);
    } else {
        pass(40000);
    }
    pass(100000);
    const double from_deg = table_deg();
    ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_ABORT, 0));
    pass(6U * SECOND);
    TEST_ASSERT_TRUE(bench_world_is_at_rest(&world));
    return table_deg() - from_deg;
}

static void test_the_state_is_not_sent_as_a_controlword(void)
{
    static const uint16_t TRANSMIT[] = {0x1802, 0x1804};
    start_turning(WAITS);
    for (size_t i = 0; i < 2U; i++) {
        assert_written(TRANSMIT[i], 1, OFF);
        assert_refused(TRANSMIT[i], TO_DRIVE);
        assert_refused(TRANSMIT[i], FROM_DRIVE);
    }
    (void)command(TUMBLE_COMMAND_ABORT, 0);
    pass(3U * SECOND);
    TEST_ASSERT_TRUE(bench_world_is_at_rest(&world));
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, progress().stand_fault);
    TEST_ASSERT_EQUAL_UINT32(0, counters().stop.rungs[0]);
}

/* Mapped as controlword and target position: the seconds left of the service level would count through all its bits. */
static void test_nor_is_anything_else_that_can_be_mapped(void)
{
    start_turning(WAITS);
    pass(20U * SECOND);
    assert_written(0x1802, 1, OFF);
    assert_written_short(0x1A02, 0, 1, 0);
    assert_written(0x1A02, 1, 0x20060310U);
    assert_written(0x1A02, 2, 0x20030720U);
    assert_written_short(0x1A02, 0, 1, 2);
    assert_written(0x2006, 1, KEY);
    assert_written_short(0x1802, 3, 2, 0);
    assert_written_short(0x1802, 5, 2, 100);
    assert_refused(0x1802, TO_DRIVE);
    const double rest_deg = table_deg();
    pass(70U * SECOND);
    TEST_ASSERT_TRUE(fabs(least_deg - rest_deg) < 0.1 && fabs(most_deg - rest_deg) < 0.1);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, progress().stand_fault);
}

static void test_a_stop_in_a_run_is_as_short(void)
{
    const double undisturbed_deg = way_to_stop_deg(false);
    TEST_ASSERT_TRUE(undisturbed_deg > 0.5);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, undisturbed_deg, way_to_stop_deg(true));
    TEST_ASSERT_EQUAL_UINT32(0, counters().stop.rungs[0]);
}

static void test_nor_does_the_table_turn_beyond_the_cable(void)
{
    begin_homing(WAITS, &LISTENER, 20U * SECOND);
    assert_written(0x1802, 1, OFF);
    ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_TURN_AXIS, 400.0));
    while (table_deg() < 360.0) {
        pass(10000);
    }
    write_u32(1, 0x1802, 1, TO_DRIVE);
    pass(10U * SECOND);
    TEST_ASSERT_TRUE(most_deg <= 400.5);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, answer);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_IN_POSITION, progress().stand);
}
