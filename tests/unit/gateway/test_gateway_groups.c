/* Values that the gateway reads anew in groups: a key of theirs has changed, or a setting of theirs was written. */
#include "gateway_bench.h"

#define POSITION 0x2150U
#define SCHEDULE 0x2151U
#define AT_REST 0x2152U
#define LIMITS 0x2123U
#define SETTING_POSITION 101U
#define SETTING_AT_REST 111U
#define SETTING_COVERAGE 31U
#define REGISTER_PROGRESS 121U
#define REGISTER_INDEX 961U
#define REGISTER_MEAN_Y 966U /* a REAL32 */
#define REGISTER_MOUNTING 1002U
#define REGISTER_TAKEN 1012U
#define REGISTER_MEAN_AT_REST_Z 1017U
#define REGISTER_SPOILT 1025U

/* The node has selected a position: all that it says of it has to do with its number. */
static void select_position(uint8_t index)
{
    give(POSITION, 1, 1, index);
    give(POSITION, 2, 4, 1000);
    for (uint8_t sub = 3; sub <= 8U; sub++) {
        give_f64(POSITION, sub, (double)index);
    }
    give(SCHEDULE, 2, 1, index);
}

static void take_selection(void)
{
    if (last_write()->index == POSITION) {
        select_position(last_write()->bytes[0]);
    }
}

static void select_another(void)
{
    select_position(2);
}

static void set_up(void)
{
    bench_set_up();
    bench.k_xx = 2.0;
    bench.on_write = take_selection;
    select_position(1);
}

static uint16_t word(uint16_t at)
{
    return bench.gateway.poller.published.words[at];
}

static float real(uint16_t at)
{
    uint8_t bytes[4];
    tumble_put_u32(bytes, (uint32_t)word(at) << 16 | word((uint16_t)(at + 1U)));
    return tumble_get_f32(bytes);
}

/* Of the position that is selected, or of none. */
static void assert_whole(void)
{
    if (bench.gateway.poller.published.number > 0U) {
        TEST_ASSERT_EQUAL_FLOAT((float)word(REGISTER_INDEX), real(REGISTER_MEAN_Y));
        TEST_ASSERT_EQUAL_UINT16(word(REGISTER_INDEX), word(REGISTER_MOUNTING));
    }
}

static void settle_whole(void)
{
    do {
        gateway_poller_step(&bench.gateway.poller);
        assert_whole();
    } while (serve());
    assert_whole();
}

/* Reads of a poll. */
static unsigned next_poll(void)
{
    const unsigned before = bench.reads;
    pass(PERIOD_US);
    return bench.reads - before;
}

/* Objects of a group that are not its keys, and its selector once more. */
static unsigned rest_of(uint8_t group)
{
    unsigned objects = (gateway_selectors[group] < GATEWAY_KEYS) ? 1U : 0U;
    for (size_t i = 0; i < GATEWAY_VALUES; i++) {
        const gateway_value_t value = gateway_value(i);
        objects += (value.group == group && value.key == GATEWAY_KEYS) ? 1U : 0U;
    }
    return objects;
}

static uint8_t group_of(size_t key)
{
    size_t i = 0;
    while (gateway_value(i).key != key) {
        i++;
    }
    return gateway_value(i).group;
}

static void test_every_key_has_its_group_read_anew_and_no_other(void)
{
    settle();
    const unsigned few = next_poll();
    for (size_t i = 0; i < GATEWAY_KEYS; i++) {
        const gateway_object_t *const key = &gateway_tells[GATEWAY_MARKS + i];
        give(key->index, key->subindex, key->size, 0x3FF1000000000000U + i);
        TEST_ASSERT_EQUAL_UINT(few + rest_of(group_of(i)), next_poll());
        TEST_ASSERT_EQUAL_UINT(few, next_poll());
        give(key->index, key->subindex, 0, 0); /* refused is another, too */
        TEST_ASSERT_EQUAL_UINT(few + rest_of(group_of(i)), next_poll());
        TEST_ASSERT_EQUAL_UINT(few, next_poll());
    }
    TEST_ASSERT_EQUAL_UINT32(0, count(GATEWAY_COUNT_POLLS_TORN));
}

