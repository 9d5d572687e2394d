/* The keeper, and an active set that decays in the memory: the one before counts, and no sequence is given twice. */
#include "keeper_bench.h"

#include "core/bytes.h"
#include "core/crc32.h"

static uint8_t events; /* in the history, besides the sets */

static void set_up(void)
{
    events = 0;
    keeper_power_on();
}

/* One bit of the set with this sequence. */
static void decay(uint32_t sequence)
{
    for (uint32_t s = TUMBLE_REGION_SLOT_A; s <= TUMBLE_REGION_SLOT_B; s++) {
        uint8_t *place = &memory.bytes[MEMORY_SECTOR * s];
        if (tumble_get_u32(&place[8]) == sequence) {
            place[100] ^= 1U;
        }
    }
}

static void commit_one(uint32_t sequence)
{
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_EQUAL(TUMBLE_ORIGIN_COMMITTED, set_of(TUMBLE_SET_ACTIVE).origin);
    TEST_ASSERT_EQUAL_UINT32(sequence, keeper.sequence);
    TEST_ASSERT_EQUAL_UINT8(sequence + events, tumble_history_count(&keeper.history));
}

/* Found while its successor is judged: that is judged by the one before. Who looked at the counter only before and
 * after all this must see that it is another set. */
static void test_while_its_successor_is_judged(void)
{
    commit_one(1);
    commit_one(2);
    decay(2);
    events = 1;
    commit_one(3);
}

/* What tells of it: the due bit, the emergency message with the counter as it is now, the newest entry of the history. */
static void assert_told(uint32_t lost, uint32_t counter)
{
    tumble_history_entry_t entry;
    settle_memory();
    TEST_ASSERT_BITS_HIGH(TUMBLE_DUE_DECAYED, state_of_keeper().due);
    TEST_ASSERT_EQUAL_UINT32(counter, keeper.sequence);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_ERROR_GENERIC | TUMBLE_ERROR_MANUFACTURER, bench.navcomp.node.emcy.error_register);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_KEEPER_EMCY_DECAYED, bench.navcomp.node.emcy.history[0] & 0xFFFFU);
    TEST_ASSERT_EQUAL_UINT8(1, bench.navcomp.node.emcy.recorded);
    TEST_ASSERT_EQUAL_UINT32(counter & 0xFFFFU, bench.navcomp.node.emcy.history[0] >> 16);
    ASSERT_STATUS(TUMBLE_OK, tumble_history_read(&keeper.history, 0, &entry));
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ORIGIN_DECAYED, entry.origin);
    TEST_ASSERT_EQUAL_UINT32(lost, entry.sequence);
}

static void assert_not_told(void)
{
    TEST_ASSERT_BITS_LOW(TUMBLE_DUE_DECAYED, state_of_keeper().due);
    TEST_ASSERT_EQUAL_HEX8(0, bench.navcomp.node.emcy.error_register);
}

static void test_while_power_is_off(void)
{
    commit_one(1);
    commit_one(2);
    assert_not_told();
    decay(2);
    for (int cycles = 0; cycles < 3; cycles++) { /* each time it is told, and once it is recorded */
        keeper_power_cycle();
        assert_told(2, 1);
        TEST_ASSERT_EQUAL_UINT8(3, tumble_history_count(&keeper.history));
    }
    const tumble_set_t active = set_of(TUMBLE_SET_ACTIVE);
    tumble_history_entry_t entry;
    ASSERT_STATUS(TUMBLE_OK, tumble_history_read(&keeper.history, 0, &entry));
    TEST_ASSERT_TRUE((double)entry.value[0] ==
                     (double)(float)active.coefficients.k_v_per_g[0][0]); /* what counts now */
    events = 1;
    commit_one(3);
    assert_not_told();
    keeper_power_cycle();
    settle_memory();
    assert_not_told();
}

static void test_both_slots(void)
{
    commit_one(1);
    commit_one(2);
    decay(1);
    decay(2);
    keeper_power_cycle();
    assert_told(2, 0);
    TEST_ASSERT_BITS_HIGH(TUMBLE_DUE_NO_SET, state_of_keeper().due);
    events = 1;
    commit_one(3);
    assert_not_told();
}

/* The first node event after power-on and after a reset of the communication: both forget what was told. */
static void test_it_is_told_again_after_a_reset(void)
{
    static const uint8_t commands[] = {TUMBLE_NMT_RESET_COMMUNICATION, TUMBLE_NMT_RESET_NODE};
    commit_one(1);
    commit_one(2);
    decay(2);
    keeper_power_cycle();
    for (size_t i = 0; i < (sizeof commands / sizeof commands[0]); i++) {
        reset_by_nmt(commands[i], 0.5);
        assert_told(2, 1);
    }
}

/* Nobody asks an operator: with TUMBLE_SETS_STARTS a run begins. */
static void test_a_run_is_due(void)
{
    settings.flags = TUMBLE_SETS_STARTS;
    commit_one(1);
    drift(1e-5);
    commit_one(2);
    decay(2);
    keeper_power_cycle();
    assert_starts_after(1.0, 1);
    TEST_ASSERT_TRUE(keeper.counters.refused == 0U);
}

