/* Two clients of one computer, each through an SDO server of its own: what one stages for its command does not touch
 * what the other has staged. */
#include "keeper_sdo.h"

#include "support.h"

#define ARGUMENT 1U
#define COMMAND 2U
#define ANGLE 3U
#define PROPOSAL 4U

static tumble_second_client_t second;

static void set_up(void)
{
    memset(&second, 0xA5, sizeof second);
    memset(&stand_memory, 0, sizeof stand_memory);
    sdo_server = TUMBLE_SDO_TO_FIRST;
    keeper_prepare();
    bench.config.second_client = &second;
    power_on_for(1.0);
}

static void tear_down(void)
{
    sdo_server = TUMBLE_SDO_TO_FIRST;
}

static void stage(uint16_t server, uint8_t subindex, uint32_t value)
{
    sdo_server = server;
    TEST_ASSERT_EQUAL_HEX32(0, (subindex == ARGUMENT) ? write_byte(0x2002, subindex, (uint8_t)value)
                                                      : write_u32(0x2002, subindex, value));
}

static uint32_t say(uint16_t server, tumble_command_t number)
{
    sdo_server = server;
    return command((uint8_t)number);
}

static void test_each_confirms_what_it_has_staged(void)
{
    bench.never_confirm = true;
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, bench_run(&bench, TUMBLE_STATE_WAIT_MOUNTING, 60.0));
    stage(TUMBLE_SDO_TO_FIRST, ARGUMENT, 1);
    stage(TUMBLE_SDO_TO_SECOND, ARGUMENT, 2);
    TEST_ASSERT_EQUAL_UINT32(2, read_number(0x2002, ARGUMENT, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, say(TUMBLE_SDO_TO_SECOND, TUMBLE_COMMAND_CONFIRM_MOUNTING));
    TEST_ASSERT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, run_state());
    TEST_ASSERT_EQUAL_HEX32(0, say(TUMBLE_SDO_TO_FIRST, TUMBLE_COMMAND_CONFIRM_MOUNTING));
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x2002, ARGUMENT, 1));
    TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_WAIT_MOUNTING, run_state());
}

static void test_each_turns_to_its_own_angle(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, say(TUMBLE_SDO_TO_SECOND, TUMBLE_COMMAND_HOME_AXIS));
    bench_pass(&bench, 60.0);
    sdo_server = TUMBLE_SDO_TO_FIRST;
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2002, ANGLE, 3000.0)); /* beyond the cable */
    sdo_server = TUMBLE_SDO_TO_SECOND;
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2002, ANGLE, 30.0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, say(TUMBLE_SDO_TO_FIRST, TUMBLE_COMMAND_TURN_AXIS));
    TEST_ASSERT_EQUAL_HEX32(0, say(TUMBLE_SDO_TO_SECOND, TUMBLE_COMMAND_TURN_AXIS));
    bench_pass(&bench, 60.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 30.0, read_f64(0x2003, 10));
}

static void test_nobody_accepts_what_the_other_has_named(void)
{
    hold_one();
    const uint32_t name = read_number(0x2102, 14, 4);
    stage(TUMBLE_SDO_TO_FIRST, PROPOSAL, name);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, say(TUMBLE_SDO_TO_SECOND, TUMBLE_COMMAND_ACCEPT));
    TEST_ASSERT_EQUAL_HEX32(name, read_number(0x2102, 14, 4));
    TEST_ASSERT_EQUAL_HEX32(0, say(TUMBLE_SDO_TO_FIRST, TUMBLE_COMMAND_ACCEPT));
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2002, PROPOSAL, 4));
    settle_memory();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2102, 14)); /* it is the active set now */
}

static void test_the_boards_own_program_is_the_first_client(void)
{
    hold_one();
    stage(TUMBLE_SDO_TO_SECOND, PROPOSAL, 1);
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_accept(&bench.navcomp, read_number(0x2102, 14, 4)));
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x2002, PROPOSAL, 4));
}

static void test_the_service_level_is_one_for_both(void)
{
    sdo_server = TUMBLE_SDO_TO_SECOND;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_f64(0x2050, 5, 1e-3));
    TEST_ASSERT_EQUAL_HEX32(0, give_key(TUMBLE_SERVICE_KEY));
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 1e-3));
    sdo_server = TUMBLE_SDO_TO_FIRST;
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 2e-3));
}

static void test_what_is_saved_is_answered_to_who_asked(void)
{
    sdo_server = TUMBLE_SDO_TO_SECOND;
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1010, SAVE));
    sdo_server = TUMBLE_SDO_TO_FIRST;
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1011, LOAD));
}

static void test_an_nmt_reset_forgets_what_was_staged(void)
{
    stage(TUMBLE_SDO_TO_SECOND, ARGUMENT, 7);
    reset_by_nmt(TUMBLE_NMT_RESET_COMMUNICATION, 1.0);
    TEST_ASSERT_EQUAL_UINT32(7, read_number(0x2002, ARGUMENT, 1)); /* that is no business of the application */
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 1.0);
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2002, ARGUMENT, 1));
}
