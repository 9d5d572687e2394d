/* The gateway's side of the bus: polls, snapshots, marks, what is kept, silence. */
#include "gateway_bench.h"

static void test_a_poll_in_each_period(void)
{
    bench.k_xx = 2.0;
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_LINK_UNKNOWN, bench.gateway.poller.link_state);
    settle();
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_LINK_UP, bench.gateway.poller.link_state);
    TEST_ASSERT_EQUAL_UINT32(1, bench.gateway.poller.published.number);
    for (uint32_t polls = 2; polls < 12U; polls++) {
        pass(PERIOD_US);
        TEST_ASSERT_EQUAL_UINT32(polls, bench.gateway.poller.published.number);
        TEST_ASSERT_EQUAL_UINT32(polls, count(GATEWAY_COUNT_POLLS));
    }
    TEST_ASSERT_EQUAL_UINT64(bench.fake.now_us, bench.gateway.poller.published.taken_us);
}

static unsigned selectors(void)
{
    unsigned found = 0;
    for (size_t i = 0; i < GATEWAY_GROUPS; i++) {
        found += (gateway_selectors[i] < GATEWAY_KEYS) ? 1U : 0U;
    }
    return found;
}

/* Each object once, however many registers it has; each mark twice more, what selects others once more. */
static void test_no_object_is_read_twice_in_a_row(void)
{
    bench.k_xx = 2.0;
    settle();
    for (size_t i = 1; i < GATEWAY_VALUES; i++) {
        const gateway_value_t value = gateway_value(i);
        const gateway_value_t before = gateway_value(i - 1U);
        TEST_ASSERT_TRUE(value.index != before.index || value.subindex != before.subindex);
    }
    TEST_ASSERT_EQUAL_UINT(GATEWAY_VALUES + 2U * GATEWAY_MARKS + selectors(), bench.reads);
    TEST_ASSERT_EQUAL_UINT32(GATEWAY_VALUES - 2U, count(GATEWAY_COUNT_VALUES_REFUSED));
}

static unsigned reads_of_next_poll(void)
{
    const unsigned before = bench.reads;
    const uint32_t number = bench.gateway.poller.published.number;
    while (bench.gateway.poller.published.number == number) {
        pass(PERIOD_US / 10U);
    }
    return bench.reads - before;
}

static unsigned kept_objects(void)
{
    unsigned objects = 0;
    for (size_t i = 0; i < GATEWAY_VALUES; i++) {
        const gateway_value_t value = gateway_value(i);
        objects += (value.group != GATEWAY_GROUP_ALWAYS && value.key == GATEWAY_KEYS) ? 1U : 0U;
    }
    return objects;
}

static void test_what_is_kept_is_read_when_it_may_have_changed(void)
{
    const tumble_can_frame_t boot_up = {.id = 0x700U + NODE, .length = 1};
    bench.k_xx = 2.0;
    const unsigned all = reads_of_next_poll();
    const unsigned few = all - kept_objects() - selectors();
    TEST_ASSERT_LESS_THAN_UINT(all, few);
    for (unsigned i = 0; i < GATEWAY_KEPT_POLLS; i++) {
        TEST_ASSERT_EQUAL_UINT(few, reads_of_next_poll());
        TEST_ASSERT_EQUAL_HEX16(0x4000U, bench.gateway.poller.published.words[161]);
        TEST_ASSERT_EQUAL_HEX16(1U, bench.gateway.poller.published.words[160]);
    }
    TEST_ASSERT_EQUAL_UINT(all, reads_of_next_poll());
    TEST_ASSERT_EQUAL_UINT(few, reads_of_next_poll());
    bench.k_xx = 3.0;
    TEST_ASSERT_EQUAL_UINT(all, reads_of_next_poll());
    TEST_ASSERT_EQUAL_HEX16(0x4040U, bench.gateway.poller.published.words[161]);
    TEST_ASSERT_EQUAL_UINT(few, reads_of_next_poll());
    fake_port_give(&bench.fake, &boot_up);
    TEST_ASSERT_EQUAL_UINT(all, reads_of_next_poll());
    TEST_ASSERT_EQUAL_UINT(few, reads_of_next_poll());
    bench.sdo.silent = true;
    pass(2U * PERIOD_US);
    bench.sdo.silent = false;
    TEST_ASSERT_EQUAL_UINT(all, reads_of_next_poll());
}

