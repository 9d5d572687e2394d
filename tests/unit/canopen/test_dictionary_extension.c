/* A second table behind the first: found, read, written, limited and mapped like the first, by hooks of its own. */
#include "canopen_fixture.h"

typedef struct {
    uint32_t large;
    char text[4];
} further_constants_t;

static const further_constants_t further_constants = {0xCAFE0001U, "abc"};

/* Other limits at the places that the first table's limits have. */
static const tumble_limit_t further_limits[] = {{0.0, 7.0}, {-0.5, 0.5}};

#define COMPUTED(index, sub, type, access, size, limit, offset, subs, objects)                                         \
    {index, sub, type, TUMBLE_HOME_COMPUTED, access, size, limit, objects, subs, offset, 0}

static const tumble_entry_t further_entries[] = {
    {0x3000, 0, U32, TUMBLE_HOME_CONSTANT, RO, 4, 0, 0, 0, offsetof(further_constants_t, large), 0},
    {0x3001, 0, TEXT, TUMBLE_HOME_CONSTANT, RO, 3, 0, 0, 0, offsetof(further_constants_t, text), 0},
    COMPUTED(0x3002, 1, U8, RW | MAPPED, 1, 1, 40, 5, 0),
    COMPUTED(0x3002, 7, TUMBLE_TYPE_REAL64, RW, 8, 2, 60, 0, 0),
    VAR(0x3003, 0, U8, RW | MAPPED, 1, 0, u8),
    OWN(0x1803, 1, U32, RW, 4),
    OWN(0x1803, 5, U16, RW, 2),
    OWN(0x1A03, 0, U8, RW, 1),
};

static tumble_object_table_t first;

static struct {
    uint8_t bytes[8];
    uint16_t offset;
    unsigned reads;
    unsigned writes;
    tumble_abort_t refusal;
} hooked;

static tumble_abort_t further_read(void *context, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    TEST_ASSERT_EQUAL_PTR(&at, context);
    hooked.reads++;
    hooked.offset = entry->offset;
    memcpy(bytes, hooked.bytes, *size);
    return hooked.refusal;
}

static tumble_abort_t further_write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    TEST_ASSERT_EQUAL_PTR(&at, context);
    hooked.writes++;
    hooked.offset = entry->offset;
    if (entry->home == TUMBLE_HOME_COMPUTED) {
        memcpy(hooked.bytes, bytes, size);
    }
    return hooked.refusal;
}

static const tumble_object_hooks_t further_hooks = {.read = further_read, .write = further_write};
static const tumble_object_table_t further_table = {.entries = further_entries,
                                                    .limits = further_limits,
                                                    .constants = &further_constants,
                                                    .count = COUNT_OF(further_entries)};
static const tumble_node_extension_t further = {.objects = {.table = &further_table, .hooks = &further_hooks}};

static tumble_node_config_t config;

static tumble_status_t start_with(const tumble_node_extension_t *extension)
{
    const tumble_node_binding_t binding = {
        .port = &at.fake.port, .variables = &at.variables, .other = &at.other, .context = &at};

    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, fixture_start(&fixture_quiet)); /* for the port and the memory */
    config = (tumble_node_config_t){.table = &first,
                                    .extension = extension,
                                    .defaults = &fixture_quiet,
                                    .hooks = &fixture_hooks,
                                    .events = &fixture_events,
                                    .node = NODE};
    return tumble_node_init(&at.node, &config, &binding);
}

static void set_up(void)
{
    first = fixture_table;
    memset(&hooked, 0, sizeof hooked);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, start_with(&further));
}

static tumble_abort_t get(uint16_t index, uint8_t subindex, uint8_t *bytes, uint8_t *size)
{
    return tumble_node_read(&at.node, index, subindex, bytes, size);
}

static tumble_abort_t put(uint16_t index, uint8_t subindex, const void *bytes, uint8_t size)
{
    return tumble_node_write(&at.node, index, subindex, bytes, size);
}

/* Brute force over the rows of both tables. */
static tumble_abort_t told(uint32_t index, uint32_t subindex)
{
    const tumble_object_table_t *tables[] = {&first, &further_table};
    tumble_abort_t refusal = TUMBLE_ABORT_NO_OBJECT;

    for (size_t t = 0; t < COUNT_OF(tables); t++) {
        for (uint8_t i = 0; i < tables[t]->count; i++) {
            const tumble_entry_t *entry = &tables[t]->entries[i];

            for (uint32_t sub = 0; (sub <= entry->more_subindices) && (index == entry->index); sub++) {
                if (((entry->subindex + sub) == subindex) || (subindex == 0U)) {
                    return TUMBLE_ABORT_NONE;
                }
                refusal = TUMBLE_ABORT_NO_SUBINDEX;
            }
        }
    }
    return refusal;
}

static void test_every_key_of_both_tables_is_found_and_no_other(void)
{
    tumble_entry_t entry;

    for (uint32_t index = 0; index <= 0x3010U; index++) {
        for (uint32_t sub = 0; sub < 12U; sub++) {
            TEST_ASSERT_EQUAL_HEX32(told(index, sub),
                                    tumble_dictionary_find(&at.node.dictionary, (uint16_t)index, (uint8_t)sub, &entry));
        }
    }
}

