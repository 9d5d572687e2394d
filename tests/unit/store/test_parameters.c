/* Saved parameters: kept, forgotten, put in force under the dictionary's rules; power cuts and a lying memory at every
 * operation, once and twice. The node's table is written here by hand, for the objects that tumble_keeper_saved lists.
 */
#include "core/bytes.h"
#include "core/crc32.h"
#include "fake_port.h"
#include "navcomp/keeper_objects.h"
#include "navcomp/parameters.h"
#include "store_power.h"
#include "suite.h"

#include <stddef.h>
#include <stdio.h>

#define MAX_STEPS 1000

typedef struct {
    double f64[2];
    uint32_t u32[3];
    float f32[37];
    uint16_t u16[2];
    uint8_t u8[6];
} variables_t;

#define RW (TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE)
#define VAR(index, sub, type, size, limit, member, more)                                                               \
    {index, sub, type, TUMBLE_HOME_VARIABLES, RW, size, limit, 0, more, offsetof(variables_t, member), 0}
#define U8 TUMBLE_TYPE_UNSIGNED8
#define U16 TUMBLE_TYPE_UNSIGNED16
#define U32 TUMBLE_TYPE_UNSIGNED32
#define F32 TUMBLE_TYPE_REAL32
#define F64 TUMBLE_TYPE_REAL64

static const tumble_limit_t limits[] = {{0.0, 100.0}};

static const tumble_entry_t entries[] = {
    VAR(0x2050, 1, U32, 4, 0, u32[0], 0),   VAR(0x2050, 2, U8, 1, 1, u8[0], 0),
    VAR(0x2050, 3, U16, 2, 0, u16[0], 0),   VAR(0x2050, 4, U8, 1, 0, u8[1], 0),
    VAR(0x2050, 5, F64, 8, 0, f64[0], 0),   VAR(0x2122, 1, F64, 8, 0, f64[1], 0),
    VAR(0x2122, 2, U32, 4, 0, u32[1], 0),   VAR(0x2122, 3, U32, 4, 0, u32[2], 0),
    VAR(0x2122, 4, U16, 2, 0, u16[1], 0),   VAR(0x2122, 5, U8, 1, 0, u8[2], 0),
    VAR(0x2122, 6, U8, 1, 0, u8[3], 0),     VAR(0x2123, 1, F32, 4, 0, f32[36], 0),
    VAR(0x2123, 2, U8, 1, 0, u8[4], 0),     VAR(0x2124, 1, F32, 4, 0, f32[0], 11),
    VAR(0x2125, 1, F32, 4, 0, f32[12], 11), VAR(0x2126, 1, F32, 4, 0, f32[24], 11)};

static const tumble_object_table_t table = {
    .entries = entries, .limits = limits, .count = sizeof entries / sizeof entries[0]};

static fake_port_t fake;
static variables_t variables;
static tumble_node_t node;
static tumble_store_t store; /* in whose bytes the record lies */
static tumble_parameters_t parameters;
static bool is_fresh; /* just powered on: what is in force is what was found */

/* Values that are all different from those of another pattern, and within their limits. */
static variables_t pattern(uint32_t number)
{
    variables_t made;
    memset(&made, 0, sizeof made);
    for (int i = 0; i < 37; i++) {
        made.f32[i] = (float)(number * 100U) + (float)i;
    }
    for (int i = 0; i < 2; i++) {
        made.f64[i] = 0.1 * (double)(number + (uint32_t)i);
        made.u16[i] = (uint16_t)(number * 1000U + (uint32_t)i);
    }
    for (int i = 0; i < 3; i++) {
        made.u32[i] = number * 1000000U + (uint32_t)i;
    }
    for (int i = 0; i < 5; i++) {
        made.u8[i] = (uint8_t)(number + (uint32_t)i);
    }
    return made;
}

static bool is_pattern(uint32_t number)
{
    const variables_t wanted = pattern(number);
    return memcmp(&wanted, &variables, sizeof wanted) == 0;
}

static bool finish(void)
{
    for (int steps = 0; steps < MAX_STEPS; steps++) {
        if (!tumble_parameters_busy(&parameters)) {
            return true;
        }
        tumble_parameters_step(&parameters);
    }
    return false;
}

