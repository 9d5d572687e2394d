/* The commissioning record: what went in comes out, to the bit, and nothing else does. */
#include "configuration.h"
#include "navcomp/standard.h"
#include "suite.h"
#include "world/config.h"

#include <stddef.h>
#include <string.h>

static bench_config_t bench;
static tumble_navcomp_config_t config;
static zcu102_commissioned_t before;
static zcu102_commissioned_t after;
static uint8_t record[ZCU102_COMMISSIONING_BYTES];
static uint8_t again[ZCU102_COMMISSIONING_BYTES];
static size_t size;

static void set_up(void)
{
    bench_config_defaults(&bench);
    TEST_ASSERT_NULL(bench_config_complete(&bench));
    config = (tumble_navcomp_config_t){.procedure = &bench.procedure,
                                       .stand = &tumble_drive402_kind,
                                       .stand_profile = &bench.profile,
                                       .heartbeat_ms = 123,
                                       .heartbeat_timeout_ms = 4567};
    memset(record, 0, sizeof record);
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commission(&before, &config));
    size = zcu102_commissioning_write(&before, record);
}

/* Fill every field with something of its own: two that are mixed up, or one that is left out, shows. */
static void fill(void *at, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++) {
        ((uint8_t *)at)[i] = (uint8_t)(37U * i + 11U);
    }
}

static void test_what_goes_in_comes_out(void)
{
    TEST_ASSERT_TRUE(size > 1000U && size < ZCU102_COMMISSIONING_BYTES);
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commissioning_read(&after, record));
    TEST_ASSERT_EQUAL_size_t(size, zcu102_commissioning_write(&after, again));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(record, again, size);
    TEST_ASSERT_EQUAL_UINT32(before.block_period_us, after.block_period_us);
    TEST_ASSERT_EQUAL_UINT16(123, after.heartbeat_ms);
    TEST_ASSERT_EQUAL_UINT16(4567, after.heartbeat_timeout_ms);
    TEST_ASSERT_EQUAL_PTR(&after.schedule, after.procedure.schedule);
    TEST_ASSERT_EQUAL_PTR(&after.averaging, after.procedure.averaging);
    TEST_ASSERT_EQUAL_MEMORY(tumble_schedule_paper.positions, after.positions, 18U * sizeof after.positions[0]);
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_procedure_validate(&after.procedure, NULL));
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_drive402_validate(&after.drive, 1));
}

/* Numbers and times of the procedure, by their place in memory: bytes between the fields do not count. */
static void test_no_field_is_left_out(void)
{
    fill(&before.procedure.samples,
         offsetof(tumble_procedure_config_t, motion_margin_ms) + 4U - offsetof(tumble_procedure_config_t, samples));
    fill(&before.averaging, sizeof before.averaging);
    (void)zcu102_commissioning_write(&before, record);
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commissioning_read(&after, record));
    TEST_ASSERT_EQUAL_MEMORY(&before.averaging, &after.averaging, sizeof before.averaging);
#define SAME(field) TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&before.field, &after.field, sizeof after.field, #field)
    SAME(procedure.samples);
    SAME(procedure.error_budget_v);
    SAME(procedure.v_per_count);
    SAME(procedure.nominal_scale_v_per_g);
    SAME(procedure.gravity_limit_g);
    SAME(procedure.closure_limit_g);
    SAME(procedure.position_tolerance_deg);
    SAME(procedure.approach_deg);
    SAME(procedure.cable_min_deg);
    SAME(procedure.cable_max_deg);
    SAME(procedure.settle_ms);
    SAME(procedure.max_corrupted);
    SAME(procedure.retries);
    SAME(procedure.warm_up_band_half_c);
    SAME(procedure.warm_up_samples);
    SAME(procedure.preflight_timeout_ms);
    SAME(procedure.warm_up_timeout_ms);
    SAME(procedure.mounting_timeout_ms);
    SAME(procedure.home_timeout_ms);
    SAME(procedure.move_timeout_ms);
    SAME(procedure.settle_timeout_ms);
    SAME(procedure.average_timeout_ms);
    SAME(procedure.sample_timeout_ms);
    SAME(procedure.motion_margin_ms);
    SAME(receive[0].setup.map);
    SAME(transmit[0].setup.map);
    SAME(transmit[0].setup.event_ms);
    SAME(drive.counts_per_revolution);
    SAME(drive.homing_acceleration_deg_s2);
    SAME(drive.stop_timeout_ms);
    SAME(drive.homing_method);
    SAME(drive.homing_travel_deg);
    SAME(drive.software_limits);
    SAME(drive.keeps_pdos);
    SAME(drive.acknowledges_enabling);
}

