/* The whole memory after given runs and losses of power, byte for byte: tests/golden/images/kept.bin. */
#include "keeper_bench.h"

#include <stdio.h>

#define IMAGE_BYTES (MEMORY_SECTOR * NV_MAX_SECTORS)

static void live(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_set_utc(&keeper, 1800000000));
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    keeper_power_cycle();
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    ASSERT_STATUS(TUMBLE_OK, accept_proposal());
    settle_and_power_cycle();
    start_and_cut(7);
    resume_to_end();
    assert_verdict_after(-5e-3, TUMBLE_VERDICT_HELD);
    start_and_cut(5);
}

/* To make it anew, copy the kept.bin that a failing test leaves where it runs. */
static void test_the_memory_is_the_golden_one(void)
{
    static uint8_t golden[IMAGE_BYTES];
    live();
    FILE *file = fopen(GOLDEN_IMAGE, "rb");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_EQUAL_size_t(IMAGE_BYTES, fread(golden, 1, sizeof golden, file));
    TEST_ASSERT_EQUAL_INT(0, fclose(file));
    if (memcmp(golden, memory.bytes, sizeof golden) != 0) {
        file = fopen("kept.bin", "wb");
        TEST_ASSERT_EQUAL_size_t(IMAGE_BYTES, fwrite(memory.bytes, 1, IMAGE_BYTES, file));
        TEST_ASSERT_EQUAL_INT(0, fclose(file));
    }
    TEST_ASSERT_EQUAL_MEMORY(golden, memory.bytes, sizeof golden);
}

static const around_t around_each = {keeper_power_on, NULL};
