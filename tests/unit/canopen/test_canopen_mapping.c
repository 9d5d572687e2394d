/* PDO parameters: the order in which they are written, what is refused, what is left behind. */
#include "canopen_mapping.h"

static const tumble_pdo_setup_t setup = {
    .cob_id = 0x40000385U, .type = 255, .count = 2, .event_ms = 20, .map = {0x20050010U, 0x20030020U}};

static tumble_abort_t configure(tumble_pdo_direction_t direction, uint8_t number, const tumble_pdo_setup_t *wanted)
{
    return tumble_pdo_configure(&at.node.pdos, &at.node.dictionary, direction, number, wanted);
}

static void test_power_on_state(void)
{
    TEST_ASSERT_EQUAL_HEX32(0x80000000U, read32(0x1400, 1));
    TEST_ASSERT_EQUAL_UINT32(255, read32(0x1400, 2));
    TEST_ASSERT_EQUAL_UINT32(2, read32(0x1400, 0));
    TEST_ASSERT_EQUAL_UINT32(5, read32(0x1802, 0));
    TEST_ASSERT_EQUAL_HEX32(0x80000000U, read32(0x1401, 1));
    TEST_ASSERT_EQUAL_HEX32(0x80000000U, read32(0x1800, 1));
    TEST_ASSERT_EQUAL_HEX32(0x80000000U, read32(0x1802, 1));
    TEST_ASSERT_EQUAL_UINT32(255, read32(0x1802, 2));
    TEST_ASSERT_EQUAL_UINT32(0, read32(0x1A02, 0));
    TEST_ASSERT_EQUAL_UINT32(0, read32(0x1A02, 8));
    expect_nothing_for(10000 * MS);
}

static void test_the_whole_sequence_over_the_bus(void)
{
    ask("23 00 14 01 05 02 00 80", "60 00 14 01 00 00 00 00");
    ask("2F 00 16 00 00 00 00 00", "60 00 16 00 00 00 00 00");
    ask("23 00 16 01 10 00 05 20", "60 00 16 01 00 00 00 00");
    ask("2F 00 16 00 01 00 00 00", "60 00 16 00 00 00 00 00");
    ask("2F 00 14 02 FF 00 00 00", "60 00 14 02 00 00 00 00");
    ask("23 00 14 01 05 02 00 00", "60 00 14 01 00 00 00 00");
    ask("40 00 16 01 00 00 00 00", "43 00 16 01 10 00 05 20");
    give(0x205, "CD AB");
    TEST_ASSERT_EQUAL_HEX16(0xABCD, at.variables.u16);
    TEST_ASSERT_EQUAL_UINT(1, at.pdos[0]);
}

static void test_a_pdo_that_exists_is_protected(void)
{
    map_receive();
    write32(0x1600, 0, 0, TUMBLE_ABORT_DEVICE_STATE);
    write32(0x1600, 1, 0x20040008U, TUMBLE_ABORT_DEVICE_STATE);
    write32(0x1400, 1, 0x206, TUMBLE_ABORT_DEVICE_STATE);
    accepted(0x1400, 1, 0x205);       /* the same again */
    accepted(0x1400, 1, 0x80000205U); /* disabled: the mapping is still in use */
    write32(0x1600, 1, 0x20040008U, TUMBLE_ABORT_DEVICE_STATE);
    accepted(0x1600, 0, 0);
    accepted(0x1600, 1, 0x20040008U);
    TEST_ASSERT_EQUAL_HEX32(0x20040008U, read32(0x1600, 1));
    map_transmit(0, 0);
    write32(0x1800, 3, 5, TUMBLE_ABORT_DEVICE_STATE);
    accepted(0x1800, 5, 5);
}

