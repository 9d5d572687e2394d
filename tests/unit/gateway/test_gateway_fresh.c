/* What a session is told of its snapshot: whether it is newer than the command that the session executed last. */
#include "gateway_bench.h"

#define STATE 111U /* register of 2000h */

static gateway_session_t session;
static gateway_session_t other;

static void set_up(void)
{
    bench_set_up();
    session = (gateway_session_t){0};
    other = (gateway_session_t){0};
    bench.k_xx = 2.0;
    give(0x2000, 0, 1, 0);
}

static uint16_t input(gateway_session_t *of, uint16_t at)
{
    return gateway_session_input(of, &bench.gateway, at, 1, bench.fake.now_us)[at];
}

/* Take the newest snapshot; what it says of itself. */
static bool is_fresh(gateway_session_t *of)
{
    (void)input(of, GATEWAY_INPUT_SNAPSHOT_NUMBER + 1U);
    return input(of, GATEWAY_INPUT_FRESH) == 1U;
}

static void execute(uint16_t command, uint16_t number)
{
    const uint16_t words[2] = {command, number};
    unlock(&session);
    TEST_ASSERT_EQUAL(GATEWAY_OK, gateway_session_write(&session, &bench.gateway, GATEWAY_HOLDING_COMMAND, 2, words,
                                                        bench.fake.now_us));
}

static void test_without_a_snapshot_nothing_is_fresh(void)
{
    TEST_ASSERT_FALSE(is_fresh(&session));
    until_there_is_a_snapshot();
    TEST_ASSERT_TRUE(is_fresh(&session)); /* there was no command */
}

static uint8_t made; /* the state that follows from the command */

static void follow(void)
{
    if (last_write()->subindex == 2U) {
        give(0x2000, 0, 1, made);
    }
}

/* Wherever in a poll it comes: no snapshot that calls itself fresh lacks what followed from the command. */
static void test_a_fresh_snapshot_knows_what_the_command_did(void)
{
    until_there_is_a_snapshot();
    bench.on_write = follow;
    for (made = 1; made < 200U; made++) {
        unsigned steps = 0;
        bench.fake.now_us += PERIOD_US;
        for (unsigned i = 0; i < made; i++) {
            exchange(1);
        }
        execute(1, made);
        TEST_ASSERT_FALSE(is_fresh(&session));
        TEST_ASSERT_TRUE(is_fresh(&other)); /* it has executed nothing */
        while (!is_fresh(&session)) {
            exchange(1);
            bench.fake.now_us += 100U;
            TEST_ASSERT_LESS_THAN_UINT(STEPS_OF_A_POLL, ++steps);
        }
        TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, session.sent.result);
        TEST_ASSERT_EQUAL_UINT16(made, input(&session, STATE));
    }
}

static void test_a_refused_command_has_one_too(void)
{
    until_there_is_a_snapshot();
    bench.refuse = BUSY_NOW;
    execute(1, 7);
    const uint32_t number = bench.gateway.poller.published.number;
    while (!is_fresh(&session)) {
        exchange(1);
        bench.fake.now_us += 100U;
    }
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_REFUSED, session.sent.result);
    TEST_ASSERT_GREATER_THAN_UINT32(number, bench.gateway.poller.published.number);
}

static const around_t around_each = {set_up, bench_tear_down};
