/* The store undisturbed: jobs, what is answered, and what is refused. Disturbed: test_store_power.c. */
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

static void test_a_life(void)
{
    const tumble_set_t factory = set_of(FACTORY);
    assert_sets(0, 0, 0, 0);
    assert_status(TUMBLE_OK, ended(tumble_store_write_factory(&jobs_store, &factory)));
    assert_sets(FACTORY, 0, 0, FACTORY);
    put_commit(FIRST);
    assert_sets(FIRST, FACTORY, 0, FACTORY);
    put_commit(SECOND);
    assert_sets(SECOND, FIRST, 0, FACTORY);
    put_hold(HELD);
    assert_sets(SECOND, FIRST, HELD, FACTORY);
    assert_status(TUMBLE_OK, job_accept());
    assert_sets(HELD, SECOND, 0, FACTORY);
    TEST_ASSERT_EQUAL_UINT32(3, tumble_store_sequence(&jobs_store));
    assert_status(TUMBLE_OK, job_rollback());
    assert_sets(SECOND, FACTORY, 0, FACTORY);
    assert_status(TUMBLE_OK, job_rollback());
    assert_sets(FACTORY, 0, 0, FACTORY);
    assert_status(TUMBLE_E_STATE, job_rollback());
    TEST_ASSERT_EQUAL_UINT32(5, tumble_store_sequence(&jobs_store));
    TEST_ASSERT_EQUAL_UINT32(5, jobs_store.commits);
    put_hold(THIRD);
    assert_status(TUMBLE_OK, job_discard());
    assert_sets(FACTORY, 0, 0, FACTORY);
    put_commit(NEW);
    assert_sets(NEW, FACTORY, 0, FACTORY);
    TEST_ASSERT_TRUE(jobs_boot(&memory));
    assert_sets(NEW, FACTORY, 0, FACTORY);
    TEST_ASSERT_EQUAL_UINT32(6, tumble_store_sequence(&jobs_store));
    TEST_ASSERT_EQUAL_UINT32(0, jobs_store.cells.torn);
}

static void test_the_store_writes_its_own_fields(void)
{
    tumble_set_t set = set_of(HELD);
    put_commit(FIRST);
    set.flags = TUMBLE_SET_RESUMED;
    assert_status(TUMBLE_OK, ended(tumble_store_hold(&jobs_store, &set)));
    assert_status(TUMBLE_OK, tumble_store_read(&jobs_store, TUMBLE_SET_PROPOSAL, &set));
    TEST_ASSERT_EQUAL_UINT32(2, set.sequence);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ORIGIN_HELD, set.origin);
    (void)job_accept();
    assert_status(TUMBLE_OK, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ORIGIN_ACCEPTED, set.origin);
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_SET_RESUMED, set.flags);
    TEST_ASSERT_NOT_EQUAL(0, set.from_crc);
    (void)job_rollback();
    assert_status(TUMBLE_OK, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ORIGIN_ROLLED_BACK, set.origin);
    TEST_ASSERT_EQUAL_UINT32(1, set.restores);
    TEST_ASSERT_EQUAL_UINT32(3, set.sequence);
}

static void test_a_memory_that_does_not_fit_is_refused(void)
{
    tumble_nv_t nv = memory.nv;
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_init(NULL, &nv));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_init(&jobs_store, NULL));
    nv.read = NULL;
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_init(&jobs_store, &nv));
    static const uint32_t wrong[][3] = {{7U * 4096U, 4096, 8},  {8U * 4096U, 2048, 8},  {8U * 4096U, 4096, 0},
                                        {8U * 4096U, 4096, 64}, {8U * 4096U, 4096, 12}, {8U * 4100U, 4100, 8}};
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        nv = memory.nv;
        nv.size_bytes = wrong[i][0];
        nv.sector_bytes = wrong[i][1];
        nv.granule_bytes = wrong[i][2];
        assert_status(TUMBLE_E_NV, tumble_store_init(&jobs_store, &nv));
    }
    const tumble_set_t set = set_of(FIRST);
    tumble_set_t read;
    TEST_ASSERT_FALSE(tumble_store_busy(&jobs_store));
    assert_status(TUMBLE_E_STATE, tumble_store_step(&jobs_store));
    assert_status(TUMBLE_E_STATE, tumble_store_commit(&jobs_store, &set));
    assert_status(TUMBLE_E_STATE, tumble_store_hold(&jobs_store, &set));
    assert_status(TUMBLE_E_STATE, tumble_store_accept(&jobs_store, 0));
    assert_status(TUMBLE_E_STATE, tumble_store_discard(&jobs_store));
    assert_status(TUMBLE_E_STATE, tumble_store_rollback(&jobs_store));
    assert_status(TUMBLE_E_STATE, tumble_store_write_factory(&jobs_store, &set));
    assert_status(TUMBLE_E_STATE, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &read));
    TEST_ASSERT_FALSE(tumble_store_has(&jobs_store, TUMBLE_SET_ACTIVE));
}

