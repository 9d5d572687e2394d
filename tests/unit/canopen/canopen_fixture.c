#include "canopen_fixture.h"

static const constants_t fixture_constants = {0x00020192U, "Tumble test node", "ab", 3.25};

static const tumble_limit_t fixture_limits[] = {{-5.0, 5.0},          {-1000.0, 1000.0}, {-2147483648.0, 2147483647.0},
                                                {10.0, 4000000000.0}, {-1.0, 1.0},       {3.0, 200.0}};

const tumble_entry_t fixture_entries[] = {
    {0x0005, 0, U8, TUMBLE_HOME_IMMEDIATE, WO | TUMBLE_ACCESS_MAP_RECEIVE, 1, 0, 0, 0, 0, 0},
    {0x0007, 0, U32, TUMBLE_HOME_IMMEDIATE, WO | TUMBLE_ACCESS_MAP_RECEIVE, 4, 0, 0, 0, 0, 0},
    {0x1000, 0, U32, TUMBLE_HOME_CONSTANT, RO, 4, 0, 0, 0, offsetof(constants_t, device_type), 0},
    OWN(0x1001, 0, U8, RO | TUMBLE_ACCESS_MAP_TRANSMIT, 1),
    OWN(0x1003, 0, U8, RW, 1),
    OWN(0x1003, 1, U32, RO, 4),
    OWN(0x1003, 2, U32, RO, 4),
    OWN(0x1003, 3, U32, RO, 4),
    OWN(0x1003, 4, U32, RO, 4),
    {0x1005, 0, U32, TUMBLE_HOME_IMMEDIATE, RO, 4, 0, 0, 0, 0x80, 0},
    {0x1008, 0, TEXT, TUMBLE_HOME_CONSTANT, RO, 16, 0, 0, 0, offsetof(constants_t, name), 0},
    {0x1009, 0, TEXT, TUMBLE_HOME_CONSTANT, RO, 2, 0, 0, 0, offsetof(constants_t, version), 0},
    OWN(0x1010, 1, U32, RW, 4), /* claimed by the table, unknown to canopen */
    OWN(0x1014, 0, U32, RO, 4),
    {0x1016, 0, U8, TUMBLE_HOME_IMMEDIATE, RO, 1, 0, 0, 0, 4, 0},
    OWN(0x1016, 1, U32, RW, 4),
    OWN(0x1016, 2, U32, RW, 4),
    OWN(0x1016, 3, U32, RW, 4),
    OWN(0x1016, 4, U32, RW, 4),
    OWN(0x1016, 5, U32, RW, 4), /* one more than there are */
    OWN(0x1017, 0, U16, RW, 2),
    OWN(0x1029, 1, U8, RW, 1),
    OWN(0x1200, 1, U32, RO, 4),
    OWN(0x1200, 2, U32, RO, 4),
    OWN(0x1201, 1, U32, RO, 4),
    OWN(0x1201, 2, U32, RO, 4),
    OWN(0x1280, 1, U32, RO, 4),
    OWN(0x1280, 2, U32, RO, 4),
    OWN(0x1280, 3, U8, RO, 1),
    RECEIVE(0x1400),
    RECEIVE(0x1401),
    MAPPING(0x1600),
    MAPPING(0x1601),
    TRANSMIT(0x1800),
    TRANSMIT(0x1801),
    TRANSMIT(0x1802),
    MAPPING(0x1A00),
    MAPPING(0x1A01),
    MAPPING(0x1A02),
    VAR(0x2000, 0, TUMBLE_TYPE_BOOLEAN, RW, 1, 0, flag),
    VAR(0x2001, 0, TUMBLE_TYPE_INTEGER8, RW, 1, 1, i8),
    VAR(0x2002, 0, TUMBLE_TYPE_INTEGER16, RW, 2, 2, i16),
    VAR(0x2003, 0, TUMBLE_TYPE_INTEGER32, RW | MAPPED, 4, 3, i32),
    VAR(0x2004, 0, U8, RW | MAPPED, 1, 0, u8),
    VAR(0x2005, 0, U16, RW | MAPPED, 2, 0, u16),
    VAR(0x2006, 0, U32, RW | MAPPED, 4, 4, u32),
    VAR(0x2007, 0, TUMBLE_TYPE_REAL32, RW, 4, 5, f32),
    VAR(0x2008, 0, TUMBLE_TYPE_REAL64, RW, 8, 5, f64),
    VAR(0x2009, 0, TUMBLE_TYPE_INTEGER64, RW | MAPPED, 8, 0, i64),
    VAR(0x200A, 0, TUMBLE_TYPE_UNSIGNED64, RW, 8, 0, u64),
    VAR(0x200B, 0, TEXT, RW, 32, 0, text),
    VAR(0x200C, 0, U8, WO, 1, 0, secret),
    VAR(0x200D, 0, U16, RO, 2, 0, u16_ro),
    {0x200E, 0, U8, TUMBLE_HOME_IMMEDIATE, RO, 1, 0, 0, 0, 3, 0},
    VAR(0x200E, 1, U8, RW, 1, 6, record[0]),
    VAR(0x200E, 3, U8, RW, 1, 0, record[1]),
    VAR(0x200F, 0, TUMBLE_TYPE_REAL64, RW, 8, 0, unlimited),
    VAR(0x200F, 1, TUMBLE_TYPE_REAL32, RW, 4, 0, unlimited32),
    VAR(0x200F, 2, U16, RW, 2, 6, limited16),
    {0x2010, 0, U32, TUMBLE_HOME_COMPUTED, RW | MAPPED, 4, 0, 0, 0, 7, 0},
    {0x2011, 0, TEXT, TUMBLE_HOME_COMPUTED, RO, 64, 0, 0, 0, 0, 0},
    {0x2012, 0, TUMBLE_TYPE_REAL64, TUMBLE_HOME_COMPUTED, RO | TUMBLE_ACCESS_MAP_TRANSMIT, 8, 0, 0, 0, 0, 0},
    {0x2013, 0, U16, TUMBLE_HOME_OTHER, RW | MAPPED, 2, 0, 0, 0, offsetof(other_t, other), 0},
    VAR(0x2014, 0, U32, RW | MAPPED, 4, 0, guarded),
    {0x2015, 0, TUMBLE_TYPE_REAL64, TUMBLE_HOME_CONSTANT, RO, 8, 0, 0, 0, offsetof(constants_t, pi), 0},
};