/* Power on: variables as the board has them (pattern 0), then what was saved. */
static bool boot(nv_memory_t *memory)
{
    static const tumble_node_defaults_t quiet = {0};
    static const tumble_node_config_t config = {.table = &table, .defaults = &quiet, .node = 1};
    const tumble_node_binding_t binding = {.port = &fake.port, .variables = &variables};
    fake_port_init(&fake);
    variables = pattern(0);
    if (tumble_node_init(&node, &config, &binding) != TUMBLE_OK) {
        return false;
    }
    (void)tumble_store_init(&store, &memory->nv);
    tumble_parameters_init(&parameters, &memory->nv, &node, &store);
    is_fresh = true;
    return finish();
}

/* As an SDO write would: the answer waits for the end of the job. */
static tumble_abort_t answer_to(tumble_abort_t begun)
{
    if (begun != TUMBLE_ABORT_LATER) {
        return begun;
    }
    node.server.transfer = (uint8_t)TUMBLE_SDO_LATER;
    node.server.answer[0] = 0x60U;
    node.server.answer_due = false;
    TEST_ASSERT_TRUE(finish());
    TEST_ASSERT_TRUE(node.server.answer_due);
    return (node.server.answer[0] == 0x60U) ? TUMBLE_ABORT_NONE
                                            : (tumble_abort_t)tumble_get_u32(&node.server.answer[4]);
}

static nv_memory_t memory;

static void set_up(void)
{
    nv_make(&memory, NV_MAX_SECTORS, 8, TUMBLE_STORE_MIN_SECTOR);
    TEST_ASSERT_TRUE(boot(&memory));
}

static void tear_down(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, memory.violations);
}

static void save_pattern(uint32_t number)
{
    variables = pattern(number);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, answer_to(tumble_parameters_save(&parameters)));
}

static void test_the_table_here_is_what_is_saved(void)
{
    TEST_ASSERT_EQUAL_UINT(6, TUMBLE_KEEPER_SAVED);
    unsigned values = 0;
    for (int i = 0; i < TUMBLE_KEEPER_SAVED; i++) {
        for (uint8_t sub = 1; sub <= tumble_keeper_saved[i].count; sub++, values++) {
            tumble_entry_t entry;
            TEST_ASSERT_EQUAL_HEX32(
                0, tumble_dictionary_find(&node.dictionary, tumble_keeper_saved[i].index, sub, &entry));
        }
    }
    TEST_ASSERT_EQUAL_UINT(49, values);
}

static void test_an_erased_memory_leaves_the_boards_values(void)
{
    TEST_ASSERT_TRUE(is_pattern(0));
    TEST_ASSERT_TRUE(tumble_parameters_room(&parameters));
    TEST_ASSERT_EQUAL_UINT32(0, parameters.view.sequence);
    TEST_ASSERT_EQUAL_UINT32(0, parameters.view.applied);
}

static void test_what_was_saved_is_in_force_after_power_on(void)
{
    for (uint32_t i = 1; i <= 7U; i++) {
        save_pattern(i);
        TEST_ASSERT_TRUE(boot(&memory));
        TEST_ASSERT_TRUE(is_pattern(i));
        TEST_ASSERT_EQUAL_UINT32(i, parameters.view.sequence);
        TEST_ASSERT_EQUAL_UINT32(49, parameters.view.applied);
        TEST_ASSERT_EQUAL_UINT32(0, parameters.view.refused);
    }
}

static void test_what_was_forgotten_is_gone_after_power_on_and_not_before(void)
{
    save_pattern(3);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, answer_to(tumble_parameters_forget(&parameters)));
    TEST_ASSERT_TRUE(is_pattern(3));
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_TRUE(is_pattern(0));
    TEST_ASSERT_EQUAL_UINT32(2, parameters.view.sequence);
    save_pattern(4);
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_TRUE(is_pattern(4));
}

/* However many were saved since power-on, each takes the place of the older one. */
static void test_a_save_that_power_cuts_short_leaves_the_one_before(void)
{
    save_pattern(1);
    save_pattern(2);
    nv_arm(&memory, (nv_fault_t){1, DONE_NOTHING, THEN_CUT});
    variables = pattern(3);
    (void)answer_to(tumble_parameters_save(&parameters));
    nv_arm(&memory, nv_no_fault);
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_TRUE(is_pattern(2));
}

static void test_restore_puts_the_saved_values_in_force_again(void)
{
    save_pattern(3);
    variables = pattern(9);
    tumble_parameters_restore(&parameters);
    TEST_ASSERT_TRUE(finish());
    TEST_ASSERT_TRUE(is_pattern(3));
}

