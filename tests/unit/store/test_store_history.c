/* The history undisturbed: order, room, bytes, refusals. Disturbed: test_store_power.c. */
#include "sets/record.h"
#include "store_logs.h"
#include "support.h"

#include <float.h>

static nv_memory_t memory;

static void set_up(void)
{
    nv_make(&memory, TUMBLE_REGION_COUNT, 8, 4096);
    TEST_ASSERT_TRUE(history_boot(&memory));
}

static void tear_down(void)
{
    TEST_ASSERT_EQUAL_UINT(0, memory.violations);
}

static void test_the_last_ones_are_there_newest_first(void)
{
    for (uint32_t n = 1; n <= 200U; n++) {
        const uint32_t count = (n <= 64U) ? n : 33U + (n - 1U) % 32U;
        assert_status(TUMBLE_OK, append_entry(n));
        TEST_ASSERT_EQUAL_UINT32(n, tumble_history_sequence(&logs_history));
        if (n % 7U == 0U) {
            TEST_ASSERT_TRUE(history_boot(&memory));
        }
        TEST_ASSERT_EQUAL_UINT8(count, tumble_history_count(&logs_history));
        for (uint8_t age = 0; age < count; age++) {
            TEST_ASSERT_EQUAL_UINT32(n - age, sequence_at(age));
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0, logs_history.cells.torn);
}

static void test_the_entry_of_a_set(void)
{
    tumble_set_t set = set_of(5);
    tumble_history_entry_t entry;
    assert_status(TUMBLE_OK, tumble_history_from_set(&set, &entry));
    TEST_ASSERT_TRUE((double)entry.value[5] == (double)(float)set.coefficients.k_v_per_g[1][2]);
    TEST_ASSERT_TRUE((double)entry.value[10] == (double)(float)set.coefficients.u0_v[1]);
    TEST_ASSERT_TRUE((double)entry.u[3] == (double)(float)set.uncertainty.k_v_per_g[1][0]);
    TEST_ASSERT_TRUE((double)entry.u[11] == (double)(float)set.uncertainty.u0_v[2]);
    TEST_ASSERT_EQUAL_UINT32(77, entry.sequence);
    TEST_ASSERT_EQUAL_UINT64(set.date_utc_s, entry.date_utc_s);
    set.flags = 0;
    set.temperature_c = NOT_A_NUMBER;
    set.uncertainty.u0_v[0] = NOT_A_NUMBER;
    assert_status(TUMBLE_OK, tumble_history_from_set(&set, &entry));
    TEST_ASSERT_TRUE(entry.temperature_c == 0.0F && entry.u[3] == 0.0F);
    set.coefficients.u0_v[1] = 2.0 * (double)FLT_MAX;
    assert_status(TUMBLE_E_NOT_FINITE, tumble_history_from_set(&set, &entry));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_from_set(NULL, &entry));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_from_set(&set, NULL));
}

static void test_bytes_are_refused_that_are_no_entry(void)
{
    uint8_t bytes[TUMBLE_HISTORY_BYTES];
    tumble_history_entry_t entry = entry_of(9);
    tumble_history_entry_t read = {0};
    assert_status(TUMBLE_OK, tumble_history_encode(&entry, bytes));
    for (unsigned bit = 0; bit < 8U * sizeof bytes; bit++) {
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        assert_status((bit < 32U) ? TUMBLE_E_FRAME : TUMBLE_E_CRC, tumble_history_decode(bytes, &read));
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    assert_status(TUMBLE_OK, tumble_history_decode(bytes, &read));
    memset(&bytes[28], 0xFF, 4);
    tumble_history_number(bytes, 1);
    assert_status(TUMBLE_E_NOT_FINITE, tumble_history_decode(bytes, &read));
    entry.u[11] = (float)INFINITE;
    assert_status(TUMBLE_E_NOT_FINITE, tumble_history_encode(&entry, bytes));
    assert_status(TUMBLE_E_NOT_FINITE, tumble_history_append(&logs_history, &entry));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_append(&logs_history, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_encode(&entry, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_decode(NULL, &entry));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_decode(bytes, NULL));
}

static void test_what_is_not_there_is_refused(void)
{
    tumble_history_entry_t entry = entry_of(1);
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_read(&logs_history, 0, &entry));
    assert_status(TUMBLE_OK, append_entry(1));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_read(&logs_history, 1, &entry));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_read(&logs_history, 0, NULL));
    assert_status(TUMBLE_OK, tumble_history_append(&logs_history, &entry));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_history_append(&logs_history, &entry));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_history_read(&logs_history, 0, &entry));
    TEST_ASSERT_EQUAL_UINT8(0, tumble_history_count(&logs_history));
    TEST_ASSERT_TRUE(history_settles());
    TEST_ASSERT_EQUAL_UINT8(2, tumble_history_count(&logs_history));
    memory.bytes[4U * 4096U + 128U + 50U] ^= 1U;
    assert_status(TUMBLE_E_CRC, tumble_history_read(&logs_history, 0, &entry));
    assert_status(TUMBLE_E_ARGUMENT, tumble_history_init(NULL, &memory.nv));
    memory.nv.sector_bytes = 2048;
    assert_status(TUMBLE_E_NV, tumble_history_init(&logs_history, &memory.nv));
    assert_status(TUMBLE_E_STATE, tumble_history_step(&logs_history));
    assert_status(TUMBLE_E_STATE, tumble_history_append(&logs_history, &entry));
}