static void test_a_node_that_boots_within_a_poll_tears_it(void)
{
    const tumble_can_frame_t boot_up = {.id = 0x700U + NODE, .length = 1};
    bench.k_xx = 2.0;
    for (int steps = 1; steps < 400; steps++) {
        bench_set_up();
        bench.k_xx = 2.0;
        for (int i = 0; i < steps && bench.gateway.poller.published.number == 0U; i++) {
            exchange(1);
        }
        const bool is_over = bench.gateway.poller.published.number != 0U;
        fake_port_give(&bench.fake, &boot_up);
        settle();
        TEST_ASSERT_EQUAL_UINT32(is_over ? 0U : 1U, count(GATEWAY_COUNT_POLLS_TORN));
        TEST_ASSERT_EQUAL_UINT32(1, count(GATEWAY_COUNT_POLLS));
    }
}

/* The place among the marks. */
static unsigned place_of_k(void)
{
    unsigned place = 0;
    while (gateway_tells[place].index != 0x2020U) {
        place++;
    }
    return place;
}

/* The mark K changes at any of the reads: then the poll counts only if it was before the first or after the last time that
 * the mark itself is read. */
static void test_a_change_at_any_read_is_no_mixture(void)
{
    bench.k_xx = 1.0;
    settle();
    const unsigned reads = bench.reads;
    for (unsigned at = 1; at <= reads; at++) {
        bench_set_up();
        bench.k_xx = 1.0;
        bench.tear_at = at;
        settle();
        const unsigned first = place_of_k() + 1U;
        const bool is_torn = at > first && at <= reads - selectors() - GATEWAY_MARKS + first;
        TEST_ASSERT_EQUAL_UINT32(is_torn ? 1U : 0U, count(GATEWAY_COUNT_POLLS_TORN));
        TEST_ASSERT_EQUAL_UINT32(1, count(GATEWAY_COUNT_POLLS));
    }
}

static void test_torn_without_end_waits_for_the_next_period(void)
{
    bench.k_xx = 1.0;
    for (unsigned period = 1; period <= 5U; period++) {
        for (unsigned i = 0; i < GATEWAY_MAX_TORN; i++) {
            const uint32_t before = count(GATEWAY_COUNT_POLLS_TORN);
            bench.tear_at = 20;
            while (count(GATEWAY_COUNT_POLLS_TORN) == before) {
                exchange(1);
            }
        }
        settle();
        TEST_ASSERT_EQUAL_UINT32(period * GATEWAY_MAX_TORN, count(GATEWAY_COUNT_POLLS_TORN));
        TEST_ASSERT_EQUAL_UINT32(0, bench.gateway.poller.published.number);
        TEST_ASSERT_GREATER_THAN_UINT64(bench.fake.now_us, gateway_poller_next_us(&bench.gateway.poller));
        bench.fake.now_us = gateway_poller_next_us(&bench.gateway.poller);
    }
    settle();
    TEST_ASSERT_EQUAL_UINT32(1, bench.gateway.poller.published.number);
}

static void test_a_disturbed_transfer_is_no_refusal(void)
{
    bench.k_xx = 1.0;
    const uint32_t codes[] = {0x05030000U, 0x05040000U, 0x05040001U};
    for (size_t i = 0; i < COUNT_OF(codes); i++) {
        bench.abort_next = codes[i];
        pass(PERIOD_US);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, count(GATEWAY_COUNT_POLLS_TORN));
        TEST_ASSERT_EQUAL_UINT16(1, bench.gateway.poller.published.words[160] & 1U);
    }
}