static void test_one_job_at_a_time(void)
{
    const tumble_set_t set = set_of(FIRST);
    tumble_set_t read;
    assert_status(TUMBLE_OK, tumble_store_commit(&jobs_store, &set));
    TEST_ASSERT_TRUE(tumble_store_busy(&jobs_store));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_outcome(&jobs_store));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_commit(&jobs_store, &set));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_accept(&jobs_store, 0));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &read));
    TEST_ASSERT_FALSE(tumble_store_has(&jobs_store, TUMBLE_SET_ACTIVE));
    TEST_ASSERT_TRUE(store_settles(&jobs_store));
    assert_status(TUMBLE_OK, tumble_store_outcome(&jobs_store));
    assert_sets(FIRST, 0, 0, 0);
}

static void test_what_is_not_there_or_wrong_is_refused(void)
{
    tumble_set_t set = set_of(FIRST);
    assert_status(TUMBLE_E_STATE, tumble_store_accept(&jobs_store, 0));
    assert_status(TUMBLE_E_STATE, tumble_store_discard(&jobs_store));
    assert_status(TUMBLE_E_STATE, tumble_store_rollback(&jobs_store));
    assert_status(TUMBLE_E_STATE, tumble_store_read(&jobs_store, TUMBLE_SET_FACTORY, &set));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_read(&jobs_store, (tumble_which_set_t)4, &set));
    TEST_ASSERT_FALSE(tumble_store_has(&jobs_store, (tumble_which_set_t)4));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_commit(&jobs_store, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_hold(&jobs_store, NULL));
    set.coefficients.u0_v[1] = NOT_A_NUMBER;
    assert_status(TUMBLE_E_NOT_FINITE, tumble_store_commit(&jobs_store, &set));
    assert_status(TUMBLE_E_NOT_FINITE, tumble_store_write_factory(&jobs_store, &set));
    TEST_ASSERT_FALSE(tumble_store_busy(&jobs_store));
    put_commit(FIRST);
    assert_status(TUMBLE_E_STATE, tumble_store_rollback(&jobs_store)); /* there is no factory set */
    put_commit(SECOND);
    put_hold(HELD);
    assert_status(TUMBLE_E_STATE, tumble_store_rollback(&jobs_store)); /* a proposal is held */
    TEST_ASSERT_EQUAL_UINT32(2, jobs_store.commits);
}

static void test_the_factory_set_is_written_once(void)
{
    const tumble_set_t set = set_of(FACTORY);
    memset(memory.bytes, 0, 1);
    memset(&memory.bytes[512], 0, 1);
    TEST_ASSERT_TRUE(jobs_boot(&memory));
    TEST_ASSERT_EQUAL_UINT32(2, jobs_store.cells.torn);
    assert_status(TUMBLE_OK, ended(tumble_store_write_factory(&jobs_store, &set)));
    assert_sets(FACTORY, 0, 0, FACTORY);
    TEST_ASSERT_EQUAL_HEX8('T', memory.bytes[1024]);
    assert_status(TUMBLE_E_STATE, tumble_store_write_factory(&jobs_store, &set));
    for (unsigned place = 0; place < TUMBLE_FACTORY_PLACES; place++) {
        memory.bytes[512U * place + 8U] ^= 1U;
    }
    TEST_ASSERT_TRUE(jobs_boot(&memory));
    assert_status(TUMBLE_E_STATE, tumble_store_write_factory(&jobs_store, &set)); /* no place is left */
}

