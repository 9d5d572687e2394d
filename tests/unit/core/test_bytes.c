/* Little-endian packing: the same bytes whichever way the machine makes them (core/bytes.h); a program of its own tests the
 * way of a machine whose byte order is not known. */
#include "core/bytes.h"
#include "support.h"

static const uint8_t eight[] = {0xFF, 0x01, 0x02, 0x03, 0x84, 0x05, 0x06, 0x07, 0x88}; /* from an odd place on */

static void test_numbers_are_read(void)
{
    TEST_ASSERT_EQUAL_HEX16(0x0201, tumble_get_u16(&eight[1]));
    TEST_ASSERT_EQUAL_HEX32(0x84030201, tumble_get_u32(&eight[1]));
    TEST_ASSERT_TRUE(tumble_get_u64(&eight[1]) == UINT64_C(0x8807060584030201));
    TEST_ASSERT_TRUE(tumble_get_i32(&eight[1]) == -0x7BFCFDFF);
}

static void test_numbers_are_written(void)
{
    uint8_t bytes[sizeof eight];
    memset(bytes, 0xFF, sizeof bytes);
    tumble_put_u16(&bytes[1], 0x0201);
    TEST_ASSERT_EQUAL_MEMORY(eight, bytes, 3);
    TEST_ASSERT_EQUAL_HEX8(0xFF, bytes[3]);
    tumble_put_u32(&bytes[1], 0x84030201);
    TEST_ASSERT_EQUAL_MEMORY(eight, bytes, 5);
    TEST_ASSERT_EQUAL_HEX8(0xFF, bytes[5]);
    tumble_put_u64(&bytes[1], UINT64_C(0x8807060584030201));
    TEST_ASSERT_EQUAL_MEMORY(eight, bytes, sizeof bytes);
}

static void test_numbers_are_copied(void)
{
    const uint32_t machine[] = {0x84030201, 0x88070605};
    uint32_t back[2];
    uint8_t bytes[8];
    tumble_copy_numbers(bytes, (const uint8_t *)machine, 4, 2);
    TEST_ASSERT_EQUAL_MEMORY(&eight[1], bytes, sizeof bytes);
    tumble_copy_numbers((uint8_t *)back, bytes, 4, 2);
    TEST_ASSERT_EQUAL_MEMORY(machine, back, sizeof back);
}