static void test_what_may_not_be_mapped(void)
{
    static const struct {
        uint16_t index;
        uint32_t map;
        uint32_t wanted;
    } cases[] = {
        {0x1600, 0x30000008U, TUMBLE_ABORT_NO_OBJECT},    {0x1600, 0x20050110U, TUMBLE_ABORT_NO_SUBINDEX},
        {0x1600, 0x200D0010U, TUMBLE_ABORT_NOT_MAPPABLE}, /* not mappable at all */
        {0x1600, 0x10010008U, TUMBLE_ABORT_NOT_MAPPABLE}, /* transmit only */
        {0x1A00, 0x00050008U, TUMBLE_ABORT_NOT_MAPPABLE}, /* receive only */
        {0x1600, 0x20050008U, TUMBLE_ABORT_NOT_MAPPABLE}, /* 8 of its 16 bits */
        {0x1600, 0x20050020U, TUMBLE_ABORT_NOT_MAPPABLE}, {0x1600, 0x20050000U, TUMBLE_ABORT_NOT_MAPPABLE},
        {0x1600, 0x00050008U, TUMBLE_ABORT_NONE},         {0x1A00, 0x10010008U, TUMBLE_ABORT_NONE},
        {0x1A00, 0x00000000U, TUMBLE_ABORT_NONE}, /* an empty place */
    };

    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        write32(cases[i].index, 1, cases[i].map, cases[i].wanted);
        TEST_ASSERT_EQUAL_HEX32((cases[i].wanted == TUMBLE_ABORT_NONE) ? cases[i].map : 0U, read32(cases[i].index, 1));
        accepted(cases[i].index, 1, 0);
    }
}

static void test_number_of_mapped_objects(void)
{
    accepted(0x1600, 1, 0x20030020U);
    accepted(0x1600, 2, 0x20060020U);
    accepted(0x1600, 3, 0x20040008U);
    accepted(0x1600, 2 + 2, 0x20040008U);
    write32(0x1600, 0, 3, TUMBLE_ABORT_MAP_LENGTH); /* 9 bytes */
    write32(0x1600, 0, 9, TUMBLE_ABORT_VALUE);
    write32(0x1600, 0, 255, TUMBLE_ABORT_VALUE);
    accepted(0x1600, 3, 0);
    write32(0x1600, 0, 4, TUMBLE_ABORT_NOT_MAPPABLE); /* a hole */
    TEST_ASSERT_EQUAL_UINT32(0, read32(0x1600, 0));
    accepted(0x1600, 0, 2);
    for (uint8_t slot = 1; slot <= 8; slot++) {
        accepted(0x1A00, slot, 0x20040008U);
    }
    accepted(0x1A00, 0, 8);
}

static void test_identifiers(void)
{
    static const struct {
        uint32_t cob_id;
        uint32_t wanted;
    } cases[] = {
        {0x000, TUMBLE_ABORT_VALUE},       {0x001, TUMBLE_ABORT_VALUE},       {0x07F, TUMBLE_ABORT_VALUE},
        {0x100, TUMBLE_ABORT_NONE},        {0x101, TUMBLE_ABORT_VALUE},       {0x180, TUMBLE_ABORT_VALUE},
        {0x181, TUMBLE_ABORT_NONE},        {0x580, TUMBLE_ABORT_NONE},        {0x581, TUMBLE_ABORT_VALUE},
        {0x5FF, TUMBLE_ABORT_VALUE},       {0x600, TUMBLE_ABORT_NONE},        {0x601, TUMBLE_ABORT_VALUE},
        {0x67F, TUMBLE_ABORT_VALUE},       {0x680, TUMBLE_ABORT_NONE},        {0x6DF, TUMBLE_ABORT_NONE},
        {0x6E0, TUMBLE_ABORT_VALUE},       {0x6FF, TUMBLE_ABORT_VALUE},       {0x700, TUMBLE_ABORT_NONE},
        {0x701, TUMBLE_ABORT_VALUE},       {0x7FF, TUMBLE_ABORT_VALUE},       {0x800, TUMBLE_ABORT_VALUE},
        {0x20000205U, TUMBLE_ABORT_VALUE}, {0x80000601U, TUMBLE_ABORT_NONE},  {0xA0000205U, TUMBLE_ABORT_VALUE},
        {0x40000205U, TUMBLE_ABORT_NONE},  {0x80000800U, TUMBLE_ABORT_VALUE},
    };

    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        accepted(0x1400, 1, 0x80000000U);
        write32(0x1400, 1, cases[i].cob_id, cases[i].wanted);
        TEST_ASSERT_EQUAL_HEX32((cases[i].wanted == TUMBLE_ABORT_NONE) ? cases[i].cob_id : 0x80000000U,
                                read32(0x1400, 1));
    }
}

