/* A result that is offered again: recognised in every place of the store. */
#include "keeper_bench.h"

/* The proposal is in no history: it is recognised by looking at it, whatever else the store holds. */
static void test_a_held_proposal_is_recognised_beside_a_set_before(void)
{
    (void)run_and_judge();
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    (void)set_of(TUMBLE_SET_PREVIOUS);
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    const tumble_set_t held = set_of(TUMBLE_SET_PROPOSAL);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_REPEATED, run_and_judge());
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_REPLAYED) |
                                TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE),
                            state_of_keeper().objections);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.held);
    const tumble_set_t still = set_of(TUMBLE_SET_PROPOSAL);
    TEST_ASSERT_EQUAL_MEMORY(&held, &still, sizeof held);
}

/* Nor is the set before the active one, although it is in the history as well: that may be gone. */
static void test_the_set_before_is_recognised_without_a_history(void)
{
    (void)run_and_judge();
    assert_verdict_after(1e-5, TUMBLE_VERDICT_COMMITTED);
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    memset(&memory.bytes[(size_t)TUMBLE_REGION_HISTORY * MEMORY_SECTOR], 0xFF, 2U * MEMORY_SECTOR);
    drift(-2e-3 - 1e-5);
    keeper_power_cycle();
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_REPEATED, run_and_judge());
    TEST_ASSERT_TRUE(state_of_keeper().has_proposal);
    TEST_ASSERT_EQUAL_UINT32(2, keeper.sequence);
}

static const around_t around_each = {keeper_power_on, NULL};
