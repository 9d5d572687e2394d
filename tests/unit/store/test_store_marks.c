/* The mark that makes a record valid, and the counter that no second record gets. */
#include "core/bytes.h"
#include "store_jobs.h"
#include "support.h"

static nv_memory_t memory;

static void set_up(void)
{
    nv_make(&memory, TUMBLE_REGION_COUNT, 8, 4096);
    TEST_ASSERT_TRUE(jobs_boot(&memory));
}

static void tear_down(void)
{
    TEST_ASSERT_EQUAL_UINT(0, memory.violations);
}

static void assert_sets(unsigned active, unsigned previous, unsigned proposal, unsigned factory)
{
    const sets_t sets = jobs_sets();
    TEST_ASSERT_EQUAL_UINT(active, sets.active);
    TEST_ASSERT_EQUAL_UINT(previous, sets.previous);
    TEST_ASSERT_EQUAL_UINT(proposal, sets.proposal);
    TEST_ASSERT_EQUAL_UINT(factory, sets.factory);
}

/* An erase may leave a whole mark standing, and a record of another set may come before it: the mark's CRC tells. */
static void test_a_mark_is_of_its_own_record_alone(void)
{
    uint8_t *const slot_a = &memory.bytes[4096];
    const uint8_t *const slot_b = &memory.bytes[2U * 4096U];
    tumble_set_t set;
    put_commit(FIRST);
    put_commit(SECOND);
    memcpy(slot_a, slot_b, TUMBLE_SET_BYTES);
    TEST_ASSERT_EQUAL_HEX32(tumble_set_crc(slot_a), tumble_get_u32(&slot_b[TUMBLE_SET_BYTES + 4U]));
    TEST_ASSERT_TRUE(jobs_boot(&memory));
    assert_sets(SECOND, 0, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(1, jobs_store.cells.torn);
    memcpy(&memory.bytes[2U * 4096U + TUMBLE_SET_BYTES], &slot_a[TUMBLE_SET_BYTES], TUMBLE_SET_MARK_BYTES);
    assert_status(TUMBLE_E_FRAME, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_TRUE(store_settles(&jobs_store));
    assert_sets(0, 0, 0, 0);
}

static void cut_before_the_mark(tumble_status_t (*job)(void), uint32_t operation, uint32_t region)
{
    const uint8_t *const place = &memory.bytes[region * 4096U];
    nv_arm(&memory, (nv_fault_t){operation, DONE_NOTHING, THEN_CUT});
    (void)job();
    TEST_ASSERT_TRUE(memory.is_off);
    TEST_ASSERT_EQUAL_HEX8('T', place[0]);
    TEST_ASSERT_FALSE(nv_all_blank(&place[TUMBLE_SET_BYTES - 4U], 4));
    TEST_ASSERT_TRUE(nv_all_blank(&place[TUMBLE_SET_BYTES], TUMBLE_SET_MARK_BYTES));
    nv_arm(&memory, nv_no_fault);
    TEST_ASSERT_TRUE(jobs_boot(&memory));
}

/* Never is there a mark before its record. */
static void test_a_loss_of_power_before_the_mark_leaves_the_record_alone(void)
{
    cut_before_the_mark(job_factory, 1, TUMBLE_REGION_FACTORY);
    cut_before_the_mark(job_commit, 2, TUMBLE_REGION_SLOT_A);
    cut_before_the_mark(job_hold, 2, TUMBLE_REGION_PROPOSAL);
    put_hold(HELD);
    cut_before_the_mark(job_accept, 2, TUMBLE_REGION_SLOT_A);
    assert_sets(0, 0, HELD, 0);
    assert_status(TUMBLE_OK, job_accept());
    cut_before_the_mark(job_commit, 2, TUMBLE_REGION_SLOT_B);
    assert_sets(HELD, 0, 0, 0);
}

/* The counter of a set that has decayed is not given to another. */
static void test_no_counter_is_given_twice(void)
{
    tumble_set_t set;
    put_commit(FIRST);
    put_commit(SECOND);
    memory.bytes[2U * 4096U + 100U] ^= 4U;
    assert_status(TUMBLE_E_CRC, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_TRUE(store_settles(&jobs_store));
    TEST_ASSERT_EQUAL_UINT32(1, tumble_store_sequence(&jobs_store));
    put_commit(THIRD);
    TEST_ASSERT_EQUAL_UINT32(3, tumble_store_sequence(&jobs_store));
}

static const around_t around_each = {set_up, tear_down};