static void test_only_event_driven_types_are_taken(void)
{
    for (uint32_t type = 0; type < 256U; type++) {
        write32(0x1400, 2, type, (type >= 254U) ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_VALUE);
        write32(0x1800, 2, type, (type >= 254U) ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_VALUE);
    }
}

static void test_parameters_that_are_not_there(void)
{
    uint32_t value;
    tumble_pdos_t *pdos = &at.node.pdos;
    const tumble_dictionary_t *dictionary = &at.node.dictionary;
    static const uint16_t indices[] = {0x1402, 0x1602, 0x1805, 0x1A05, 0x15FF, 0x1BFF, 0x1500, 0x1900};

    for (size_t i = 0; i < COUNT_OF(indices); i++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT,
                                tumble_pdo_read_parameter(pdos, dictionary, indices[i], 1, &value));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT, tumble_pdo_write_parameter(pdos, dictionary, indices[i], 1, 0));
    }
    for (int sub = 9; sub < 256; sub++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX,
                                tumble_pdo_read_parameter(pdos, dictionary, 0x1600, (uint8_t)sub, &value));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX,
                                tumble_pdo_write_parameter(pdos, dictionary, 0x1600, (uint8_t)sub, 0));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX,
                                tumble_pdo_read_parameter(pdos, dictionary, 0x1800, (uint8_t)sub, &value));
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX, tumble_pdo_write_parameter(pdos, dictionary, 0x1400, 3, 0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX, tumble_pdo_write_parameter(pdos, dictionary, 0x1400, 5, 0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX, tumble_pdo_write_parameter(pdos, dictionary, 0x1800, 4, 0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_READ_ONLY, tumble_pdo_write_parameter(pdos, dictionary, 0x1800, 0, 0));
}

static void test_configure_replaces_what_was_there(void)
{
    map_transmit(700, 0);
    TEST_ASSERT_EQUAL_UINT32(700, read32(0x1800, 3));
    TEST_ASSERT_EQUAL_HEX32(0x20030020U, read32(0x1A00, 2));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, configure(TUMBLE_PDO_TRANSMIT, 0, &setup));
    TEST_ASSERT_EQUAL_HEX32(0x40000385U, read32(0x1800, 1));
    TEST_ASSERT_EQUAL_UINT32(255, read32(0x1800, 2));
    TEST_ASSERT_EQUAL_UINT32(0, read32(0x1800, 3));
    TEST_ASSERT_EQUAL_UINT32(20, read32(0x1800, 5));
    TEST_ASSERT_EQUAL_UINT32(2, read32(0x1A00, 0));
    expect_next(0x385, "00 00 00 00 00 00");
    tumble_pdo_setup_t inward = setup;
    inward.cob_id = 0x395;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, configure(TUMBLE_PDO_RECEIVE, 1, &inward));
    TEST_ASSERT_TRUE(hand(0x395, "34 12 FE FF FF FF"));
    TEST_ASSERT_EQUAL_UINT(1, at.pdos[1]);
    TEST_ASSERT_EQUAL_UINT32(0, read32(0x1801, 5)); /* nor is the transmit PDO of that number touched */
}

/* A PDO of ours under the identifier of another would be taken for it: a state for a controlword. */
static void test_an_identifier_that_another_pdo_has_is_refused(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, configure(TUMBLE_PDO_TRANSMIT, 0, &setup));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, configure(TUMBLE_PDO_TRANSMIT, 1, &setup));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, configure(TUMBLE_PDO_RECEIVE, 0, &setup));
    accepted(0x1801, 1, 0x80000385U); /* not in use it may have it */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE,
                            tumble_pdo_write_parameter(&at.node.pdos, &at.node.dictionary, 0x1801, 1, 0x385));
    accepted(0x1800, 1, 0xC0000385U);
    accepted(0x1801, 1, 0x385); /* it is free now */
}