static void stamp_slot(uint32_t sequence)
{
    uint8_t *place = &memory.bytes[4096];
    const tumble_set_stamp_t stamp = {.sequence = sequence, .origin = TUMBLE_ORIGIN_COMMITTED};
    tumble_set_stamp(place, &stamp);
    tumble_put_u32(&place[TUMBLE_SET_BYTES + 4U], tumble_set_crc(place));
    TEST_ASSERT_TRUE(jobs_boot(&memory));
}

static void test_the_sequence_does_not_wrap(void)
{
    const tumble_set_t set = set_of(SECOND);
    put_hold(HELD);
    put_commit(FIRST);
    stamp_slot(UINT32_MAX - 2U);
    put_commit(SECOND);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_MAX_SEQUENCE, tumble_store_sequence(&jobs_store));
    assert_status(TUMBLE_E_STATE, tumble_store_commit(&jobs_store, &set));
    assert_status(TUMBLE_E_STATE, tumble_store_hold(&jobs_store, &set));
    assert_status(TUMBLE_E_STATE, tumble_store_accept(&jobs_store, 0));
    assert_status(TUMBLE_E_STATE, tumble_store_rollback(&jobs_store));
    assert_status(TUMBLE_OK, job_discard()); /* needs none */
    assert_sets(SECOND, FIRST, 0, 0);
}