/* The bytes count, not what the registers can show of them. */
static void test_a_key_that_changes_in_its_last_bit(void)
{
    settle();
    give_f64(POSITION, 3, 1.0 + 0x1p-52);
    give_f64(POSITION, 4, 7.0);
    pass(PERIOD_US);
    TEST_ASSERT_EQUAL_FLOAT(7.0F, real(REGISTER_MEAN_Y));
}

static void test_a_position_that_is_measured_meanwhile(void)
{
    give(POSITION, 2, 0, 0);
    give(POSITION, 3, 0, 0);
    give(POSITION, 4, 0, 0);
    settle();
    TEST_ASSERT_EQUAL_HEX16(0x00F1U, word(960)); /* of the eight values; the test leaves out those of x and y */
    TEST_ASSERT_EQUAL_HEX16(0, word(REGISTER_MEAN_Y));
    select_position(1);
    pass(PERIOD_US);
    TEST_ASSERT_EQUAL_HEX16(0x00FFU, word(960));
    TEST_ASSERT_EQUAL_FLOAT(1.0F, real(REGISTER_MEAN_Y));
}

/* At each moment of a poll. */
static void test_a_selection_over_modbus_is_in_the_next_snapshot_and_in_no_mixture(void)
{
    for (unsigned steps = 0; steps < 2000U; steps += 3U) {
        set_up();
        settle();
        pass(PERIOD_US - 1U);
        bench.fake.now_us++;
        bool is_over = false;
        for (unsigned i = 0; i < steps && !is_over; i++) {
            exchange(1);
            is_over = gateway_poller_next_us(&bench.gateway.poller) == bench.gateway.poller.next_us;
        }
        gateway_command_t command = gateway_setting(gateway_target(SETTING_POSITION), 0, 3.0);
        TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &command));
        settle_whole();
        TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, command.result);
        TEST_ASSERT_EQUAL_UINT16(3, word(REGISTER_INDEX));
        TEST_ASSERT_EQUAL_UINT32(0, count(GATEWAY_COUNT_POLLS_TORN));
    }
}

/* Another client on the bus, at each read of a poll that reads all, and of one that does not. */
static void test_a_selection_by_others_at_any_read_is_no_mixture(void)
{
    settle();
    const unsigned all = bench.reads;
    const unsigned few = next_poll();
    for (unsigned at = 1; at <= all + few; at++) {
        set_up();
        bench.event = select_another;
        bench.event_at = at;
        settle_whole();
        bench.fake.now_us += PERIOD_US;
        settle_whole();
        bench.fake.now_us += PERIOD_US;
        settle_whole();
        TEST_ASSERT_EQUAL_UINT16(2, word(REGISTER_INDEX));
    }
}

/* Samples, means and what was spoilt are as they are now, without all being read. */
static void test_a_measurement_at_rest_is_seen_poll_by_poll(void)
{
    give(AT_REST, 1, 2, 300);
    settle();
    const unsigned few = next_poll();
    for (uint16_t taken = 100; taken < 300U; taken = (uint16_t)(taken + 100U)) {
        give(AT_REST, 2, 2, taken);
        give(AT_REST, 9, 2, taken / 100U);
        TEST_ASSERT_LESS_THAN_UINT(few + 10U, next_poll());
        TEST_ASSERT_EQUAL_UINT16(taken, word(REGISTER_TAKEN));
        TEST_ASSERT_EQUAL_UINT16(taken / 100U, word(REGISTER_SPOILT));
        TEST_ASSERT_EQUAL_HEX16(0x0103U, word(1010));
    }
    give(AT_REST, 9, 2, 5); /* spoilt alone */
    (void)next_poll();
    TEST_ASSERT_EQUAL_UINT16(5, word(REGISTER_SPOILT));
    give(AT_REST, 2, 2, 300);
    give_f64(AT_REST, 3, 0.25);
    give_f64(AT_REST, 5, 0.5);
    TEST_ASSERT_LESS_THAN_UINT(few + 10U, next_poll());
    TEST_ASSERT_EQUAL_UINT16(300, word(REGISTER_TAKEN));
    TEST_ASSERT_EQUAL_FLOAT(0.5F, real(REGISTER_MEAN_AT_REST_Z));
    TEST_ASSERT_EQUAL_UINT(few, next_poll());
}