/* A reset that comes while something is saved: what was under way goes to its end first. */
static void test_a_restore_waits_for_the_end_of_a_job(void)
{
    save_pattern(3);
    variables = pattern(4);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_LATER, tumble_parameters_save(&parameters));
    tumble_parameters_step(&parameters);
    variables = pattern(0);
    tumble_parameters_restore(&parameters);
    TEST_ASSERT_TRUE(finish());
    TEST_ASSERT_TRUE(is_pattern(4));
    TEST_ASSERT_EQUAL_UINT32(2, parameters.view.sequence);
}

/* Bytes by the description in the header, made here. */
static void test_the_bytes_are_those_described(void)
{
    save_pattern(5);
    const uint8_t *bytes = &memory.bytes[9U * TUMBLE_STORE_MIN_SECTOR]; /* the first one goes to the second sector */
    TEST_ASSERT_EQUAL_MEMORY("TPAR\1\0\374\0\1\0\0\0", bytes, 12);
    TEST_ASSERT_EQUAL_MEMORY("\x50\x20\5\4", &bytes[12], 4);
    TEST_ASSERT_EQUAL_UINT32(5000000, tumble_get_u32(&bytes[16]));
    TEST_ASSERT_EQUAL_UINT8(1, bytes[20]);
    TEST_ASSERT_EQUAL_UINT8(5, bytes[21]);
    TEST_ASSERT_EQUAL_HEX32(tumble_crc32(0, bytes, 284), tumble_get_u32(&bytes[284]));
    TEST_ASSERT_EQUAL_MEMORY("TPARGOODTPARGOODTPARGOODTPARGOOD", &bytes[288], 32);
    TEST_ASSERT_EQUAL_HEX8(0xFF, bytes[320]);
}

/* A record of other firmware: objects that are not there, values out of their limits, lengths that lie. */
static void test_what_the_dictionary_refuses_is_counted_and_left(void)
{
    static const uint8_t values[] = {0x50, 0x20, 3,   4, 1, 0, 0,    0,    1,  101,
                                     2,    7,    0,                                /* 2050h:2 is beyond its limit */
                                     0x77, 0x77, 1,   1, 9,                        /* no such object */
                                     0x22, 0x21, 1,   1, 5,                        /* not that value's length */
                                     0x23, 0x21, 200, 4, 0, 0, 0x80, 0x3F, 99, 0}; /* beyond the end */
    uint8_t record[TUMBLE_PARAMETERS_BYTES] = "TPAR\1";
    tumble_put_u16(&record[6], sizeof values);
    tumble_put_u32(&record[8], 77);
    memcpy(&record[12], values, sizeof values);
    tumble_put_u32(&record[284], tumble_crc32(0, record, 284));
    memcpy(&record[288], "TPARGOODTPARGOODTPARGOODTPARGOOD", 32);
    memcpy(&memory.bytes[8U * TUMBLE_STORE_MIN_SECTOR], record, sizeof record);
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_EQUAL_UINT32(77, parameters.view.sequence);
    TEST_ASSERT_EQUAL_UINT32(3, parameters.view.applied);
    TEST_ASSERT_EQUAL_UINT32(3, parameters.view.refused);
    TEST_ASSERT_EQUAL_UINT32(1, variables.u32[0]);
    TEST_ASSERT_EQUAL_UINT8(0, variables.u8[0]);
    TEST_ASSERT_EQUAL_UINT16(7, variables.u16[0]);
    TEST_ASSERT_TRUE(variables.f32[36] == 1.0F);
}

/* Every bit of a record counts. */
static void test_a_record_with_a_wrong_bit_is_none(void)
{
    save_pattern(1);
    save_pattern(2); /* in the first sector */
    for (uint32_t bit = 0; bit < (TUMBLE_PARAMETERS_BYTES * 8U); bit++) {
        uint8_t *byte = &memory.bytes[(8U * TUMBLE_STORE_MIN_SECTOR) + (bit / 8U)];
        *byte ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_TRUE(boot(&memory));
        TEST_ASSERT_TRUE(is_pattern(1));
        *byte ^= (uint8_t)(1U << (bit % 8U));
    }
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_TRUE(is_pattern(2));
}

static void test_without_room_nothing_is_saved(void)
{
    memory.nv.size_bytes = 9U * TUMBLE_STORE_MIN_SECTOR;
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_FALSE(tumble_parameters_room(&parameters));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_HARDWARE, tumble_parameters_save(&parameters));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_HARDWARE, tumble_parameters_forget(&parameters));
    tumble_parameters_init(&parameters, NULL, &node, &store);
    TEST_ASSERT_FALSE(tumble_parameters_room(&parameters) || tumble_parameters_busy(&parameters));
    tumble_parameters_step(&parameters);
}

