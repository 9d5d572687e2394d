/* Commands and settings from the gateway to the node: their bytes, order and results, and polls beside them. */
#include "gateway_bench.h"

#include "canopen/dictionary.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

static gateway_command_t command_of(uint8_t number)
{
    return gateway_command(gateway_command_objects[0], 3, NULL, NULL, number);
}

static void assert_written(unsigned place, uint16_t index, uint8_t subindex, uint8_t size, uint64_t bits)
{
    const played_object_t *const one = &bench.writes[place];
    TEST_ASSERT_EQUAL_HEX16(index, one->index);
    TEST_ASSERT_EQUAL_UINT8(subindex, one->subindex);
    TEST_ASSERT_EQUAL_UINT8(size, one->size);
    TEST_ASSERT_EQUAL_HEX64(bits, tumble_get_u64(one->bytes));
}

static uint64_t bits_of(double number)
{
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

static void test_commands(void)
{
    gateway_command_t one = command_of(1);
    const double angle_deg = -12.5;
    const uint32_t proposal = 0xFEDCBA98U;
    gateway_command_t two = gateway_command(gateway_command_objects[0], 4, &angle_deg, &proposal, 2);
    settle();
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &one));
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &two));
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_PENDING, one.result);
    TEST_ASSERT_EQUAL_UINT64(0, gateway_poller_next_us(&bench.gateway.poller));
    settle();
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, one.result);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, two.result);
    TEST_ASSERT_EQUAL_UINT(6, bench.written);
    assert_written(0, 0x2002U, 1, 1, 3);
    assert_written(1, 0x2002U, 2, 1, 1);
    assert_written(2, 0x2002U, 1, 1, 4);
    assert_written(3, 0x2002U, 3, 8, bits_of(angle_deg));
    assert_written(4, 0x2002U, 4, 4, proposal);
    assert_written(5, 0x2002U, 2, 1, 2);
    TEST_ASSERT_EQUAL_UINT32(2, bench.gateway.poller.published.number); /* what they changed is read at once */
}

static void test_a_refused_argument_ends_the_command(void)
{
    gateway_command_t command = command_of(1);
    settle();
    bench.refuse = 0x06090030U;
    carry_out(&command);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_REFUSED, command.result);
    TEST_ASSERT_EQUAL_HEX32(0x06090030U, command.abort);
    TEST_ASSERT_EQUAL_UINT(1, bench.written);
}

static void test_a_command_in_the_middle_of_a_poll(void)
{
    gateway_command_t command = command_of(1);
    bench.k_xx = 1.0;
    exchange(40);
    carry_out(&command);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, command.result);
    TEST_ASSERT_EQUAL_UINT32(1, bench.gateway.poller.published.number); /* begun anew */
    TEST_ASSERT_EQUAL_UINT32(0, count(GATEWAY_COUNT_POLLS_TORN));
}

/* Who commands without end does not keep others from snapshots. */
static void test_polls_between_commands_without_end(void)
{
    gateway_command_t command = command_of(1);
    for (int i = 0; i < 20000; i++) {
        if (command.result != GATEWAY_RESULT_PENDING) {
            TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &command));
        }
        exchange(10);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(20, bench.gateway.poller.published.number);
}

/* Nor do two by turns, of whom one always waits; whether or not they are obeyed. */
static void test_polls_between_commands_of_two_without_end(void)
{
    gateway_command_t commands[] = {command_of(1), gateway_setting(gateway_target(101), 0, 3.0)};
    for (int i = 0; i < 40000; i++) {
        gateway_command_t *const command = &commands[i % 2];
        if (command->result != GATEWAY_RESULT_PENDING) {
            TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, command));
        }
        bench.refuse = (i < 20000) ? 0U : 0x08000022U;
        exchange(1);
        if (i == 20000) {
            TEST_ASSERT_GREATER_THAN_UINT32(5, bench.gateway.poller.published.number);
            bench.gateway.poller.published.number = 0;
        }
        bench.fake.now_us += 1000U;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(5, bench.gateway.poller.published.number);
}

static void test_a_command_without_an_answer(void)
{
    gateway_command_t command = command_of(1);
    gateway_command_t forgotten = command_of(2);
    settle();
    bench.sdo.silent = true;
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &command));
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &forgotten));
    gateway_queue_forget(&bench.gateway.poller.queue, &forgotten);
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
        TEST_ASSERT_EQUAL_INT(i < GATEWAY_MAX_SESSIONS, gateway_queue_add(&bench.gateway.poller.queue, &commands[i]));
    }
    settle();
    TEST_ASSERT_EQUAL_UINT32(GATEWAY_MAX_SESSIONS, count(GATEWAY_COUNT_COMMANDS_SENT));
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_NONE, commands[GATEWAY_MAX_SESSIONS].result);
}

/* Settings. */

