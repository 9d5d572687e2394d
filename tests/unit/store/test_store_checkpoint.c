/* The checkpoint of a run undisturbed: what is kept, and what is refused. Disturbed: test_store_power.c. */
#include "sets/record.h"
#include "store_logs.h"
#include "support.h"

static nv_memory_t memory;

static void set_up(void)
{
    nv_make(&memory, TUMBLE_REGION_COUNT, 8, 4096);
    prepare_run(&memory, &(start_t){.run = NEW_RUN});
}

static void tear_down(void)
{
    TEST_ASSERT_EQUAL_UINT(0, memory.violations);
}

static void test_every_position_and_its_last_entry(void)
{
    for (logs_kept = 0; logs_kept < TUMBLE_CHECKPOINT_CELLS - 1U; logs_kept++) {
        TEST_ASSERT_EQUAL_INT(STATE_BEFORE, look_keep());
        assert_status(TUMBLE_OK, job_keep());
        TEST_ASSERT_EQUAL_INT(STATE_AFTER, look_keep());
        TEST_ASSERT_TRUE(checkpoint_boot(&memory));
        TEST_ASSERT_EQUAL_INT(STATE_AFTER, look_keep());
    }
    assert_status(TUMBLE_E_FULL, job_keep());
    TEST_ASSERT_EQUAL_UINT32(0, logs_checkpoint.cells.torn);
}

static void test_another_fingerprint_does_not_match(void)
{
    TEST_ASSERT_TRUE(tumble_checkpoint_matches(&logs_checkpoint, NEW_RUN));
    TEST_ASSERT_FALSE(tumble_checkpoint_matches(&logs_checkpoint, OLD_RUN));
    assert_status(TUMBLE_OK, job_clear());
    TEST_ASSERT_FALSE(tumble_checkpoint_matches(&logs_checkpoint, NEW_RUN));
    TEST_ASSERT_TRUE(checkpoint_boot(&memory));
    TEST_ASSERT_FALSE(tumble_checkpoint_matches(&logs_checkpoint, NEW_RUN));
    assert_status(TUMBLE_E_STATE, job_keep());
}

/* An entry that another run has left in its cell, whole: its CRC is of that run. */
static void test_entries_of_another_run_do_not_count(void)
{
    assert_status(TUMBLE_OK, append_average(0));
    uint8_t entry[TUMBLE_CHECKPOINT_BYTES];
    memcpy(entry, &memory.bytes[6U * 4096U + 64U], sizeof entry);
    assert_status(TUMBLE_OK, checkpoint_ended(tumble_checkpoint_begin(&logs_checkpoint, OLD_RUN)));
    memcpy(&memory.bytes[6U * 4096U + 64U], entry, sizeof entry);
    TEST_ASSERT_TRUE(checkpoint_boot(&memory));
    TEST_ASSERT_TRUE(tumble_checkpoint_matches(&logs_checkpoint, OLD_RUN));
    TEST_ASSERT_FALSE(tumble_checkpoint_has(&logs_checkpoint, 0));
    TEST_ASSERT_EQUAL_UINT32(1, logs_checkpoint.cells.torn);
}

