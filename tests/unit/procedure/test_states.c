/* The closed lists of states and reasons: names, sentences, and the numbers that travel on wires. */
#include "procedure/states.h"
#include "support.h"

static void test_numbers_on_the_wire_never_change(void)
{
    TEST_ASSERT_EQUAL_INT(0, TUMBLE_STATE_IDLE);
    TEST_ASSERT_EQUAL_INT(6, TUMBLE_STATE_SETTLE);
    TEST_ASSERT_EQUAL_INT(12, TUMBLE_STATE_DONE);
    TEST_ASSERT_EQUAL_INT(13, TUMBLE_STATE_FAULT);
    TEST_ASSERT_EQUAL_INT(14, TUMBLE_STATE_ABORT);
    TEST_ASSERT_EQUAL_INT(15, TUMBLE_STATE_COUNT);
    TEST_ASSERT_EQUAL_INT(0, TUMBLE_REASON_NONE);
    TEST_ASSERT_EQUAL_INT(12, TUMBLE_REASON_SLIP);
    TEST_ASSERT_EQUAL_INT(24, TUMBLE_REASON_WRONG_MOUNTING);
    TEST_ASSERT_EQUAL_INT(28, TUMBLE_REASON_BUS);
    TEST_ASSERT_EQUAL_INT(29, TUMBLE_REASON_UNCERTAIN);
    TEST_ASSERT_EQUAL_INT(30, TUMBLE_REASON_INHIBITED);
    TEST_ASSERT_EQUAL_INT(31, TUMBLE_REASON_STOP_NOT_CONFIRMED);
    TEST_ASSERT_EQUAL_INT(32, TUMBLE_REASON_FOREIGN_COMMAND);
    TEST_ASSERT_EQUAL_INT(33, TUMBLE_REASON_SUPERVISION);
    TEST_ASSERT_EQUAL_INT(34, TUMBLE_REASON_RUNAWAY);
    TEST_ASSERT_EQUAL_INT(35, TUMBLE_REASON_SCALE);
    TEST_ASSERT_EQUAL_INT(36, TUMBLE_REASON_COUNT);
}

static void assert_text(const char *prefix, const char *name, const char *sentence)
{
    TEST_ASSERT_EQUAL_STRING_LEN(prefix, name, strlen(prefix));
    TEST_ASSERT_GREATER_THAN(3, (int)strlen(sentence));
    TEST_ASSERT_NOT_EQUAL('.', sentence[strlen(sentence) - 1U]);
}

static void test_every_value_has_a_name_and_a_sentence_of_its_own(void)
{
    for (int i = 0; i < (int)TUMBLE_STATE_COUNT; i++) {
        assert_text("TUMBLE_STATE_", tumble_state_name((tumble_state_t)i), tumble_state_sentence((tumble_state_t)i));
        for (int j = 0; j < i; j++) {
            const char *other = tumble_state_name((tumble_state_t)j);
            TEST_ASSERT_NOT_EQUAL(0, strcmp(tumble_state_name((tumble_state_t)i), other));
        }
    }
    for (int i = 0; i < (int)TUMBLE_REASON_COUNT; i++) {
        const tumble_reason_t reason = (tumble_reason_t)i;
        assert_text("TUMBLE_REASON_", tumble_reason_name(reason), tumble_reason_sentence(reason));
        for (int j = 0; j < i; j++) {
            const char *other = tumble_reason_sentence((tumble_reason_t)j);
            TEST_ASSERT_NOT_EQUAL(0, strcmp(tumble_reason_sentence(reason), other));
        }
    }
}

static void test_names_belong_to_their_values(void)
{
    TEST_ASSERT_EQUAL_STRING("TUMBLE_STATE_WAIT_MOUNTING", tumble_state_name(TUMBLE_STATE_WAIT_MOUNTING));
    TEST_ASSERT_EQUAL_STRING("finished", tumble_state_sentence(TUMBLE_STATE_DONE));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_REASON_STALL", tumble_reason_name(TUMBLE_REASON_STALL));
    TEST_ASSERT_EQUAL_STRING("a channel is saturated", tumble_reason_sentence(TUMBLE_REASON_SATURATED));
}

static void test_values_outside_the_lists_are_safe(void)
{
    TEST_ASSERT_EQUAL_STRING("TUMBLE_STATE_UNKNOWN", tumble_state_name(TUMBLE_STATE_COUNT));
    TEST_ASSERT_EQUAL_STRING("this state is not in the list", tumble_state_sentence((tumble_state_t)255));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_REASON_UNKNOWN", tumble_reason_name((tumble_reason_t)255));
    TEST_ASSERT_EQUAL_STRING("this reason is not in the list", tumble_reason_sentence(TUMBLE_REASON_COUNT));
}
