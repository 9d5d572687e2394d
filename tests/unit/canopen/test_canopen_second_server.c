/* Two SDO servers of one node (1200h, 1201h): two clients at the same time, each with transfers and variables of its
 * own. */
#include "canopen_fixture.h"

static tumble_second_server_t second;
static variables_t its; /* what its client stages */

static void start(tumble_second_server_t *server)
{
    const tumble_node_binding_t binding = {
        .port = &at.fake.port, .second = server, .variables = &at.variables, .other = &at.other, .context = &at};
    fixture_quietly();
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_node_init(&at.node, at.node.config, &binding));
}

static void set_up(void)
{
    memset(&its, 0, sizeof its);
    memset(&second, 0xA5, sizeof second);
    second.variables = &its;
    start(&second);
    boot();
}

#define ask_second(request, answer)                                                                                    \
    do {                                                                                                               \
        give(0x405, request);                                                                                          \
        expect(0x385, answer);                                                                                         \
        expect_nothing();                                                                                              \
    } while (0)

static void test_transfers_of_both_go_on_side_by_side(void)
{
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    ask_second("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    ask("60 00 00 00 00 00 00 00", "00 54 75 6D 62 6C 65 20");
    ask_second("60 00 00 00 00 00 00 00", "00 54 75 6D 62 6C 65 20");
    ask_second("70 00 00 00 00 00 00 00", "10 74 65 73 74 20 6E 6F");
    ask("70 00 00 00 00 00 00 00", "10 74 65 73 74 20 6E 6F");
    ask("60 00 00 00 00 00 00 00", "0B 64 65 00 00 00 00 00");
    ask_second("60 00 00 00 00 00 00 00", "0B 64 65 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT16(0, at.node.server.aborted + at.node.server.dropped);
    TEST_ASSERT_EQUAL_UINT16(0, second.server.aborted + second.server.dropped);
}

static void test_an_abort_ends_that_of_one_alone(void)
{
    ask("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    ask_second("21 0B 20 00 02 00 00 00", "60 0B 20 00 00 00 00 00");
    give(0x405, "80 0B 20 00 00 00 00 08");
    expect_nothing();
    ask("60 00 00 00 00 00 00 00", "00 54 75 6D 62 6C 65 20");
    ask_second("0B 61 62 00 00 00 00 00", "80 00 00 00 01 00 04 05");
    TEST_ASSERT_EQUAL_UINT16(0, at.node.server.aborted);
    TEST_ASSERT_EQUAL_UINT16(2, second.server.aborted);
}

static void test_each_has_variables_of_its_own(void)
{
    ask("2B 05 20 00 11 11 00 00", "60 05 20 00 00 00 00 00");
    ask_second("2B 05 20 00 22 22 00 00", "60 05 20 00 00 00 00 00");
    TEST_ASSERT_EQUAL_HEX16(0x1111, at.variables.u16);
    TEST_ASSERT_EQUAL_HEX16(0x2222, its.u16);
    ask("40 05 20 00 00 00 00 00", "4B 05 20 00 11 11 00 00");
    ask_second("40 05 20 00 00 00 00 00", "4B 05 20 00 22 22 00 00");
    ask_second("23 10 20 00 04 03 02 01", "60 10 20 00 00 00 00 00"); /* what has another home is there once */
    ask("40 10 20 00 00 00 00 00", "43 10 20 00 04 03 02 01");
    TEST_ASSERT_TRUE(at.node.dictionary.variables == &at.variables);
}

static void test_1201h_tells_its_identifiers(void)
{
    ask("40 01 12 00 00 00 00 00", "4F 01 12 00 02 00 00 00");
    ask("40 01 12 01 00 00 00 00", "43 01 12 01 05 04 00 00");
    ask("40 01 12 02 00 00 00 00", "43 01 12 02 85 03 00 00");
    ask_second("40 00 12 01 00 00 00 00", "43 00 12 01 05 06 00 00");
    ask_second("40 00 12 02 00 00 00 00", "43 00 12 02 85 05 00 00");
}

static void test_without_one_nobody_answers_there(void)
{
    start(NULL);
    boot_to_operational();
    ask("40 01 12 01 00 00 00 00", "43 01 12 01 05 04 00 80");
    ask("40 01 12 02 00 00 00 00", "43 01 12 02 85 03 00 80");
    TEST_ASSERT_FALSE(hand(0x405, "40 00 10 00 00 00 00 00"));
    expect_no_next();
    ask("23 00 14 01 05 04 00 00", "60 00 14 01 00 00 00 00"); /* and a PDO may be there */
}

static void test_no_pdo_takes_its_identifiers(void)
{
    static const char *const requests[][2] = {
        {"23 00 14 01 05 04 00 00", "80 00 14 01 30 00 09 06"}, {"23 00 14 01 85 03 00 40", "80 00 14 01 30 00 09 06"},
        {"23 00 18 01 85 03 00 00", "80 00 18 01 30 00 09 06"}, {"23 00 18 01 05 04 00 00", "80 00 18 01 30 00 09 06"},
        {"23 00 18 01 86 03 00 00", "60 00 18 01 00 00 00 00"}, {"23 00 14 01 06 04 00 00", "60 00 14 01 00 00 00 00"},
        {"23 00 14 01 05 04 00 80", "60 00 14 01 00 00 00 00"}, {"2F 00 14 02 FF 00 00 00", "60 00 14 02 00 00 00 00"},
    };
    for (size_t i = 0; i < COUNT_OF(requests); i++) {
        ask("23 00 14 01 00 00 00 80", "60 00 14 01 00 00 00 00");
        ask("23 00 18 01 00 00 00 80", "60 00 18 01 00 00 00 00");
        ask(requests[i][0], requests[i][1]);
    }
}

static void test_it_is_held_as_the_first_one_is(void)
{
    at.node.server.held = true;
    ask_second("2B 17 10 00 64 00 00 00", "80 17 10 00 22 00 00 08");
    at.node.server.held = false;
    ask_second("2B 17 10 00 00 00 00 00", "60 17 10 00 00 00 00 00");
}

static tumble_abort_t write_later(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    (void)context;
    (void)entry;
    (void)bytes;
    (void)size;
    return TUMBLE_ABORT_LATER;
}

static void test_an_answer_that_comes_later_goes_to_who_asked(void)
{
    static const tumble_object_hooks_t later = {.read = fixture_read, .write = write_later};
    at.node.dictionary.application.hooks = &later;
    give(0x405, "23 10 20 00 73 61 76 65");
    expect_no_next();
    tumble_node_answer(&at.node, TUMBLE_ABORT_NONE);
    expect_next(0x385, "60 10 20 00 00 00 00 00");
    expect_no_next();
    give(0x605, "23 10 20 00 73 61 76 65");
    tumble_node_answer(&at.node, TUMBLE_ABORT_HARDWARE);
    expect_next(0x585, "80 10 20 00 00 00 06 06");
    expect_no_next();
}

static void test_a_silent_client_is_given_up(void)
{
    ask_second("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(at.fake.now_us + TUMBLE_SDO_SERVER_TIMEOUT_US, tumble_node_next_us(&at.node));
    expect_after(TUMBLE_SDO_SERVER_TIMEOUT_US, 0x385, "80 08 10 00 00 00 04 05");
    expect_nothing();
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_node_next_us(&at.node));
}

static void test_it_is_silent_where_there_is_no_sdo(void)
{
    ask_second("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    give(0x000, "02 05");
    give(0x405, "60 00 00 00 00 00 00 00");
    expect_no_next();
    give(0x000, "80 05");
    ask_second("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05"); /* forgotten */
}

static void test_a_reset_begins_both_anew(void)
{
    ask_second("40 08 10 00 00 00 00 00", "41 08 10 00 10 00 00 00");
    trade(0x000, "82 05", 0x705, "00");
    ask_second("60 00 00 00 00 00 00 00", "80 00 00 00 01 00 04 05");
    ask_second("40 00 10 00 00 00 00 00", "43 00 10 00 92 01 02 00");
    ask("40 00 10 00 00 00 00 00", "43 00 10 00 92 01 02 00");
}

/* Both answers are due, and the port takes one frame at a time. */
static void test_a_narrow_port_loses_neither_answer(void)
{
    (void)hand(0x405, "40 00 10 00 00 00 00 00");
    (void)hand(0x605, "40 00 10 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT64(0, tumble_node_next_us(&at.node));
    at.fake.send_room = 1;
    expect_next(0x585, "43 00 10 00 92 01 02 00");
    TEST_ASSERT_EQUAL_UINT64(0, tumble_node_next_us(&at.node));
    at.fake.send_room = 1;
    expect_next(0x385, "43 00 10 00 92 01 02 00");
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_node_next_us(&at.node));
}

static const around_t around_each = {set_up, fixture_end};