/* Unreadable for a while: a result that comes later is judged by what was active, and stored. */
static void test_not_decayed_but_unreadable_at_power_on(void)
{
    commit_one(1);
    drift(2e-3);
    memory.read_fails_at = 0;
    keeper_power_cycle();
    memory.read_fails_at = NV_NEVER;
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_and_judge());
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE));
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
    drift(-2e-3);
    memory.read_fails_at = 0;
    keeper_power_cycle();
    memory.read_fails_at = NV_NEVER;
    commit_one(2);
}

static void test_and_unreadable_it_remains(void)
{
    commit_one(1);
    drift(1e-5);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    memory.read_fails_at = 0;
    end_and_settle();
    assert_verdict(TUMBLE_VERDICT_FAILED);
    memory.read_fails_at = NV_NEVER;
    keeper_power_cycle();
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
}

/* A record of sequence 1 beside one of sequence 2 that could not be read would be lost again at the next power-on. */
static void test_parameters_beside_some_that_cannot_be_read_are_refused(void)
{
    for (int saved = 1; saved <= 2; saved++) {
        TEST_ASSERT_EQUAL(TUMBLE_ABORT_LATER, tumble_parameters_save(&keeper.parameters));
        settle_memory();
        TEST_ASSERT_EQUAL_UINT32(saved, keeper.parameters.view.sequence);
    }
    memory.read_fails_at = 0;
    keeper_power_cycle();
    memory.read_fails_at = NV_NEVER;
    TEST_ASSERT_EQUAL_UINT32(0, keeper.parameters.view.sequence);
    TEST_ASSERT_EQUAL(TUMBLE_ABORT_HARDWARE, tumble_parameters_save(&keeper.parameters));
    TEST_ASSERT_EQUAL(TUMBLE_ABORT_HARDWARE, tumble_parameters_forget(&keeper.parameters));
    keeper_power_cycle();
    TEST_ASSERT_EQUAL_UINT32(2, keeper.parameters.view.sequence);
    TEST_ASSERT_EQUAL(TUMBLE_ABORT_LATER, tumble_parameters_save(&keeper.parameters));
}

static uint32_t reads;

static tumble_status_t read_every_other_time(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    reads++;
    return ((reads % 2U) == 0U) ? TUMBLE_E_NV : nv_read(context, offset, bytes, size);
}

/* What was saved is in force although the memory fails now and then while it is read. */
static void test_parameters_that_can_be_read_at_the_second_attempt(void)
{
    const uint8_t samples[4] = {34, 0, 0, 0};
    TEST_ASSERT_EQUAL(TUMBLE_ABORT_NONE, tumble_node_write(&bench.navcomp.node, 0x2050, 1, samples, sizeof samples));
    TEST_ASSERT_EQUAL(TUMBLE_ABORT_LATER, tumble_parameters_save(&keeper.parameters));
    settle_memory();
    memory.nv.read = read_every_other_time;
    for (uint32_t first = 0; first < 2U; first++) {
        reads = first;
        keeper_power_cycle();
        TEST_ASSERT_EQUAL_UINT32(34, bench.navcomp.procedure_config.samples);
        TEST_ASSERT_EQUAL_UINT32(1, keeper.parameters.view.sequence);
    }
}

/* The set with this sequence gets a flag, or a schema, of a version that is not written yet; checksum and mark are right. */
static uint8_t *make_newer(uint32_t sequence, uint32_t at)
{
    uint8_t *found = NULL;
    for (uint32_t s = TUMBLE_REGION_SLOT_A; s <= TUMBLE_REGION_SLOT_B; s++) {
        uint8_t *place = &memory.bytes[MEMORY_SECTOR * s];
        if (tumble_get_u32(&place[8]) == sequence) {
            place[at] = 2;
            tumble_put_u32(&place[316], tumble_crc32(0, place, 316));
            tumble_put_u32(&place[324], tumble_get_u32(&place[316]));
            found = place;
        }
    }
    TEST_ASSERT_NOT_NULL(found);
    return found;
}

/* It is told as what it is, nothing is written over it, and no run begins because of it. */
static void assert_newer_is_kept(uint32_t at)
{
    uint8_t before[TUMBLE_SET_PLACE_BYTES];
    commit_one(1);
    commit_one(2);
    uint8_t *place = make_newer(2, at);
    memcpy(before, place, sizeof before);
    keeper_power_cycle();
    settle_memory();
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_DUE_NEWER, state_of_keeper().due);
    assert_not_told();
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
    TEST_ASSERT_EQUAL_UINT32(0, keeper.store.cells.torn);
    TEST_ASSERT_EQUAL_UINT8(2, tumble_history_count(&keeper.history));
    assert_verdict_after(1e-5, TUMBLE_VERDICT_HELD);
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NEWER_SET));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(before, place, sizeof before);
    ASSERT_STATUS(TUMBLE_OK, accept_proposal()); /* whoever wants it so */
    settle_memory();
    TEST_ASSERT_EQUAL_UINT32(3, keeper.sequence);
    TEST_ASSERT_BITS_LOW(TUMBLE_DUE_NEWER, state_of_keeper().due);
}

static void test_a_newer_schema_is_kept_and_told(void)
{
    assert_newer_is_kept(4);
}

static void test_newer_flags_are_kept_and_told(void)
{
    assert_newer_is_kept(15);
}