static void test_what_is_out_of_range_is_refused(void)
{
    tumble_average_t average = average_of(1);
    assert_status(TUMBLE_E_ARGUMENT, tumble_checkpoint_append(&logs_checkpoint, 0, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_checkpoint_append(&logs_checkpoint, TUMBLE_MAX_POSITIONS, &average));
    average.samples = 0;
    assert_status(TUMBLE_E_ARGUMENT, tumble_checkpoint_append(&logs_checkpoint, 0, &average));
    average.samples = (uint32_t)TUMBLE_MAX_SAMPLES + 1U;
    assert_status(TUMBLE_E_ARGUMENT, tumble_checkpoint_append(&logs_checkpoint, 0, &average));
    average.samples = (uint32_t)TUMBLE_MAX_SAMPLES;
    average.scatter_counts[2] = -1.0F;
    assert_status(TUMBLE_E_ARGUMENT, tumble_checkpoint_append(&logs_checkpoint, 0, &average));
    average.scatter_counts[2] = (float)NOT_A_NUMBER;
    assert_status(TUMBLE_E_NOT_FINITE, tumble_checkpoint_append(&logs_checkpoint, 0, &average));
    assert_status(TUMBLE_E_MISSING_POSITION, tumble_checkpoint_read(&logs_checkpoint, 0, &average));
    assert_status(TUMBLE_E_MISSING_POSITION, tumble_checkpoint_read(&logs_checkpoint, 255, &average));
    assert_status(TUMBLE_E_ARGUMENT, tumble_checkpoint_read(&logs_checkpoint, 0, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_checkpoint_init(NULL, &memory.nv));
}

static void assert_margins(uint8_t cold, uint8_t warm)
{
    TEST_ASSERT_EQUAL_UINT8(cold, logs_checkpoint.margins.cold);
    TEST_ASSERT_EQUAL_UINT8(warm, logs_checkpoint.margins.warm);
}

/* Each end by itself is narrowed, never widened. */
static void test_margins_are_narrowed(void)
{
    static const struct {
        tumble_margins_t seen;
        tumble_margins_t left;
    } steps[] = {{{200, 55}, {200, 55}}, {{201, 54}, {200, 54}}, {{199, 56}, {199, 54}},
                 {{199, 54}, {199, 54}}, {{0, 255}, {0, 54}},    {{255, 0}, {0, 0}}};
    assert_margins(0, 0);
    tumble_checkpoint_narrow(&logs_checkpoint, (tumble_margins_t){200, 55});
    assert_margins(0, 0); /* what is not known stays unknown */
    logs_checkpoint.margins = (tumble_margins_t){UINT8_MAX, UINT8_MAX};
    for (size_t i = 0; i < COUNT_OF(steps); i++) {
        tumble_checkpoint_narrow(&logs_checkpoint, steps[i].seen);
        assert_margins(steps[i].left.cold, steps[i].left.warm);
    }
}

/* Entries take the margins along as they are by then; what is read narrows. */
static void test_margins_outlive_power(void)
{
    const uint8_t *entries = &memory.bytes[(6U * 4096U) + TUMBLE_CHECKPOINT_BYTES];
    assert_status(TUMBLE_OK, append_average(0)); /* not known */
    logs_checkpoint.margins = (tumble_margins_t){200, 50};
    assert_status(TUMBLE_OK, append_average(1));
    tumble_checkpoint_narrow(&logs_checkpoint, (tumble_margins_t){150, 60});
    assert_status(TUMBLE_OK, append_average(2));
    TEST_ASSERT_EACH_EQUAL_UINT8(0, &entries[44], 16);
    TEST_ASSERT_EQUAL_UINT8(200, entries[TUMBLE_CHECKPOINT_BYTES + 44U]);
    TEST_ASSERT_EQUAL_UINT8(50, entries[TUMBLE_CHECKPOINT_BYTES + 45U]);
    TEST_ASSERT_EACH_EQUAL_UINT8(0, &entries[TUMBLE_CHECKPOINT_BYTES + 46U], 14);
    TEST_ASSERT_EQUAL_UINT8(150, entries[(2U * TUMBLE_CHECKPOINT_BYTES) + 44U]);
    TEST_ASSERT_TRUE(checkpoint_boot(&memory));
    assert_margins(0, 0);
    TEST_ASSERT_TRUE(average_is(2, 2));
    assert_margins(0, 0);
    logs_checkpoint.margins = (tumble_margins_t){UINT8_MAX, UINT8_MAX};
    TEST_ASSERT_TRUE(average_is(1, 1));
    assert_margins(200, 50);
    TEST_ASSERT_TRUE(average_is(2, 2));
    assert_margins(150, 50);
    TEST_ASSERT_TRUE(average_is(0, 0));
    assert_margins(0, 0);
}

static void test_one_job_at_a_time(void)
{
    tumble_average_t average = average_of(1);
    assert_status(TUMBLE_OK, tumble_checkpoint_append(&logs_checkpoint, 3, &average));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_checkpoint_append(&logs_checkpoint, 3, &average));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_checkpoint_begin(&logs_checkpoint, 1));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_checkpoint_clear(&logs_checkpoint));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_checkpoint_read(&logs_checkpoint, 3, &average));
    TEST_ASSERT_FALSE(tumble_checkpoint_matches(&logs_checkpoint, NEW_RUN));
    TEST_ASSERT_FALSE(tumble_checkpoint_has(&logs_checkpoint, 3));
    TEST_ASSERT_TRUE(checkpoint_settles());
    TEST_ASSERT_TRUE(tumble_checkpoint_has(&logs_checkpoint, 3));
}