const tumble_object_table_t fixture_table = {
    .entries = fixture_entries,
    .limits = fixture_limits,
    .constants = &fixture_constants,
    .count = COUNT_OF(fixture_entries),
};

fixture_t at;

tumble_abort_t fixture_read(void *context, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size)
{
    const fixture_t *fixture = context;

    if (entry->index == 0x2010U) {
        tumble_put_u32(bytes, fixture->computed);
        return TUMBLE_ABORT_NONE;
    }
    if (entry->index == 0x2011U) {
        *size = (uint8_t)strlen(fixture->sentence);
        memcpy(bytes, fixture->sentence, *size);
        return TUMBLE_ABORT_NONE;
    }
    return TUMBLE_ABORT_NO_DATA;
}

static tumble_abort_t fixture_write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    fixture_t *fixture = context;

    fixture->writes++;
    if (entry->index == 0x2010U) {
        TEST_ASSERT_EQUAL_UINT8(4, size);
        fixture->computed = tumble_get_u32(bytes);
    }
    return ((entry->index == 0x2014U) && (bytes[0] == 13U)) ? TUMBLE_ABORT_DEVICE_STATE : TUMBLE_ABORT_NONE;
}

const tumble_object_hooks_t fixture_hooks = {.read = fixture_read, .write = fixture_write};

static void on_state(void *context, tumble_nmt_state_t state)
{
    (void)state;
    ((fixture_t *)context)->state_changes++;
}

static void on_reset(void *context, bool application)
{
    ((fixture_t *)context)->resets[application]++;
}

static void on_heartbeat(void *context, uint8_t node, tumble_heartbeat_event_t event, tumble_nmt_state_t state)
{
    fixture_t *fixture = context;

    fixture->heartbeats++;
    fixture->heartbeat_node = node;
    fixture->heartbeat_event = event;
    fixture->heartbeat_state = state;
}