static void test_what_has_decayed_is_found_out_and_the_next_is_active(void)
{
    tumble_set_t set;
    put_commit(FIRST);
    put_commit(SECOND);
    memory.bytes[2U * 4096U + 100U] ^= 4U;
    assert_status(TUMBLE_E_CRC, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_TRUE(store_settles(&jobs_store));
    assert_sets(FIRST, 0, 0, 0);
    memory.bytes[4096U + TUMBLE_SET_BYTES] ^= 4U; /* the mark */
    assert_status(TUMBLE_E_FRAME, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_TRUE(store_settles(&jobs_store));
    assert_sets(0, 0, 0, 0);
}

static void test_what_decayed_before_it_was_copied_is_not_copied(void)
{
    put_commit(FIRST);
    put_hold(HELD);
    memory.bytes[3U * 4096U + 100U] ^= 4U;
    assert_status(TUMBLE_E_CRC, job_accept());
    assert_sets(FIRST, 0, 0, 0);
}

static void test_a_read_that_fails_is_tried_again(void)
{
    tumble_set_t set;
    put_commit(FIRST);
    memory.read_fails_at = memory.reads + 4U; /* the slot, at the next scan */
    memory.read_fails = 2;
    TEST_ASSERT_TRUE(jobs_boot(&memory));
    TEST_ASSERT_EQUAL_UINT32(2, jobs_store.cells.nv_errors);
    assert_sets(FIRST, 0, 0, 0);
    memory.read_fails_at = memory.reads;
    memory.read_fails = 2U;
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    assert_status(TUMBLE_OK, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_FALSE(tumble_store_busy(&jobs_store));
    TEST_ASSERT_EQUAL_UINT32(4, jobs_store.cells.nv_errors);
    memory.read_fails_at = memory.reads;
    memory.read_fails = 3U;
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    assert_status(TUMBLE_E_NV, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_EQUAL_UINT32(7, jobs_store.cells.nv_errors);
    TEST_ASSERT_TRUE(store_settles(&jobs_store));
    assert_sets(FIRST, 0, 0, 0);
    memory.read_fails_at = memory.reads + 4U;
    memory.read_fails = 3;
    TEST_ASSERT_TRUE(jobs_boot(&memory));
    assert_sets(0, 0, 0, 0);
    TEST_ASSERT_EQUAL_UINT32(1, jobs_store.cells.torn);
    set = set_of(SECOND);
    assert_status(TUMBLE_E_NV, tumble_store_commit(&jobs_store, &set)); /* not over a set that could not be read */
    TEST_ASSERT_TRUE(store_settles(&jobs_store));
    assert_sets(FIRST, 0, 0, 0);
    put_commit(SECOND);
    assert_sets(SECOND, FIRST, 0, 0);
}

static void test_failures_are_counted_by_their_kind(void)
{
    nv_arm(&memory, (nv_fault_t){1, DONE_HALF, THEN_SILENT});
    assert_status(TUMBLE_E_NV, job_commit());
    TEST_ASSERT_EQUAL_UINT32(1, jobs_store.cells.verify);
    TEST_ASSERT_EQUAL_UINT32(0, jobs_store.cells.nv_errors);
    nv_arm(&memory, (nv_fault_t){0, DONE_ALL, THEN_ERROR});
    assert_status(TUMBLE_E_NV, job_commit());
    TEST_ASSERT_EQUAL_UINT32(1, jobs_store.cells.verify);
    TEST_ASSERT_EQUAL_UINT32(1, jobs_store.cells.nv_errors);
    TEST_ASSERT_EQUAL_UINT32(0, jobs_store.commits);
    nv_arm(&memory, nv_no_fault);
    put_hold(HELD);
    memory.read_fails_at = memory.reads;
    memory.read_fails = 1;
    assert_status(TUMBLE_E_NV, job_accept());
    TEST_ASSERT_EQUAL_UINT32(2, jobs_store.cells.nv_errors);
    assert_sets(0, 0, HELD, 0);
}

/* What an unfinished rollback leaves is cleared at the next start, also when the staged copy is gone already. */
static void test_a_rollback_cut_short_is_cleared_at_start_up(void)
{
    for (uint32_t at = 6; at <= 7U; at++) {
        nv_make(&memory, TUMBLE_REGION_COUNT, 8, 4096);
        TEST_ASSERT_TRUE(jobs_boot(&memory));
        put_commit(FIRST);
        put_commit(SECOND);
        nv_arm(&memory, (nv_fault_t){at, DONE_NOTHING, THEN_CUT});
        (void)job_rollback();
        TEST_ASSERT_TRUE(memory.is_off);
        nv_arm(&memory, nv_no_fault);
        TEST_ASSERT_TRUE(jobs_boot(&memory));
        TEST_ASSERT_EQUAL_UINT32((at == 6U) ? 2U : 1U, memory.operations);
        assert_sets(FIRST, 0, 0, 0);
        TEST_ASSERT_TRUE(nv_all_blank(&memory.bytes[2U * 4096U], 4096));
        TEST_ASSERT_TRUE(nv_all_blank(&memory.bytes[3U * 4096U], 4096));
    }
}

static const start_t with_held = {.factory = 1, .commits = 2, .held = 1};

static void test_a_proposal_that_is_cleared_stays_cleared_after_an_accept_cut_short(void)
{
    prepare_stale(&memory, &with_held);
    TEST_ASSERT_FALSE(nv_all_blank(&memory.bytes[3U * 4096U], 4096));
    TEST_ASSERT_TRUE(jobs_boot(&memory));
    TEST_ASSERT_TRUE(nv_all_blank(&memory.bytes[3U * 4096U], 4096));
    assert_sets(HELD, SECOND, 0, FACTORY);
}

/* Where clearing failed, the next commit does it first, or the proposal would come back with the next set. */
static void test_a_commit_clears_what_an_accept_could_not(void)
{
    prepare_sets(&memory, &with_held);
    nv_arm(&memory, (nv_fault_t){3, DONE_NOTHING, THEN_ERROR});
    assert_status(TUMBLE_E_NV, job_accept());
    nv_arm(&memory, nv_no_fault);
    assert_sets(HELD, SECOND, 0, FACTORY);
    assert_status(TUMBLE_OK, job_commit());
    assert_sets(NEW, HELD, 0, FACTORY);
}

static void test_a_slow_memory_is_asked_the_same_again(void)
{
    memory.busy_each = 3;
    put_commit(FIRST);
    put_hold(HELD);
    assert_status(TUMBLE_OK, job_accept());
    memory.busy_each = 0;
    assert_sets(HELD, FIRST, 0, 0);
    memory.busy_each = 1;
    tumble_set_t set;
    assert_status(TUMBLE_E_PORT_BUSY, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    assert_status(TUMBLE_OK, tumble_store_read(&jobs_store, TUMBLE_SET_ACTIVE, &set));
    TEST_ASSERT_TRUE(set_is(&set, HELD));
}

static void test_a_step_makes_at_most_one_call(void)
{
    const tumble_set_t set = set_of(FIRST);
    assert_status(TUMBLE_OK, tumble_store_commit(&jobs_store, &set));
    uint32_t calls = memory.reads + memory.operations;
    while (tumble_store_step(&jobs_store) == TUMBLE_E_PORT_BUSY) {
        TEST_ASSERT_TRUE(memory.reads + memory.operations <= calls + 1U);
        calls = memory.reads + memory.operations;
    }
}

/* The mark that makes a record valid, and the counter that no second record gets. */

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
