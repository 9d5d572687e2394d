/* Commands from the gateway to the node: their order, their results, and polls beside them. */
#include "gateway_bench.h"

void setUp(void)
{
    bench_set_up();
}

void tearDown(void)
{
    bench_tear_down();
}

static gateway_command_t command_of(uint8_t number)
{
    return (gateway_command_t){.index = gateway_command_objects[0], .argument = 3, .command = number};
}

static void test_commands(void)
{
    gateway_command_t one = command_of(1);
    gateway_command_t two = command_of(2);
    two.has_angle = true;
    two.angle_deg = -12.5;
    settle();
    TEST_ASSERT_TRUE(gateway_poller_command(&bench.poller, &one));
    TEST_ASSERT_TRUE(gateway_poller_command(&bench.poller, &two));
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_PENDING, one.result);
    TEST_ASSERT_EQUAL_UINT64(0, gateway_poller_next_us(&bench.poller));
    settle();
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, one.result);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, two.result);
    TEST_ASSERT_EQUAL_UINT8_ARRAY(((const uint8_t[]){1, 2, 1, 3, 2}), bench.writes, 5);
    TEST_ASSERT_EQUAL_UINT(5, bench.written);
    TEST_ASSERT_EQUAL_DOUBLE(-12.5, bench.angle_deg);
    TEST_ASSERT_EQUAL_UINT32(2, bench.poller.published.number); /* what they changed is read at once */
}

static void test_a_refused_argument_ends_the_command(void)
{
    gateway_command_t command = command_of(1);
    settle();
    bench.refuse = 0x06090030U;
    TEST_ASSERT_TRUE(gateway_poller_command(&bench.poller, &command));
    settle();
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_REFUSED, command.result);
    TEST_ASSERT_EQUAL_HEX32(0x06090030U, command.abort);
    TEST_ASSERT_EQUAL_UINT(1, bench.written);
}

static void test_a_command_in_the_middle_of_a_poll(void)
{
    gateway_command_t command = command_of(1);
    bench.k_xx = 1.0;
    for (int i = 0; i < 40; i++) {
        gateway_poller_step(&bench.poller);
        (void)serve();
    }
    TEST_ASSERT_TRUE(gateway_poller_command(&bench.poller, &command));
    settle();
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, command.result);
    TEST_ASSERT_EQUAL_UINT32(2, bench.poller.published.number);
    TEST_ASSERT_EQUAL_UINT32(0, count(GATEWAY_COUNT_POLLS_TORN));
}

static void test_a_command_without_an_answer(void)
{
    gateway_command_t command = command_of(1);
    gateway_command_t forgotten = command_of(2);
    settle();
    bench.silent = true;
    TEST_ASSERT_TRUE(gateway_poller_command(&bench.poller, &command));
    TEST_ASSERT_TRUE(gateway_poller_command(&bench.poller, &forgotten));
    gateway_poller_forget(&bench.poller, &forgotten);
    pass(2U * TUMBLE_SDO_CLIENT_TIMEOUT_US + 10U);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_UNANSWERED, command.result);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_PENDING, forgotten.result); /* nobody is told */
    TEST_ASSERT_EQUAL_UINT32(2, count(GATEWAY_COUNT_COMMANDS_UNANSWERED));
}

static void test_no_more_commands_than_fit(void)
{
    static gateway_command_t commands[GATEWAY_MAX_SESSIONS + 1U];
    for (size_t i = 0; i <= GATEWAY_MAX_SESSIONS; i++) {
        commands[i] = command_of(1);
        TEST_ASSERT_EQUAL_INT(i < GATEWAY_MAX_SESSIONS, gateway_poller_command(&bench.poller, &commands[i]));
    }
    settle();
    TEST_ASSERT_EQUAL_UINT32(GATEWAY_MAX_SESSIONS, count(GATEWAY_COUNT_COMMANDS_SENT));
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_NONE, commands[GATEWAY_MAX_SESSIONS].result);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_commands);
    RUN_TEST(test_a_refused_argument_ends_the_command);
    RUN_TEST(test_a_command_in_the_middle_of_a_poll);
    RUN_TEST(test_a_command_without_an_answer);
    RUN_TEST(test_no_more_commands_than_fit);
    return UNITY_END();
}