/* Else the block would be asked for again at each inclination. Another bolting is another record. */
static void test_a_block_stays_bolted_on(void)
{
    bench.scenario.schedule = tumble_schedule_inclined;
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commission(&before, &config));
    size = zcu102_commissioning_write(&before, record);
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commissioning_read(&after, record));
    TEST_ASSERT_EQUAL_UINT8(2, tumble_schedule_count_bolted(&after.schedule));
    before.mountings[2].bolting = 2;
    TEST_ASSERT_EQUAL_size_t(size, zcu102_commissioning_write(&before, again));
    TEST_ASSERT_TRUE(memcmp(record, again, size) != 0);
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commissioning_read(&after, again));
    TEST_ASSERT_EQUAL_UINT8(1, tumble_schedule_count_bolted(&after.schedule));
}

static void put_u32(uint8_t *at, uint32_t value)
{
    for (unsigned i = 0; i < 4U; i++) {
        at[i] = (uint8_t)(value >> (8U * i));
    }
}

static uint32_t fnv1a(const uint8_t *bytes, size_t count)
{
    uint32_t sum = 2166136261U;
    for (size_t i = 0; i < count; i++) {
        sum = (sum ^ bytes[i]) * 16777619U;
    }
    return sum;
}

/* Records that are out there must be read: no field changes its place. */
static void test_the_record_of_the_standard_stand_is_as_it_always_was(void)
{
    static const uint8_t CHECKSUM[] = {0x1D, 0x4D, 0x7C, 0x93}; /* of its first 1060 bytes, all that there were */
    config.block_period_us = 10000;
    config.heartbeat_ms = 100;
    config.heartbeat_timeout_ms = 500;
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commission(&before, &config));
    (void)zcu102_commissioning_write(&before, record);
    put_u32(&record[8], 1060U - 16U);
    put_u32(&record[12], fnv1a(&record[16], 1060U - 16U));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(CHECKSUM, &record[12], sizeof CHECKSUM);
    memset(&record[1060], 0xFF, sizeof record - 1060U);
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commissioning_read(&after, record));
    TEST_ASSERT_EQUAL_UINT32(0, after.procedure.motion_margin_ms); /* TUMBLE_MOTION_MARGIN_MS */
    TEST_ASSERT_EQUAL_UINT32(before.procedure.sample_timeout_ms, after.procedure.sample_timeout_ms);
}

static void test_every_wrong_bit_is_refused(void)
{
    for (size_t bit = 0; bit < 8U * size; bit++) {
        record[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_EQUAL(TUMBLE_E_CRC, zcu102_commissioning_read(&after, record));
        record[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_commissioning_read(&after, record));
}

static void test_erased_memory_is_no_record(void)
{
    memset(record, 0, sizeof record);
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_EMPTY, zcu102_commissioning_read(&after, record));
    memset(record, 0xFF, sizeof record);
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_EMPTY, zcu102_commissioning_read(&after, record));
    memset(record, 0x5A, sizeof record);
    TEST_ASSERT_EQUAL(TUMBLE_E_CRC, zcu102_commissioning_read(&after, record));
}

static void test_what_does_not_fit_is_refused(void)
{
    config.stand = NULL;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_commission(&after, &config));
    config.stand = &tumble_drive402_kind;
    bench.profile.write_count = ZCU102_MAX_WRITES + 1U;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, zcu102_commission(&after, &config));
}

static void test_without_a_record_the_board_has_what_is_built_in(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, zcu102_configure(&config, &after));
    TEST_ASSERT_EQUAL_PTR(&tumble_standard_procedure, config.procedure);
    TEST_ASSERT_EQUAL_PTR(&tumble_standard_drive, config.stand_profile);
    TEST_ASSERT_EQUAL_UINT8(ZCU102_CAN_FILTERS, zcu102_can_for(&config).filter_count);
}

static void test_filters_open_for_a_drive_with_other_process_data(void)
{
    before.transmit[0].setup.cob_id = 0x2A2;
    config.stand_profile = &before.drive;
    TEST_ASSERT_NULL(zcu102_can_for(&config).filters);
}