typedef struct {
    uint8_t type;
    double number;
    uint8_t size; /* 0: it cannot hold it */
    uint64_t bits;
} number_t;

#define U8 TUMBLE_TYPE_UNSIGNED8
#define U16 TUMBLE_TYPE_UNSIGNED16
#define U32 TUMBLE_TYPE_UNSIGNED32
#define U64 TUMBLE_TYPE_UNSIGNED64
#define I8 TUMBLE_TYPE_INTEGER8
#define I16 TUMBLE_TYPE_INTEGER16
#define I32 TUMBLE_TYPE_INTEGER32
#define I64 TUMBLE_TYPE_INTEGER64
#define F32 TUMBLE_TYPE_REAL32
#define F64 TUMBLE_TYPE_REAL64

static void test_every_type_has_its_bytes(void)
{
    const number_t numbers[] = {
        {U8, 0.0, 1, 0},
        {U8, -0.0, 1, 0},
        {U8, 255.0, 1, 0xFF},
        {U8, 256.0, 0, 0},
        {U8, -1.0, 0, 0},
        {U8, 0.5, 0, 0},
        {U16, 65535.0, 2, 0xFFFF},
        {U16, 65536.0, 0, 0},
        {U16, 258.0, 2, 0x0102},
        {U16, 1e-300, 0, 0},
        {U32, 4294967295.0, 4, 0xFFFFFFFF},
        {U32, 4294967296.0, 0, 0},
        {U32, 0x65766173, 4, 0x65766173},
        {U32, 4294967294.5, 0, 0},
        {U32, -1.0, 0, 0},
        {U64, 0x1p40, 8, 0x10000000000},
        {U64, 1795000000.0, 8, 1795000000},
        {U64, 0x1.fffffffffffffp63, 8, 0xFFFFFFFFFFFFF800},
        {U64, 0x1p64, 0, 0},
        {U64, -1.0, 0, 0},
        {U64, 0x1p52 - 0.5, 0, 0},
        {I8, -128.0, 1, 0x80},
        {I8, -129.0, 0, 0},
        {I8, 127.0, 1, 0x7F},
        {I8, 128.0, 0, 0},
        {I8, -0.5, 0, 0},
        {I16, -32768.0, 2, 0x8000},
        {I16, 32768.0, 0, 0},
        {I16, -32769.0, 0, 0},
        {I32, -2147483648.0, 4, 0x80000000},
        {I32, 2147483647.0, 4, 0x7FFFFFFF},
        {I32, 2147483648.0, 0, 0},
        {I64, -0x1p63, 8, 0x8000000000000000},
        {I64, 0x1p63, 0, 0},
        {I64, -1.0, 8, UINT64_MAX},
        {F32, 0.1, 4, 0x3DCCCCCD},
        {F32, -0.0, 4, 0x80000000},
        {F32, (double)FLT_MAX, 4, 0x7F7FFFFF},
        {F32, 0x1.fffffefp127, 0, 0},
        {F32, -1e39, 0, 0},
        {F32, (double)FLT_MIN, 4, 0x00800000},
        {F32, 1e-38, 0, 0},
        {F64, 0.1, 8, 0x3FB999999999999A},
        {F64, -DBL_MAX, 8, 0xFFEFFFFFFFFFFFFF},
        {F64, 4.9406564584124654e-324, 8, 1},
        {TUMBLE_TYPE_BOOLEAN, 1.0, 0, 0},
        {TUMBLE_TYPE_VISIBLE_STRING, 1.0, 0, 0},
    };
    for (size_t i = 0; i < COUNT_OF(numbers); i++) {
        uint8_t bytes[GATEWAY_NUMBER_BYTES] = {0};
        const uint64_t mask = (numbers[i].size == 8U) ? UINT64_MAX : (UINT64_C(1) << 8U * numbers[i].size) - 1U;
        char which[32];
        (void)snprintf(which, sizeof which, "type %u, %g", numbers[i].type, numbers[i].number);
        const uint8_t size = gateway_number_bytes(numbers[i].type, numbers[i].number, bytes);
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(numbers[i].size, size, which);
        TEST_ASSERT_EQUAL_HEX64_MESSAGE(numbers[i].bits, tumble_get_u64(bytes) & mask, which);
    }
}

