/* The power state machine of a drive, transition by transition, as CiA 402-2 numbers them. */
#include "canopen/cia402.h"
#include "simulation/power402.h"
#include "support.h"

typedef struct {
    int number; /* of the transition in CiA 402-2, figure 9 */
    sim_power_t from;
    uint16_t controlword;
    sim_power_t to;
} transition_t;

static const transition_t TRANSITIONS[] = {
    {2, SIM_POWER_SWITCH_ON_DISABLED, 0x0006, SIM_POWER_READY_TO_SWITCH_ON},
    {3, SIM_POWER_READY_TO_SWITCH_ON, 0x0007, SIM_POWER_SWITCHED_ON},
    {34, SIM_POWER_READY_TO_SWITCH_ON, 0x000F, SIM_POWER_OPERATION_ENABLED}, /* 3 and 4 in one */
    {4, SIM_POWER_SWITCHED_ON, 0x000F, SIM_POWER_OPERATION_ENABLED},
    {5, SIM_POWER_OPERATION_ENABLED, 0x0007, SIM_POWER_SWITCHED_ON},
    {6, SIM_POWER_SWITCHED_ON, 0x0006, SIM_POWER_READY_TO_SWITCH_ON},
    {7, SIM_POWER_READY_TO_SWITCH_ON, 0x0000, SIM_POWER_SWITCH_ON_DISABLED},
    {7, SIM_POWER_READY_TO_SWITCH_ON, 0x0002, SIM_POWER_SWITCH_ON_DISABLED},
    {8, SIM_POWER_OPERATION_ENABLED, 0x0006, SIM_POWER_READY_TO_SWITCH_ON},
    {9, SIM_POWER_OPERATION_ENABLED, 0x0000, SIM_POWER_SWITCH_ON_DISABLED},
    {10, SIM_POWER_SWITCHED_ON, 0x0000, SIM_POWER_SWITCH_ON_DISABLED},
    {10, SIM_POWER_SWITCHED_ON, 0x0002, SIM_POWER_SWITCH_ON_DISABLED},
    {11, SIM_POWER_OPERATION_ENABLED, 0x0002, SIM_POWER_QUICK_STOP_ACTIVE},
    {12, SIM_POWER_QUICK_STOP_ACTIVE, 0x0000, SIM_POWER_SWITCH_ON_DISABLED},
    {15, SIM_POWER_FAULT, 0x0080, SIM_POWER_SWITCH_ON_DISABLED},
};

static void test_every_transition(void)
{
    for (size_t i = 0; i < COUNT_OF(TRANSITIONS); i++) {
        const transition_t *const t = &TRANSITIONS[i];
        TEST_ASSERT_EQUAL_INT_MESSAGE(t->to, sim_power_next(t->from, t->controlword, 0, true), "transition");
        /* Bits of the mode and of the maker change nothing. */
        TEST_ASSERT_EQUAL_INT(t->to, sim_power_next(t->from, t->controlword | 0xFF70U, 0, true));
    }
}

/* Commands that a state does not know leave it alone: no state can be skipped. */
static void test_what_is_not_allowed_changes_nothing(void)
{
    TEST_ASSERT_EQUAL_INT(SIM_POWER_SWITCH_ON_DISABLED, sim_power_next(SIM_POWER_SWITCH_ON_DISABLED, 0x000F, 0, true));
    TEST_ASSERT_EQUAL_INT(SIM_POWER_SWITCH_ON_DISABLED, sim_power_next(SIM_POWER_SWITCH_ON_DISABLED, 0x0007, 0, true));
    TEST_ASSERT_EQUAL_INT(SIM_POWER_QUICK_STOP_ACTIVE, sim_power_next(SIM_POWER_QUICK_STOP_ACTIVE, 0x000F, 0, true));
    TEST_ASSERT_EQUAL_INT(SIM_POWER_QUICK_STOP_ACTIVE, sim_power_next(SIM_POWER_QUICK_STOP_ACTIVE, 0x0006, 0, true));
    for (uint32_t word = 0; word < 0x100U; word++) {
        TEST_ASSERT_EQUAL_INT(SIM_POWER_NOT_READY, sim_power_next(SIM_POWER_NOT_READY, (uint16_t)word, 0, true));
        TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT_REACTION,
                              sim_power_next(SIM_POWER_FAULT_REACTION, (uint16_t)word, 0, true));
    }
}

/* A reset acts once, on its rising edge, and only when the cause is gone. */
static void test_fault_reset_is_an_edge(void)
{
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT, sim_power_next(SIM_POWER_FAULT, 0x0080, 0x0080, true));
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT, sim_power_next(SIM_POWER_FAULT, 0x0000, 0x0080, true));
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT, sim_power_next(SIM_POWER_FAULT, 0x0080, 0x0000, false));
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT, sim_power_next(SIM_POWER_FAULT, 0x000F, 0x0000, true));
}

static void test_statusword_tells_the_state(void)
{
    static const uint16_t MASKS[] = {0x4F, 0x4F, 0x6F, 0x6F, 0x6F, 0x6F, 0x4F, 0x4F};
    static const uint16_t VALUES[] = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08};
    for (int state = SIM_POWER_NOT_READY; state <= SIM_POWER_FAULT; state++) {
        TEST_ASSERT_EQUAL_HEX16(VALUES[state], sim_power_status((sim_power_t)state) & MASKS[state]);
    }
}