/* Begun anew with the same number, and over before the next poll. */
static void test_a_measurement_that_no_poll_has_seen(void)
{
    give(AT_REST, 1, 2, 2);
    give(AT_REST, 2, 2, 2);
    give_f64(AT_REST, 3, 0.25);
    give_f64(AT_REST, 5, 0.5);
    settle();
    gateway_command_t command = gateway_setting(gateway_target(SETTING_AT_REST), 0, 2.0);
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &command));
    give_f64(AT_REST, 5, 0.75); /* x is as before to the last bit */
    settle();
    TEST_ASSERT_EQUAL_FLOAT(0.75F, real(REGISTER_MEAN_AT_REST_Z));
}

/* From 2 to 3, as the node has it already: what tells of it is to be given. */
static gateway_command_t raise_coverage(void)
{
    give(LIMITS, 1, 4, 0x40000000U);
    settle();
    give(LIMITS, 1, 4, 0x40400000U);
    return gateway_setting(gateway_target(SETTING_COVERAGE), 0, 3.0);
}

static void test_settings_written_here_are_read_back_and_what_others_write_later(void)
{
    gateway_command_t command = raise_coverage();
    const unsigned few = next_poll();
    TEST_ASSERT_EQUAL_HEX16(0x4000U, word(1151)); /* nothing told of it */
    carry_out(&command);
    TEST_ASSERT_EQUAL_HEX16(0x4040U, word(1151));
    TEST_ASSERT_EQUAL_UINT(few, next_poll());
    give(LIMITS, 1, 4, 0x40800000U);
    for (unsigned i = 0; i <= GATEWAY_KEPT_POLLS; i++) {
        pass(PERIOD_US);
    }
    TEST_ASSERT_EQUAL_HEX16(0x4080U, word(1151));
}

/* What a refused setting would change is not asked for. */
static void test_a_refused_setting_changes_nothing(void)
{
    settle();
    const unsigned few = next_poll();
    gateway_command_t command = gateway_setting(gateway_target(SETTING_COVERAGE), 0, 3.0);
    bench.refuse = 0x08000022U;
    carry_out(&command);
    TEST_ASSERT_EQUAL_UINT(few, next_poll());
}

/* The node may have taken it: what was disturbed is the answer. */
static void test_a_setting_whose_answer_was_disturbed_is_read_back(void)
{
    gateway_command_t command = raise_coverage();
    bench.refuse = 0x05040001U;
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &command));
    (void)next_poll();
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_REFUSED, command.result);
    TEST_ASSERT_EQUAL_HEX16(0x4040U, word(1151));
}

static void command_in_a_poll(gateway_command_t *command)
{
    exchange(1);
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, command));
    while (command->result == GATEWAY_RESULT_PENDING) {
        exchange(1);
    }
}

static void show_position(void)
{
    give(0x2003U, 1, 1, 7);
}

/* How often one that was given up has begun anew says nothing of the next one. */
static void test_a_poll_after_silence_begins_anew_for_a_setting(void)
{
    gateway_command_t command = gateway_setting(gateway_target(SETTING_COVERAGE), 0, 3.0);
    for (unsigned i = 0; i < GATEWAY_MAX_ANEW; i++) {
        command_in_a_poll(&command);
    }
    bench.sdo.silent = true;
    pass(TUMBLE_SDO_CLIENT_TIMEOUT_US + 10U);
    TEST_ASSERT_EQUAL_UINT32(1, count(GATEWAY_COUNT_POLLS_FAILED));
    bench.sdo.silent = false;
    bench.fake.now_us = bench.gateway.poller.next_us;
    for (const unsigned before = bench.reads; bench.reads < before + 100U;) {
        exchange(1);
    }
    bench.on_write = show_position;
    command_in_a_poll(&command);
    while (bench.gateway.poller.published.number == 0U) {
        exchange(1);
    }
    TEST_ASSERT_EQUAL_UINT16(7, word(REGISTER_PROGRESS));
}

/* A poll that is given up has not read what was written before it. */
static void test_what_was_written_is_read_although_a_poll_fails(void)
{
    gateway_command_t command = raise_coverage();
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &command));
    exchange(20);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, command.result);
    bench.abort_next = 0x05040000U; /* torn */
    settle();
    TEST_ASSERT_EQUAL_UINT32(1, count(GATEWAY_COUNT_POLLS_TORN));
    TEST_ASSERT_EQUAL_HEX16(0x4040U, word(1151));
}

static const around_t around_each = {set_up, bench_tear_down};