static void test_no_type_holds_what_is_not_finite(void)
{
    const double numbers[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    const uint8_t types[] = {U8, U16, U32, U64, I8, I16, I32, I64, F32, F64};
    uint8_t bytes[GATEWAY_NUMBER_BYTES];
    for (size_t i = 0; i < COUNT_OF(numbers) * COUNT_OF(types); i++) {
        const uint8_t type = types[i % COUNT_OF(types)];
        TEST_ASSERT_EQUAL_UINT8(0, gateway_number_bytes(type, numbers[i / COUNT_OF(types)], bytes));
    }
}

static void test_every_setting_is_written_as_its_object_is(void)
{
    settle();
    for (uint32_t number = 0; number <= UINT16_MAX; number++) {
        const gateway_target_t target = gateway_target((uint16_t)number);
        if (target.number == 0U) {
            continue;
        }
        TEST_ASSERT_EQUAL_UINT16(number, target.number);
        gateway_command_t setting = gateway_setting(target, 0, 7.0);
        bench.written = 0;
        carry_out(&setting);
        TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, setting.result);
        TEST_ASSERT_EQUAL_UINT(1, bench.written);
        const uint64_t bits = (target.type == F64) ? bits_of(7.0) : (target.type == F32) ? 0x40E00000U : 7U;
        assert_written(0, target.index, target.subindex, target.size, bits);
    }
    TEST_ASSERT_EQUAL_UINT32(GATEWAY_TARGETS, count(GATEWAY_COUNT_COMMANDS_SENT));
}

/* A key goes before it, and a refused key keeps it back. */
static void test_a_setting_behind_its_key(void)
{
    const uint32_t key = 0x76726573U;
    gateway_command_t setting = gateway_setting(gateway_target(5), key, 3e-4);
    settle();
    carry_out(&setting);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, setting.result);
    TEST_ASSERT_EQUAL_UINT(2, bench.written);
    assert_written(0, 0x2006U, 1, 4, key);
    assert_written(1, 0x2050U, 5, 8, bits_of(3e-4));
    bench.refuse = 0x08000022U;
    carry_out(&setting);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_REFUSED, setting.result);
    TEST_ASSERT_EQUAL_UINT(3, bench.written); /* the key once more, and nothing behind it */
    TEST_ASSERT_EQUAL_HEX16(0x2006, last_write()->index);
}

/* What ends the service level waits behind the commands, however many, and is not sent when it is to be kept. */
static void test_the_end_of_the_service_level(void)
{
    static gateway_command_t commands[GATEWAY_MAX_SESSIONS];
    settle();
    for (size_t i = 0; i < GATEWAY_MAX_SESSIONS; i++) {
        commands[i] = command_of(1);
        TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &commands[i]));
    }
    bench.gateway.poller.queue.ends_service = true;
    TEST_ASSERT_EQUAL_UINT64(0, gateway_poller_next_us(&bench.gateway.poller));
    bench.written = 0;
    settle();
    TEST_ASSERT_EQUAL_UINT(2U * GATEWAY_MAX_SESSIONS + 1U, bench.written);
    TEST_ASSERT_EQUAL_HEX16(0x2006, last_write()->index);
    TEST_ASSERT_EQUAL_HEX32(0, tumble_get_u32(last_write()->bytes));
    TEST_ASSERT_EQUAL_UINT32(GATEWAY_MAX_SESSIONS + 1U, count(GATEWAY_COUNT_COMMANDS_SENT));
    bench.written = 0;
    bench.gateway.poller.queue.ends_service = true;
    bench.gateway.poller.queue.ends_service = false;
    settle();
    TEST_ASSERT_EQUAL_UINT(0, bench.written);
}

static void test_a_setting_that_is_refused_or_not_answered(void)
{
    gateway_command_t setting = gateway_setting(gateway_target(11), 0, 1.0);
    settle();
    bench.refuse = 0x06020000U;
    carry_out(&setting);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_REFUSED, setting.result);
    TEST_ASSERT_EQUAL_HEX32(0x06020000U, setting.abort);
    bench.sdo.silent = true;
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &setting));
    pass(TUMBLE_SDO_CLIENT_TIMEOUT_US + 10U);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_UNANSWERED, setting.result);
    TEST_ASSERT_EQUAL_HEX32(0, setting.abort);
    bench.sdo.silent = false;
    bench.refuse = 0;
    carry_out(&setting);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, setting.result);
}

/* The second part is not sent once more, nor taken for the first of the next. */
static void test_a_command_refused_in_its_last_part_leaves_the_next_one_whole(void)
{
    gateway_command_t one = command_of(1);
    gateway_command_t two = command_of(2);
    settle();
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &one));
    TEST_ASSERT_TRUE(gateway_queue_add(&bench.gateway.poller.queue, &two));
    while (bench.written < 1U) {
        exchange(1);
    }
    bench.refuse = 0x08000022U;
    while (one.result == GATEWAY_RESULT_PENDING) {
        gateway_poller_step(&bench.gateway.poller);
        bench.refuse = (one.result == GATEWAY_RESULT_PENDING) ? bench.refuse : 0U;
        (void)serve();
    }
    settle();
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_REFUSED, one.result);
    TEST_ASSERT_EQUAL_UINT8(GATEWAY_RESULT_ACCEPTED, two.result);
    TEST_ASSERT_EQUAL_UINT(4, bench.written);
    assert_written(2, 0x2002U, 1, 1, 3);
    assert_written(3, 0x2002U, 2, 1, 2);
}

static const around_t around_each = {bench_set_up, bench_tear_down};