static void test_a_memory_that_does_not_fit_is_refused(void)
{
    tumble_average_t average = average_of(1);
    memory.nv.size_bytes = 4096;
    assert_status(TUMBLE_E_NV, tumble_checkpoint_init(&logs_checkpoint, &memory.nv));
    assert_status(TUMBLE_E_STATE, tumble_checkpoint_step(&logs_checkpoint));
    assert_status(TUMBLE_E_STATE, tumble_checkpoint_begin(&logs_checkpoint, 1));
    assert_status(TUMBLE_E_STATE, tumble_checkpoint_clear(&logs_checkpoint));
    assert_status(TUMBLE_E_STATE, tumble_checkpoint_append(&logs_checkpoint, 0, &average));
}

static void test_what_has_decayed_is_not_read(void)
{
    uint8_t *entry = &memory.bytes[6U * 4096U + 64U];
    tumble_average_t average = average_of(1);
    assert_status(TUMBLE_OK, append_average(0));
    entry[8] ^= 1U;
    assert_status(TUMBLE_E_CRC, tumble_checkpoint_read(&logs_checkpoint, 0, &average));
    memory.read_fails_at = memory.reads;
    memory.read_fails = 1;
    assert_status(TUMBLE_E_NV, tumble_checkpoint_read(&logs_checkpoint, 0, &average));
    entry[0] = 'x';
    assert_status(TUMBLE_E_CRC, tumble_checkpoint_read(&logs_checkpoint, 0, &average));
}

static void test_failures_and_torn_cells_are_counted(void)
{
    nv_arm(&memory, (nv_fault_t){0, DONE_HALF, THEN_SILENT});
    assert_status(TUMBLE_E_NV, append_average(0));
    nv_arm(&memory, (nv_fault_t){0, DONE_HALF, THEN_ERROR});
    assert_status(TUMBLE_E_NV, append_average(0));
    TEST_ASSERT_EQUAL_UINT32(1, logs_checkpoint.cells.verify);
    TEST_ASSERT_EQUAL_UINT32(1, logs_checkpoint.cells.nv_errors);
    assert_status(TUMBLE_OK, append_average(0));
    memory.read_fails_at = memory.reads + 3U;
    memory.read_fails = 1;
    TEST_ASSERT_TRUE(checkpoint_boot(&memory));
    TEST_ASSERT_EQUAL_UINT32(3, logs_checkpoint.cells.torn);
    TEST_ASSERT_FALSE(tumble_checkpoint_has(&logs_checkpoint, 0));
    memory.read_fails_at = memory.reads;
    TEST_ASSERT_TRUE(checkpoint_boot(&memory));
    TEST_ASSERT_FALSE(tumble_checkpoint_matches(&logs_checkpoint, NEW_RUN));
    memory.busy_each = 2;
    TEST_ASSERT_TRUE(checkpoint_boot(&memory));
    TEST_ASSERT_TRUE(tumble_checkpoint_has(&logs_checkpoint, 0));
    assert_status(TUMBLE_OK, append_average(1));
}