static void test_places_run_on(void)
{
    uint8_t place = 0;

    TEST_ASSERT_EQUAL_HEX32(0, tumble_dictionary_place(&at.node.dictionary, 0x1000, 0, &place));
    TEST_ASSERT_EQUAL_PTR(&fixture_entries[place], tumble_dictionary_row(&at.node.dictionary, place));
    TEST_ASSERT_EQUAL_HEX32(0, tumble_dictionary_place(&at.node.dictionary, 0x3002, 4, &place));
    TEST_ASSERT_EQUAL_UINT8(first.count + 2U, place);
    TEST_ASSERT_EQUAL_PTR(&further_entries[2], tumble_dictionary_row(&at.node.dictionary, place));
}

static void test_constants_are_the_tables_own(void)
{
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    uint8_t size = 0;

    TEST_ASSERT_EQUAL_HEX32(0, get(0x3000, 0, bytes, &size));
    TEST_ASSERT_EQUAL_HEX32(0xCAFE0001U, tumble_get_u32(bytes));
    TEST_ASSERT_EQUAL_HEX32(0, get(0x3001, 0, bytes, &size));
    TEST_ASSERT_EQUAL_UINT8(3, size);
    TEST_ASSERT_EQUAL_MEMORY("abc", bytes, 3);
    TEST_ASSERT_EQUAL_HEX32(0, get(0x1000, 0, bytes, &size));
    TEST_ASSERT_EQUAL_HEX32(0x00020192U, tumble_get_u32(bytes));
    TEST_ASSERT_EQUAL_HEX32(0, get(0x3002, 0, bytes, &size)); /* the highest subindex, of the object's last row */
    TEST_ASSERT_EQUAL_UINT8(1, size);
    TEST_ASSERT_EQUAL_UINT8(7, bytes[0]);
}

static void test_limits_are_the_tables_own(void)
{
    static const uint8_t seven = 7;
    static const uint8_t eight = 8;
    uint8_t bytes[8];

    TEST_ASSERT_EQUAL_HEX32(0, put(0x3002, 1, &seven, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, put(0x3002, 6, &eight, 1));
    tumble_put_f64(bytes, 0.5);
    TEST_ASSERT_EQUAL_HEX32(0, put(0x3002, 7, bytes, 8));
    tumble_put_f64(bytes, 0.75);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, put(0x3002, 7, bytes, 8));
    TEST_ASSERT_EQUAL_UINT(2, hooked.writes);
    TEST_ASSERT_EQUAL_HEX32(0, put(0x2001, 0, "\xFB", 1)); /* -5, by the first table's first limit */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, put(0x2001, 0, &seven, 1));
}

static void test_hooks_are_the_tables_own(void)
{
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    uint8_t size = 0;

    at.computed = 77;
    hooked.bytes[0] = 5;
    TEST_ASSERT_EQUAL_HEX32(0, get(0x3002, 3, bytes, &size));
    TEST_ASSERT_EQUAL_UINT8(5, bytes[0]);
    TEST_ASSERT_EQUAL_UINT16(42, hooked.offset); /* within the run: two bytes on */
    TEST_ASSERT_EQUAL_HEX32(0, get(0x2010, 0, bytes, &size));
    TEST_ASSERT_EQUAL_UINT8(77, bytes[0]);
    TEST_ASSERT_EQUAL_UINT(1, hooked.reads);
    hooked.refusal = TUMBLE_ABORT_NO_DATA;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, get(0x3002, 3, bytes, &size));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, put(0x3002, 3, "\1", 1));
    TEST_ASSERT_EQUAL_UINT(0, at.writes);
    hooked.refusal = TUMBLE_ABORT_DEVICE_STATE; /* what a variable's own hook refuses is not stored */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, put(0x3003, 0, "\x09", 1));
    TEST_ASSERT_EQUAL_UINT8(0, at.variables.u8);
    hooked.refusal = TUMBLE_ABORT_NONE;
    TEST_ASSERT_EQUAL_HEX32(0, put(0x3003, 0, "\x09", 1));
    TEST_ASSERT_EQUAL_UINT8(9, at.variables.u8);
}

static void test_without_hooks_it_refuses_what_it_cannot_make(void)
{
    static const tumble_node_extension_t bare = {.objects = {.table = &further_table}};
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    uint8_t size = 0;

    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, start_with(&bare));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, get(0x3002, 1, bytes, &size));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_ACCESS, put(0x3002, 1, "\1", 1));
    TEST_ASSERT_EQUAL_HEX32(0, get(0x3000, 0, bytes, &size));
    TEST_ASSERT_EQUAL_UINT(0, hooked.reads + hooked.writes);
}

