/* The object dictionary's table: rows that stand for several entries. */
#include "canopen_fixture.h"

/* Rows that stand for several entries: the same keys must be found as in a table with a row for each, in their right places. */
static void test_a_run_is_as_good_as_its_entries(void)
{
    static const tumble_entry_t runs[] = {
        {0x1400, 1, U32, TUMBLE_HOME_COMMUNICATION, RW, 4, 0, 2, 0, 0, 0},
        {0x1400, 2, U8, TUMBLE_HOME_COMMUNICATION, RW, 1, 0, 2, 0, 0, 0},
        {0x1600, 0, U8, TUMBLE_HOME_COMMUNICATION, RW, 1, 0, 1, 0, 0, 0},
        {0x1600, 1, U32, TUMBLE_HOME_COMMUNICATION, RW, 4, 0, 1, 7, 0, 0},
        {0x2000, 3, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED, RO, 8, 0, 0, 4, 16, 0},
        {0xFFFF, 0, U8, TUMBLE_HOME_IMMEDIATE, RO, 1, 0, 0, 0, 5, 0},
    };
    static const tumble_object_table_t table = {.entries = runs, .count = COUNT_OF(runs)};
    static const struct {
        uint16_t index;
        uint8_t subindex;
        tumble_abort_t wanted;
        uint8_t type;
        uint8_t size;
        uint16_t offset;
    } cases[] = {
        {0x13FF, 1, TUMBLE_ABORT_NO_OBJECT, 0, 0, 0},
        {0x1400, 0, TUMBLE_ABORT_NONE, U8, 1, 2},
        {0x1400, 1, TUMBLE_ABORT_NONE, U32, 4, 0},
        {0x1402, 2, TUMBLE_ABORT_NONE, U8, 1, 0},
        {0x1402, 0, TUMBLE_ABORT_NONE, U8, 1, 2},
        {0x1402, 3, TUMBLE_ABORT_NO_SUBINDEX, 0, 0, 0},
        {0x1403, 1, TUMBLE_ABORT_NO_OBJECT, 0, 0, 0},
        {0x1600, 0, TUMBLE_ABORT_NONE, U8, 1, 0},
        {0x1601, 8, TUMBLE_ABORT_NONE, U32, 4, 28},
        {0x1601, 9, TUMBLE_ABORT_NO_SUBINDEX, 0, 0, 0},
        {0x1602, 0, TUMBLE_ABORT_NO_OBJECT, 0, 0, 0},
        {0x2000, 0, TUMBLE_ABORT_NONE, U8, 1, 7},
        {0x2000, 2, TUMBLE_ABORT_NO_SUBINDEX, 0, 0, 0},
        {0x2000, 3, TUMBLE_ABORT_NONE, TUMBLE_TYPE_REAL64, 8, 16},
        {0x2000, 7, TUMBLE_ABORT_NONE, TUMBLE_TYPE_REAL64, 8, 48},
        {0x2000, 8, TUMBLE_ABORT_NO_SUBINDEX, 0, 0, 0},
        {0x0000, 0, TUMBLE_ABORT_NO_OBJECT, 0, 0, 0},
        {0xFFFF, 0, TUMBLE_ABORT_NONE, U8, 1, 5},
        {0xFFFF, 1, TUMBLE_ABORT_NO_SUBINDEX, 0, 0, 0},
    };

    at.node.dictionary.table = &table;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        tumble_entry_t found;

        TEST_ASSERT_EQUAL_HEX32(cases[i].wanted,
                                tumble_dictionary_find(&at.node.dictionary, cases[i].index, cases[i].subindex, &found));
        if (cases[i].wanted == TUMBLE_ABORT_NONE) {
            TEST_ASSERT_EQUAL_HEX16(cases[i].index, found.index);
            TEST_ASSERT_EQUAL_UINT8(cases[i].subindex, found.subindex);
            TEST_ASSERT_EQUAL_UINT8(cases[i].type, found.type);
            TEST_ASSERT_EQUAL_UINT8(cases[i].size, found.size);
            TEST_ASSERT_EQUAL_UINT16(cases[i].offset, found.offset);
        }
    }
}

/* The highest subindex is not the object's last entry: it cannot be written, nor mapped as that can. */
static void test_the_highest_subindex_is_read_only(void)
{
    static const tumble_entry_t one[] = {{0x2000, 1, U8, TUMBLE_HOME_COMPUTED, RW | MAPPED, 1, 0, 0, 2, 0, 0}};
    static const tumble_object_table_t table = {.entries = one, .count = 1};

    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES] = {0};
    uint8_t size = 0;

    at.node.dictionary.table = &table;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, tumble_node_read(&at.node, 0x2000, 0, bytes, &size));
    TEST_ASSERT_EQUAL_UINT8(1, size);
    TEST_ASSERT_EQUAL_UINT8(3, bytes[0]);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_READ_ONLY, tumble_node_write(&at.node, 0x2000, 0, bytes, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NOT_MAPPABLE,
                            tumble_pdo_write_parameter(&at.node.pdos, &at.node.dictionary, 0x1600, 1, 0x20000008U));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE,
                            tumble_pdo_write_parameter(&at.node.pdos, &at.node.dictionary, 0x1600, 1, 0x20000308U));
}

static const around_t around_each = {fixture_quietly, fixture_end};
