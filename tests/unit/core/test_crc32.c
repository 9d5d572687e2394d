/* CRC-32 against polynomial division, the published check value, and itself in pieces. */
#include "core/crc32.h"
#include "gain_bench.h"

static void test_known_values(void)
{
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926U, tumble_crc32(0, "123456789", 9));
    TEST_ASSERT_EQUAL_HEX32(0U, tumble_crc32(0, "", 0));
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926U, crc32_by_division((const uint8_t *)"123456789", 9));
}

static void test_any_bytes_in_any_pieces(void)
{
    static uint8_t bytes[300];
    dice_t dice = {40};
    for (int round = 0; round < 500; round++) {
        const size_t size = dice_below(&dice, sizeof bytes + 1U);
        for (size_t i = 0; i < size; i++) {
            bytes[i] = (uint8_t)dice_u64(&dice);
        }
        const size_t first = dice_below(&dice, (uint32_t)size + 1U);
        const uint32_t expected = crc32_by_division(bytes, size);
        TEST_ASSERT_EQUAL_HEX32(expected, tumble_crc32(0, bytes, size));
        TEST_ASSERT_EQUAL_HEX32(expected, tumble_crc32(tumble_crc32(0, bytes, first), bytes + first, size - first));
    }
}
