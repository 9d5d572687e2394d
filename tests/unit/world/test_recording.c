/* The bytes of a recording, and what is refused as one. */
#include "replay/replay.h"
#include "suite.h"

#include <string.h>

#define RECORDS 3U

static uint8_t recording[REPLAY_HEADER_BYTES + RECORDS * REPLAY_RECORD_BYTES];
static replay_t replay;

static void put(uint32_t number, uint64_t time_us, uint16_t id)
{
    const replay_record_t record = {time_us, {.id = id, .length = 3, .data = {1, 2, 3}}};
    replay_put_record(&record, &recording[REPLAY_HEADER_BYTES + number * REPLAY_RECORD_BYTES]);
}

static void set_up(void)
{
    put(0, 0, 0x702);
    put(1, 10, 0x683);
    put(2, 10, 0x693);
    replay_put_header(recording, RECORDS);
}

/* Written out by hand: a recording is the same on every machine. */
static void test_the_bytes(void)
{
    static const uint8_t RECORD[REPLAY_RECORD_BYTES] = {0xEF, 0xCD, 0xAB, 0x89, 0x67, 0x45, 0x23, 0x01, 0x83, 0x06,
                                                        4,    0,    0xDE, 0xAD, 0xBE, 0xEF, 0,    0,    0,    0};
    static const uint8_t EMPTY[REPLAY_HEADER_BYTES] = {'T', 'U', 'M', 'B', 'L',  'E',  'L',  'G',
                                                       0,   0,   0,   0,   0xC5, 0x9D, 0x1C, 0x81}; /* FNV's basis */
    const replay_record_t record = {0x0123456789ABCDEF, {.id = 0x683, .length = 4, .data = {0xDE, 0xAD, 0xBE, 0xEF}}};
    uint8_t bytes[REPLAY_RECORD_BYTES];
    replay_record_t back;
    replay_put_record(&record, bytes);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(RECORD, bytes, sizeof bytes);
    replay_get_record(bytes, &back);
    TEST_ASSERT_TRUE(back.time_us == record.time_us && back.frame.id == 0x683U && back.frame.length == 4U);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(record.frame.data, back.frame.data, 8);
    replay_put_header(recording, 0);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(EMPTY, recording, sizeof EMPTY);
}

static void test_a_whole_one_is_taken(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, replay_open(&replay, recording, sizeof recording));
    TEST_ASSERT_EQUAL_UINT32(RECORDS, replay.count);
}

/* Memory behind it may hold anything: the loader says only where it begins. */
static void test_what_is_not_whole_is_refused(void)
{
    for (size_t size = 0; size < sizeof recording; size++) {
        TEST_ASSERT_EQUAL(TUMBLE_E_FRAME, replay_open(&replay, recording, size));
    }
}

static void test_every_wrong_bit_is_refused(void)
{
    for (size_t bit = 0; bit < 8U * sizeof recording; bit++) {
        recording[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_NOT_EQUAL(TUMBLE_OK, replay_open(&replay, recording, sizeof recording));
        recording[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    TEST_ASSERT_EQUAL(TUMBLE_OK, replay_open(&replay, recording, sizeof recording));
}

static void test_times_that_fall_are_refused(void)
{
    put(2, 9, 0x693);
    replay_put_header(recording, RECORDS);
    TEST_ASSERT_EQUAL(TUMBLE_E_FRAME, replay_open(&replay, recording, sizeof recording));
}

static const around_t around_each = {set_up, NULL};