/* The node's memory is at work: the value is there again with the next poll, and not only when all is read anew. */
static void test_a_value_that_cannot_be_read_now_is_read_soon(void)
{
    bench.k_xx = 2.0;
    bench.busy_at = 2; /* as a mark, as a value, as a mark */
    const unsigned all = reads_of_next_poll();
    TEST_ASSERT_EQUAL_UINT(0, bench.busy_at);
    TEST_ASSERT_EQUAL_UINT16(0, bench.gateway.poller.published.words[160] & 1U);
    TEST_ASSERT_EQUAL_UINT(all, reads_of_next_poll());
    TEST_ASSERT_EQUAL_UINT16(1, bench.gateway.poller.published.words[160] & 1U);
    TEST_ASSERT_LESS_THAN_UINT(all, reads_of_next_poll());
    TEST_ASSERT_EQUAL_UINT16(1, bench.gateway.poller.published.words[160] & 1U);
}

/* A result that is held changes the proposal only when it is written, long after it was judged. */
static void test_the_verdict_is_a_mark(void)
{
    bool is_mark = false;
    for (size_t i = 0; i < GATEWAY_MARKS; i++) {
        is_mark = is_mark || (gateway_tells[i].index == 0x2120U && gateway_tells[i].subindex == 7U);
    }
    TEST_ASSERT_TRUE(is_mark);
}

static void test_silence(void)
{
    settle();
    bench.sdo.silent = true;
    pass(PERIOD_US);
    pass(TUMBLE_SDO_CLIENT_TIMEOUT_US + 1U);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_LINK_SILENT, bench.gateway.poller.link_state);
    TEST_ASSERT_EQUAL_UINT32(1, bench.gateway.poller.published.number);
    TEST_ASSERT_EQUAL_UINT32(1, count(GATEWAY_COUNT_POLLS_FAILED));
    pass(10U * PERIOD_US);
    TEST_ASSERT_UINT32_WITHIN(1, 7, count(GATEWAY_COUNT_POLLS_FAILED)); /* one each period and an answer's time */
    bench.sdo.silent = false;
    pass(2U * PERIOD_US);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_LINK_UP, bench.gateway.poller.link_state);
    TEST_ASSERT_GREATER_THAN_UINT32(1, bench.gateway.poller.published.number);
}

/* It leaves the first server to others, and asks it nothing, as long as the second one answers. */
static void test_it_uses_the_second_server(void)
{
    bench.k_xx = 2.0;
    for (int polls = 0; polls < 3; polls++) {
        pass(PERIOD_US);
        TEST_ASSERT_TRUE(bench.sdo.is_second);
    }
    TEST_ASSERT_EQUAL_UINT(0, bench.looks);
}

static void test_a_node_with_one_server(void)
{
    gateway_command_t command = gateway_command(0x2002, 0, NULL, NULL, 1);
    bench.sdo.has_one_server = true;
    bench.k_xx = 2.0;
    pass(TUMBLE_SDO_CLIENT_TIMEOUT_US + PERIOD_US);
    TEST_ASSERT_EQUAL_UINT32(1, count(GATEWAY_COUNT_POLLS_FAILED));
    pass(3U * PERIOD_US);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_LINK_UP, bench.gateway.poller.link_state);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(3, bench.gateway.poller.published.number);
    TEST_ASSERT_EQUAL_UINT32(1, count(GATEWAY_COUNT_POLLS_FAILED));
    TEST_ASSERT_EQUAL_UINT(1, bench.looks); /* once, not with every poll */
    carry_out(&command);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, command.result);
}

/* Wherever silence has left it, it is back on the second server as soon as the node answers. */
static void test_after_silence_it_finds_the_second_server(void)
{
    for (uint64_t silent_us = 0; silent_us < 5U * PERIOD_US; silent_us += PERIOD_US / 4U) {
        bench.sdo.silent = true;
        pass(silent_us);
        bench.sdo.silent = false;
        pass(3U * PERIOD_US);
        TEST_ASSERT_EQUAL_UINT8(GATEWAY_LINK_UP, bench.gateway.poller.link_state);
        TEST_ASSERT_TRUE(bench.sdo.is_second);
    }
    TEST_ASSERT_GREATER_THAN_UINT(0, bench.looks);
}

/* A snapshot knows how many commands had their result before its first value was read; nothing of an older poll is in
 * it. */