static void test_one_job_at_a_time(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_LATER, tumble_parameters_save(&parameters));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, tumble_parameters_forget(&parameters));
    TEST_ASSERT_TRUE(finish());
}

static void test_a_memory_that_is_slow_is_asked_again(void)
{
    memory.busy_each = 5;
    save_pattern(6);
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_TRUE(is_pattern(6));
}

static void test_a_memory_that_cannot_be_read_holds_nothing(void)
{
    save_pattern(6);
    memory.read_fails_at = memory.reads;
    memory.read_fails = 3U * 3U; /* each of them three times */
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_TRUE(is_pattern(0));
    memory.read_fails_at = NV_NEVER;
    TEST_ASSERT_TRUE(boot(&memory));
    TEST_ASSERT_TRUE(is_pattern(6));
}

/* The campaign: pattern 1 is saved, pattern 2 is to be. */

static void prepare(nv_memory_t *prepared, const start_t *start)
{
    (void)start;
    (void)boot(prepared);
    variables = pattern(1);
    (void)answer_to(tumble_parameters_save(&parameters));
}

static tumble_status_t job(void)
{
    variables = pattern(2);
    is_fresh = false;
    return (answer_to(tumble_parameters_save(&parameters)) == TUMBLE_ABORT_NONE) ? TUMBLE_OK : TUMBLE_E_NV;
}

static state_t look(void)
{
    const bool after = parameters.view.sequence > 1U;
    if ((parameters.view.sequence == 0U) || (is_fresh && !is_pattern(after ? 2U : 1U))) {
        return STATE_BAD;
    }
    return after ? STATE_AFTER : STATE_BEFORE;
}

static const scenario_t saving = {"save", prepare, boot, job, look, {0}};
static const done_t all_kinds[] = {DONE_NOTHING,     DONE_ALL,       DONE_QUARTER,    DONE_HALF,      DONE_BUT_LAST,
                                   DONE_SECOND_HALF, DONE_SOME_BITS, DONE_SOME_BYTES, DONE_ANY_VALUES};
static const fault_list_t all_faults = {all_kinds, sizeof all_kinds / sizeof all_kinds[0]};

static void test_no_fault_at_any_operation_leaves_anything_between(void)
{
    static const uint32_t granules[] = {1, 8, 32};
    campaign_t campaign = {.sectors = NV_MAX_SECTORS};
    for (size_t i = 0; i < (sizeof granules / sizeof granules[0]); i++) {
        campaign.granule = granules[i];
        campaign.sector = TUMBLE_STORE_MIN_SECTOR;
        power_scenario(&campaign, &saving, &all_faults, true);
    }
    printf("parameters: %lu cases, %lu bad %s\n", campaign.cases, campaign.bad, campaign.first);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, campaign.bad, campaign.first);
    TEST_ASSERT_TRUE(campaign.cases > 3000U);
}

/* The canary: in this memory a mark is always there, as if it were programmed first. */
static tumble_status_t program_marked(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    nv_memory_t *marked = context;
    if (size == 288U) {
        uint8_t torn[288]; /* and a CRC that is right whatever is torn */
        memcpy(&marked->bytes[offset + 288U], "TPARGOODTPARGOODTPARGOODTPARGOOD", 32);
        memcpy(torn, bytes, sizeof torn);
        memset(&torn[150], 0, 100);
        tumble_put_u32(&torn[284], tumble_crc32(0, torn, 284));
        memcpy(&marked->bytes[offset], torn, sizeof torn);
        marked->is_off = true;
        return TUMBLE_E_NV;
    }
    return nv_program(context, offset, bytes, size);
}

static bool boot_marked(nv_memory_t *marked)
{
    marked->nv.program = program_marked;
    return boot(marked);
}

static void test_the_campaign_finds_a_mixed_record(void)
{
    static const scenario_t marked = {"mark first", prepare, boot_marked, job, look, {0}};
    campaign_t campaign = {.granule = 8, .sector = TUMBLE_STORE_MIN_SECTOR, .sectors = NV_MAX_SECTORS};
    power_scenario(&campaign, &marked, &all_faults, false);
    TEST_ASSERT_TRUE(campaign.bad > 0U);
}