static void test_numbers_do_not_wrap(void)
{
    assert_status(TUMBLE_OK, append_entry(1));
    tumble_history_number(&memory.bytes[4U * 4096U], UINT32_MAX - 1U);
    TEST_ASSERT_TRUE(history_boot(&memory));
    assert_status(TUMBLE_E_STATE, append_entry(2));
}

static void test_failures_and_torn_cells_are_counted(void)
{
    nv_arm(&memory, (nv_fault_t){0, DONE_HALF, THEN_SILENT});
    assert_status(TUMBLE_E_NV, append_entry(1));
    nv_arm(&memory, (nv_fault_t){0, DONE_HALF, THEN_ERROR});
    assert_status(TUMBLE_E_NV, append_entry(1));
    TEST_ASSERT_EQUAL_UINT32(1, logs_history.cells.verify);
    TEST_ASSERT_EQUAL_UINT32(1, logs_history.cells.nv_errors);
    TEST_ASSERT_EQUAL_UINT32(0, logs_history.cells.torn);
    assert_status(TUMBLE_OK, append_entry(1));
    TEST_ASSERT_EQUAL_UINT8(1, tumble_history_count(&logs_history));
    memory.read_fails_at = memory.reads + 2U;
    memory.read_fails = 1;
    TEST_ASSERT_TRUE(history_boot(&memory));
    TEST_ASSERT_EQUAL_UINT32(3, logs_history.cells.torn);
    TEST_ASSERT_EQUAL_UINT32(1, logs_history.cells.nv_errors);
    memory.busy_each = 2;
    TEST_ASSERT_TRUE(history_boot(&memory));
    assert_status(TUMBLE_OK, append_entry(2));
}

/* What could not be read may be the newest entry, and an erase would take it: it is looked for again first. */
static void test_nothing_is_written_beside_what_could_not_be_read(void)
{
    static uint8_t before[sizeof memory.bytes];
    for (uint32_t unread = 1; unread < 2U * TUMBLE_HISTORY_CELLS; unread++) {
        set_up();
        for (uint32_t n = 1; n <= 64U; n++) {
            assert_status(TUMBLE_OK, append_entry(n));
        }
        memcpy(before, memory.bytes, sizeof before);
        memory.read_fails_at = memory.reads + unread;
        memory.read_fails = 2U * TUMBLE_HISTORY_CELLS; /* up to that cell of the scan after */
        TEST_ASSERT_TRUE(history_boot(&memory));
        assert_status(TUMBLE_E_NV, append_entry(65));
        TEST_ASSERT_TRUE(history_settles());
        assert_status(TUMBLE_E_NV, append_entry(65));
        TEST_ASSERT_EQUAL_MEMORY(before, memory.bytes, sizeof before);
        TEST_ASSERT_TRUE(history_settles());
        assert_status(TUMBLE_OK, append_entry(65));
        TEST_ASSERT_EQUAL_UINT8(33, tumble_history_count(&logs_history));
        TEST_ASSERT_EQUAL_UINT32(65, tumble_history_sequence(&logs_history));
        TEST_ASSERT_EQUAL_UINT32(33, sequence_at(32));
    }
}