static void test_what_is_published_after_a_command_has_been_read_after_it(void)
{
    gateway_command_t command = gateway_command(0x2002, 0, NULL, NULL, 1);
    bench.k_xx = 2.0;
    settle();
    TEST_ASSERT_EQUAL_UINT32(0, bench.gateway.poller.published.ended);
    for (uint32_t n = 1; n < 200U; n++) { /* at every place of a poll */
        pass(PERIOD_US);
        bench.fake.now_us += PERIOD_US;
        exchange(n);
        const uint32_t number = bench.gateway.poller.published.number;
        bench.refuse = (n % 3U == 0U) ? NO_DATA : 0U;
        TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &command));
        while (command.result == GATEWAY_RESULT_PENDING) {
            TEST_ASSERT_TRUE(bench.gateway.poller.published.ended < n);
            exchange(1);
        }
        TEST_ASSERT_EQUAL_UINT32(n, command.ended);
        const unsigned reads = bench.reads;
        while (bench.gateway.poller.published.ended != n) {
            pass(PERIOD_US / 10U);
        }
        TEST_ASSERT_GREATER_THAN_UINT32(number, bench.gateway.poller.published.number);
        TEST_ASSERT_GREATER_THAN_UINT(reads + 2U * GATEWAY_MARKS, bench.reads);
    }
}

/* Begun anew too often by commands, a poll goes on in the end; but nobody takes it for one that knows them. */
static void test_a_poll_that_goes_on_does_not_pass_for_a_fresh_one(void)
{
    gateway_command_t command = gateway_command(0x2002, 0, NULL, NULL, 1);
    bench.k_xx = 2.0;
    settle();
    const uint32_t number = bench.gateway.poller.published.number;
    bench.fake.now_us += PERIOD_US;
    exchange(3);
    for (uint32_t n = 1; bench.gateway.poller.published.number == number; n++) {
        TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &command));
        while (command.result == GATEWAY_RESULT_PENDING && bench.gateway.poller.published.number == number) {
            exchange(1);
        }
        TEST_ASSERT_TRUE(n < 5000U);
    }
    TEST_ASSERT_TRUE(bench.gateway.poller.published.ended < command.ended || command.result == GATEWAY_RESULT_PENDING);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(GATEWAY_MAX_ANEW, bench.gateway.poller.published.ended);
    settle();
    TEST_ASSERT_EQUAL_UINT32(command.ended, bench.gateway.poller.published.ended);
}

/* A run that begins while a poll is under way: what is published is of one run. */
static void begin_a_run(void)
{
    give(0x2007, 0, 4, 8);
}

static void test_a_snapshot_is_of_one_run(void)
{
    bench.k_xx = 2.0;
    give(0x2007, 0, 4, 7);
    settle();
    for (unsigned at = 1; at < 60U; at++) {
        give(0x2007, 0, 4, 7);
        pass(2U * PERIOD_US);
        bench.event_at = at;
        bench.event = begin_a_run;
        const uint32_t torn = count(GATEWAY_COUNT_POLLS_TORN);
        pass(PERIOD_US);
        TEST_ASSERT_EQUAL_UINT16(8, bench.gateway.poller.published.words[149]);
        TEST_ASSERT_TRUE(count(GATEWAY_COUNT_POLLS_TORN) - torn <= 1U);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(40, count(GATEWAY_COUNT_POLLS_TORN));
}

static void test_a_bus_that_is_down(void)
{
    bench.fake.send_status = TUMBLE_E_PORT_DOWN;
    bench.fake.receive_status = TUMBLE_E_PORT_DOWN;
    pass(2U * PERIOD_US);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_LINK_DOWN, bench.gateway.poller.link_state);
    bench.fake.send_status = TUMBLE_OK;
    bench.fake.receive_status = TUMBLE_OK;
    pass(2U * PERIOD_US);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_LINK_UP, bench.gateway.poller.link_state);
}

static void test_a_port_without_room_is_asked_again(void)
{
    bench.fake.send_room = 0;
    gateway_poller_step(&bench.gateway.poller);
    TEST_ASSERT_LESS_THAN_UINT64(bench.fake.now_us + 10000U, gateway_poller_next_us(&bench.gateway.poller));
    bench.fake.send_room = SIZE_MAX;
    pass(10000);
    TEST_ASSERT_EQUAL_UINT32(1, bench.gateway.poller.published.number);
}

static const around_t around_each = {bench_set_up, bench_tear_down};