static void test_a_new_inhibit_time_counts_from_now(void)
{
    map_transmit(50000, 0); /* 5 s */
    expect_next(0x185, "00 00 00 00 00 00");
    accepted(0x1800, 1, 0xC0000185U);
    accepted(0x1800, 3, 10);
    accepted(0x1800, 1, 0x40000185U);
    expect_next(0x185, "00 00 00 00 00 00");
}

static void test_a_refused_configuration_leaves_the_pdo_invalid(void)
{
    tumble_pdo_setup_t bad[7];

    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        bad[i] = setup;
    }
    bad[0].cob_id = 0x601;
    bad[1].type = 1;
    bad[2].map[1] = 0x20030010U;
    bad[3].map[1] = 0x30030010U;
    bad[4].count = 9;
    bad[5].count = 3;
    bad[5].map[2] = 0x20060020U; /* 10 bytes */
    bad[6].count = 255;
    for (size_t i = 0; i < COUNT_OF(bad); i++) {
        map_receive();
        TEST_ASSERT_NOT_EQUAL(TUMBLE_ABORT_NONE, configure(TUMBLE_PDO_RECEIVE, 0, &bad[i]));
        TEST_ASSERT_EQUAL_HEX32(0x80000000U, read32(0x1400, 1) & 0x80000000U);
        TEST_ASSERT_FALSE(hand(0x205, "34 12 FE FF FF FF"));
        TEST_ASSERT_FALSE(hand(0x385, "34 12 FE FF FF FF"));
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_MAP_LENGTH, configure(TUMBLE_PDO_RECEIVE, 0, &bad[4]));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT, configure(TUMBLE_PDO_RECEIVE, 2, &setup));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT, configure(TUMBLE_PDO_TRANSMIT, TUMBLE_MAX_TRANSMIT_PDOS, &setup));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT, configure(TUMBLE_PDO_TRANSMIT, 255, &setup));
}

/* Random writes of all PDO parameters: a PDO that exists always has a mapping of at most 8 bytes of mappable objects.
 * */
static void test_random_writes_never_leave_a_broken_mapping(void)
{
    static const uint16_t bases[] = {0x1400, 0x1401, 0x1600, 0x1601, 0x1800, 0x1802, 0x1A00, 0x1A02};
    uint32_t seed = 4711;

    for (int i = 0; i < 200000; i++) {
        const tumble_entry_t *entry;
        uint16_t index;
        uint32_t value;

        seed = (seed * 1664525U) + 1013904223U;
        index = bases[(seed >> 8) % COUNT_OF(bases)];
        entry = &fixture_entries[(seed >> 16) % fixture_table.count];
        value = TUMBLE_MAP(entry->index, entry->subindex, entry->size * 8U);
        value = ((seed >> 11) % 4U == 0U) ? (seed >> 28) : value;
        if ((index & 0x0200U) == 0U) {
            value = ((seed >> 27) == 0U) ? seed : (0x200U | ((seed << 4) & 0x80000000U));
        }
        (void)tumble_pdo_write_parameter(&at.node.pdos, &at.node.dictionary, index, (uint8_t)((seed >> 13) % 10U),
                                         value);
        for (size_t p = 0; p < TUMBLE_MAX_RECEIVE_PDOS + TUMBLE_MAX_TRANSMIT_PDOS; p++) {
            bool receive = p < TUMBLE_MAX_RECEIVE_PDOS;
            const tumble_pdo_t *pdo =
                receive ? &at.node.pdos.receive[p] : &at.node.pdos.transmit[p - TUMBLE_MAX_RECEIVE_PDOS].pdo;
            unsigned bytes = 0;

            TEST_ASSERT_LESS_OR_EQUAL(TUMBLE_MAX_MAPPED, pdo->count);
            for (uint8_t slot = 0; slot < pdo->count; slot++) {
                entry = &fixture_entries[pdo->place[slot]];
                bytes += entry->size;
                TEST_ASSERT_TRUE(entry->access & (receive ? TUMBLE_ACCESS_MAP_RECEIVE : TUMBLE_ACCESS_MAP_TRANSMIT));
            }
            TEST_ASSERT_EQUAL_UINT(pdo->length, bytes);
            TEST_ASSERT_LESS_OR_EQUAL(8, bytes);
        }
    }
}

static const around_t around_each = {fixture_operational, fixture_end};