/* The communication objects of an extension are the node's own: here a fourth transmit PDO that carries its objects. */
static void test_its_objects_can_be_mapped_into_a_pdo(void)
{
    static const uint32_t map[] = {TUMBLE_MAP(0x3002, 4, 8), TUMBLE_MAP(0x2005, 0, 16), TUMBLE_MAP(0x3003, 0, 8)};
    tumble_pdo_setup_t setup = {.cob_id = 0x285, .type = 254, .count = COUNT_OF(map)};

    memcpy(setup.map, map, sizeof map);
    boot_to_operational();
    TEST_ASSERT_EQUAL_HEX32(0,
                            tumble_pdo_configure(&at.node.pdos, &at.node.dictionary, TUMBLE_PDO_TRANSMIT, 3, &setup));
    hooked.bytes[0] = 0xAB;
    at.variables.u16 = 0x1234;
    at.variables.u8 = 0x56;
    expect_next(0x285, "AB 34 12 56");
    TEST_ASSERT_EQUAL_UINT16(43, hooked.offset);
    ask("40 03 18 01 00 00 00 00", "43 03 18 01 85 02 00 00");
    ask("40 03 1A 00 00 00 00 00", "4F 03 1A 00 03 00 00 00");
    setup.cob_id = 0x305;
    TEST_ASSERT_EQUAL_HEX32(0, tumble_pdo_configure(&at.node.pdos, &at.node.dictionary, TUMBLE_PDO_RECEIVE, 0, &setup));
    give(0x305, "07 78 56 21");
    TEST_ASSERT_EQUAL_UINT8(7, hooked.bytes[0]);
    TEST_ASSERT_EQUAL_HEX16(0x5678, at.variables.u16);
    TEST_ASSERT_EQUAL_HEX8(0x21, at.variables.u8);
    setup.map[0] = TUMBLE_MAP(0x3002, 7, 64); /* not mappable, and it is not there a subindex further */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NOT_MAPPABLE,
                            tumble_pdo_configure(&at.node.pdos, &at.node.dictionary, TUMBLE_PDO_TRANSMIT, 3, &setup));
    setup.map[0] = TUMBLE_MAP(0x3002, 8, 64);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX,
                            tumble_pdo_configure(&at.node.pdos, &at.node.dictionary, TUMBLE_PDO_TRANSMIT, 3, &setup));
}

/* Numbered on from those of the defaults, of which `fixture_quiet` has none, or wherever the extension says. */
static void test_its_pdos_are_there_from_power_on(void)
{
    static const tumble_pdo_setup_t setups[TUMBLE_MAX_TRANSMIT_PDOS + 1] = {
        {.cob_id = 0x80000000, .type = 255},
        {.cob_id = 0x280, .type = 254, .count = 1, .map = {TUMBLE_MAP(0x3002, 4, 8)}},
        {.cob_id = 0x80000000, .type = 255},
        {.cob_id = 0x80000000, .type = 255},
        {.cob_id = 0x80000000, .type = 255},
    };
    tumble_node_extension_t extension = further;

    extension.transmit = setups;
    extension.transmit_count = 2;
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, start_with(&extension));
    hooked.bytes[0] = 0xAB;
    boot_to_operational();
    expect(0x285, "AB");
    ask("40 01 18 01 00 00 00 00", "43 01 18 01 85 02 00 00");
    extension.transmit_count = TUMBLE_MAX_TRANSMIT_PDOS;
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, start_with(&extension));
    extension.transmit_count = TUMBLE_MAX_TRANSMIT_PDOS + 1;
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, start_with(&extension));
    extension.transmit_count = 2;
    extension.first_transmit = TUMBLE_MAX_TRANSMIT_PDOS - 2;
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, start_with(&extension));
    boot_to_operational();
    expect(0x285, "AB");
    extension.first_transmit = TUMBLE_MAX_TRANSMIT_PDOS - 1;
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, start_with(&extension));
    extension.first_transmit = UINT8_MAX;
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, start_with(&extension));
    extension.first_transmit = 0;
    extension.transmit_count = 1;
    extension.transmit = NULL;
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, start_with(&extension));
}

static void test_both_tables_together_have_255_entries_at_most(void)
{
    static tumble_entry_t many[UINT8_MAX];
    tumble_object_table_t table = {.entries = many};
    const tumble_node_extension_t extension = {.objects = {.table = &table}};
    const tumble_node_extension_t empty = {.objects = {.table = NULL}};

    for (unsigned i = 0; i < COUNT_OF(many); i++) {
        many[i] =
            (tumble_entry_t){(uint16_t)(0x4000U + i), 0, U8, TUMBLE_HOME_IMMEDIATE, RO, 1, 0, 0, 0, (uint8_t)i, 0};
    }
    table.count = (uint8_t)(UINT8_MAX - first.count);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, start_with(&extension));
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    uint8_t size = 0;
    TEST_ASSERT_EQUAL_HEX32(0, get((uint16_t)(0x4000U + table.count - 1U), 0, bytes, &size));
    TEST_ASSERT_EQUAL_UINT8(table.count - 1U, bytes[0]);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT, get((uint16_t)(0x4000U + table.count), 0, bytes, &size));
    table.count++;
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, start_with(&extension));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, start_with(&empty));
}

static const around_t around_each = {set_up, fixture_end};
