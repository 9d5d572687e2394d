/* The closed list of outcomes: names, sentences, and the numbers that travel on wires. */
#include "support.h"
#include "tumble/status.h"

#include <limits.h>

static void test_numbers_on_the_wire_never_change(void)
{
    static const tumble_status_t in_order[] = {
        TUMBLE_OK,
        TUMBLE_E_ARGUMENT,
        TUMBLE_E_NOT_FINITE,
        TUMBLE_E_SCHEDULE_SIZE,
        TUMBLE_E_SCHEDULE_ROTATION,
        TUMBLE_E_SCHEDULE_ANGLE,
        TUMBLE_E_SCHEDULE_MOUNTING,
        TUMBLE_E_SCHEDULE_DUPLICATE,
        TUMBLE_E_NOT_HARMONIC,
        TUMBLE_E_MISSING_POSITION,
        TUMBLE_E_RANK,
        TUMBLE_E_SINGULAR,
        TUMBLE_E_GAIN_TABLE,
        TUMBLE_E_NOT_OPEN,
        TUMBLE_E_FULL,
        TUMBLE_E_TOO_FEW,
        TUMBLE_E_SATURATED,
        TUMBLE_E_DEVIATION,
        TUMBLE_E_REPEATED,
        TUMBLE_E_REORDERED,
        TUMBLE_E_LOST,
        TUMBLE_E_STUCK,
        TUMBLE_E_NOT_STILL,
        TUMBLE_E_STATE,
        TUMBLE_E_PORT_BUSY,
        TUMBLE_E_PORT_EMPTY,
        TUMBLE_E_PORT_DOWN,
        TUMBLE_E_STAND_STATE,
        TUMBLE_E_SDO_BUSY,
        TUMBLE_E_SDO_ABORTED,
        TUMBLE_E_SDO_TIMEOUT,
        TUMBLE_E_FRAME,
        TUMBLE_E_CRC,
        TUMBLE_E_GAIN_RECORD,
        TUMBLE_E_STAND_ERROR,
        TUMBLE_E_UNCERTAIN,
        TUMBLE_E_NV,
        TUMBLE_E_UNHEALTHY,
        TUMBLE_E_NOT_INCLINED,
        TUMBLE_E_ALIKE,
        TUMBLE_E_ONE_SIDE,
    };
    for (size_t i = 0; i < COUNT_OF(in_order); i++) {
        TEST_ASSERT_EQUAL_INT((int)i, (int)in_order[i]);
    }
    TEST_ASSERT_EQUAL_INT((int)COUNT_OF(in_order), (int)TUMBLE_STATUS_COUNT);
}

static void test_every_status_has_a_name_and_a_sentence_of_its_own(void)
{
    for (int i = 0; i < (int)TUMBLE_STATUS_COUNT; i++) {
        const char *name = tumble_status_name((tumble_status_t)i);
        const char *sentence = tumble_status_sentence((tumble_status_t)i);
        TEST_ASSERT_EQUAL_STRING_LEN("TUMBLE_", name, 7);
        TEST_ASSERT_GREATER_THAN(3, (int)strlen(sentence));
        TEST_ASSERT_NOT_EQUAL('.', sentence[strlen(sentence) - 1U]);
        for (int j = 0; j < i; j++) {
            TEST_ASSERT_NOT_EQUAL(0, strcmp(name, tumble_status_name((tumble_status_t)j)));
            TEST_ASSERT_NOT_EQUAL(0, strcmp(sentence, tumble_status_sentence((tumble_status_t)j)));
        }
    }
}

static void test_names_belong_to_their_values(void)
{
    TEST_ASSERT_EQUAL_STRING("TUMBLE_OK", tumble_status_name(TUMBLE_OK));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_E_RANK", tumble_status_name(TUMBLE_E_RANK));
    TEST_ASSERT_EQUAL_STRING("TUMBLE_E_NOT_STILL", tumble_status_name(TUMBLE_E_NOT_STILL));
    TEST_ASSERT_EQUAL_STRING("done", tumble_status_sentence(TUMBLE_OK));
    TEST_ASSERT_EQUAL_STRING("a sample counter is repeated", tumble_status_sentence(TUMBLE_E_REPEATED));
}

static void test_values_outside_the_list_are_safe(void)
{
    static const int outside[] = {-1, (int)TUMBLE_STATUS_COUNT, (int)TUMBLE_STATUS_COUNT + 1, 255, INT_MIN, INT_MAX};
    const size_t that_fit = (sizeof(tumble_status_t) < sizeof(int)) ? 4U : COUNT_OF(outside); /* bytes on ARM */
    for (size_t i = 0; i < that_fit; i++) {
        const tumble_status_t status = (tumble_status_t)outside[i];
        TEST_ASSERT_EQUAL_STRING("TUMBLE_STATUS_UNKNOWN", tumble_status_name(status));
        TEST_ASSERT_EQUAL_STRING("this status is not in the list", tumble_status_sentence(status));
    }
}
