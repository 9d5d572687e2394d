/* Whose the service level is: a setting of that level goes to the node only for the session that opened it last. */
#include "gateway_bench.h"

#define SETTING_LIMIT 5U   /* 2050h:5, which needs the level */
#define SETTING_SAMPLES 1U /* 2050h:1, which does not */

static gateway_session_t one;
static gateway_session_t other;

static void open_session(gateway_session_t *session)
{
    *session = (gateway_session_t){0};
    unlock(session);
}

static void set_up(void)
{
    bench_set_up();
    bench.k_xx = 2.0;
    until_there_is_a_snapshot();
    open_session(&one);
    open_session(&other);
}

/* The setting's result; what the node had to write is in `bench.written` and `last_write`. */
static gateway_result_t write_setting(gateway_session_t *session, uint16_t number, double value)
{
    uint8_t bytes[8];
    const uint16_t token = 1;
    uint16_t words[5] = {number};
    tumble_put_f64(bytes, value);
    for (size_t i = 0; i < 4U; i++) {
        words[1U + i] = tumble_get_u16(&bytes[6U - (2U * i)]);
    }
    bench.written = 0;
    TEST_ASSERT_EQUAL(GATEWAY_OK, gateway_session_write(session, &bench.gateway, GATEWAY_HOLDING_SETTING, 5, words,
                                                        bench.fake.now_us));
    TEST_ASSERT_EQUAL(GATEWAY_OK, gateway_session_write(session, &bench.gateway, GATEWAY_HOLDING_EXECUTE, 1, &token,
                                                        bench.fake.now_us));
    for (unsigned i = 0; i < 20U && session->sent.result == GATEWAY_RESULT_PENDING; i++) {
        exchange(1);
    }
    return (gateway_result_t)session->sent.result;
}

static void open_service(gateway_session_t *session)
{
    TEST_ASSERT_EQUAL(GATEWAY_RESULT_ACCEPTED,
                      write_setting(session, GATEWAY_SERVICE_KEY, (double)GATEWAY_SERVICE_NUMBER));
    TEST_ASSERT_EQUAL_HEX16(0x2006, last_write()->index);
}

static void assert_refused(gateway_session_t *session)
{
    TEST_ASSERT_EQUAL(GATEWAY_RESULT_NO_SERVICE, write_setting(session, SETTING_LIMIT, 1e-3));
    TEST_ASSERT_EQUAL_UINT(0, bench.written);
}

static void assert_sent(gateway_session_t *session)
{
    TEST_ASSERT_EQUAL(GATEWAY_RESULT_ACCEPTED, write_setting(session, SETTING_LIMIT, 1e-3));
    TEST_ASSERT_EQUAL_UINT(1, bench.written);
    TEST_ASSERT_EQUAL_HEX16(0x2050, last_write()->index);
    TEST_ASSERT_EQUAL_UINT8(5, last_write()->subindex);
}

static void test_it_holds_for_the_session_that_opened_it_last(void)
{
    assert_refused(&one);
    open_service(&one);
    assert_refused(&other);
    assert_sent(&one);
    TEST_ASSERT_EQUAL(GATEWAY_RESULT_ACCEPTED, write_setting(&other, SETTING_SAMPLES, 500.0));
    open_service(&other);
    assert_refused(&one);
    assert_sent(&other);
}

static void test_it_ends_when_it_ends_in_the_node(void)
{
    open_service(&one);
    bench.fake.now_us += GATEWAY_SERVICE_US - 1U;
    assert_sent(&one);
    bench.fake.now_us += 1U;
    assert_refused(&one);
}

/* The node's level is ended with the session, unless another has opened it since. */
static void test_it_ends_with_its_session(void)
{
    open_service(&one);
    open_service(&other);
    bench.written = 0;
    gateway_session_close(&one, &bench.gateway);
    exchange(20);
    TEST_ASSERT_EQUAL_UINT(0, bench.written);
    assert_sent(&other);
    bench.written = 0;
    gateway_session_close(&other, &bench.gateway);
    exchange(20);
    TEST_ASSERT_EQUAL_UINT(1, bench.written);
    TEST_ASSERT_EQUAL_HEX16(0x2006, last_write()->index);
    TEST_ASSERT_EQUAL_HEX32(0, tumble_get_u32(last_write()->bytes));
    open_session(&other); /* it may have the same place in memory as the one before */
    assert_refused(&other);
}

static void test_a_key_that_the_node_refuses_opens_nothing(void)
{
    bench.refuse = BUSY_NOW;
    TEST_ASSERT_EQUAL(GATEWAY_RESULT_REFUSED, write_setting(&one, GATEWAY_SERVICE_KEY, (double)GATEWAY_SERVICE_NUMBER));
    bench.refuse = 0;
    assert_refused(&one);
}

static const around_t around_each = {set_up, bench_tear_down};