static void on_emergency(void *context, uint8_t node, const tumble_emergency_t *emergency)
{
    fixture_t *fixture = context;

    fixture->emergencies++;
    fixture->emergency_node = node;
    fixture->emergency = *emergency;
}

static void on_pdo(void *context, uint8_t number)
{
    ((fixture_t *)context)->pdos[number]++;
}

const tumble_node_events_t fixture_events = {.state_changed = on_state,
                                             .reset = on_reset,
                                             .heartbeat = on_heartbeat,
                                             .emergency = on_emergency,
                                             .pdo_received = on_pdo};

const tumble_node_defaults_t fixture_quiet = {0};

tumble_status_t fixture_start(const tumble_node_defaults_t *defaults)
{
    static tumble_node_config_t config;
    tumble_node_binding_t binding = {
        .port = &at.fake.port, .variables = &at.variables, .other = &at.other, .context = &at};

    memset(&at, 0, sizeof at);
    fake_port_init(&at.fake);
    at.fake.now_us = 1000 * MS;
    config = (tumble_node_config_t){.table = &fixture_table,
                                    .defaults = defaults,
                                    .hooks = &fixture_hooks,
                                    .events = &fixture_events,
                                    .node = NODE};
    return tumble_node_init(&at.node, &config, &binding);
}

void step(void)
{
    tumble_node_step(&at.node, at.fake.now_us);
}

void pass(uint64_t us)
{
    at.fake.now_us += us;
    step();
}

tumble_can_frame_t frame_of(uint16_t id, const char *text)
{
    tumble_can_frame_t frame = {.id = id};
    char *end = NULL;

    for (const char *from = text; *from != '\0'; from = end) {
        frame.data[frame.length] = (uint8_t)strtoul(from, &end, 16);
        frame.length++;
        end += strspn(end, " ");
    }
    return frame;
}

bool hand(uint16_t id, const char *text)
{
    tumble_can_frame_t frame = frame_of(id, text);

    return tumble_node_receive(&at.node, &frame, at.fake.now_us);
}

void give(uint16_t id, const char *text)
{
    (void)hand(id, text);
    step();
}

static void write_frame(char *text, const tumble_can_frame_t *frame)
{
    int length = sprintf(text, "%03X:", frame->id);

    for (int i = 0; i < frame->length; i++) {
        length += sprintf(text + length, " %02X", frame->data[i]);
    }
}

void expect_at(uint16_t id, const char *text, int line)
{
    tumble_can_frame_t wanted = frame_of(id, text);
    tumble_can_frame_t sent;
    char wanted_text[40];
    char sent_text[40] = "nothing";

    write_frame(wanted_text, &wanted);
    if (fake_port_take(&at.fake, &sent)) {
        write_frame(sent_text, &sent);
    }
    UNITY_TEST_ASSERT_EQUAL_STRING(wanted_text, sent_text, (UNITY_LINE_TYPE)line, NULL);
}

void boot(void)
{
    step();
    expect(0x705, "00");
    expect_nothing();
}

void boot_to_operational(void)
{
    boot();
    give(0x000, "01 05");
    TEST_ASSERT_EQUAL_INT(TUMBLE_NMT_OPERATIONAL, tumble_node_state(&at.node));
}

void drain(void)
{
    at.fake.from_firmware.count = 0;
}

tumble_nmt_state_t state(void)
{
    return tumble_node_state(&at.node);
}

void fixture_quietly(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, fixture_start(&fixture_quiet));
}

void fixture_booted(void)
{
    fixture_quietly();
    boot();
}

void fixture_operational(void)
{
    fixture_quietly();
    boot_to_operational();
}

void fixture_beating(void)
{
    static const tumble_node_defaults_t beating = {.heartbeat_ms = 100, .consumers = {0x000201F4U, 0x000301F4U}};
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, fixture_start(&beating));
}

void fixture_end(void)
{
    TEST_ASSERT_FALSE(at.fake.overflowed);
}
