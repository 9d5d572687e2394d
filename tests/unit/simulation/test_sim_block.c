/* The block as a node: when it streams, what its two frames carry, and what its faults do to them. */
#include "simulation/block.h"
#include "support.h"

#include <string.h>

enum { BLOCK = 0, LISTENER = 1 };

static sim_clock_t virtual_clock;
static sim_wire_t wire;
static sim_bus_t bus;
static sim_angle_error_t angle_error;
static sim_axis_t axis;
static sim_axis_config_t axis_config = {.resolution_deg = 0.001};
static sim_block_config_t config;
static sim_scenario_t scenario;
static sim_block_t block;

/* What was heard of the block. */
#define MAX_FRAMES 2000
static tumble_can_frame_t heard[MAX_FRAMES];
static uint64_t heard_us[MAX_FRAMES];
static uint32_t heard_count;
static uint32_t heartbeats;

static void tap(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    (void)context;
    if (sender == BLOCK && (frame->id == 0x683U || frame->id == 0x693U)) {
        TEST_ASSERT_TRUE(heard_count < MAX_FRAMES);
        heard_us[heard_count] = time_us;
        heard[heard_count++] = *frame;
    }
    heartbeats += (frame->id == 0x703U) ? 1U : 0U;
}

static void set_up(void)
{
    sim_geometry_t geometry;
    sim_scenario_defaults(&scenario);
    config = scenario.block;
    sim_wire_init(&wire);
    sim_clock_init(&virtual_clock);
    sim_bus_init(&bus, &virtual_clock, &wire, 500000);
    bus.tap = tap;
    sim_angle_error_init(&angle_error, 1, &tumble_schedule_paper, SIM_LAW_SIGMA1, 0.0);
    sim_axis_init(&axis, &axis_config, &angle_error, 0.0);
    memcpy(config.sensor.k_v_per_g, (double[3][3]){{-2.0, 0.0, 0.0}, {0.0, -2.0, 0.0}, {0.0, 0.0, -2.0}},
           sizeof config.sensor.k_v_per_g);
    sim_block_init(&block, &config, &config.sensor, 5, &virtual_clock, &bus, BLOCK, &axis);
    sim_bus_attach(&bus, LISTENER, SIM_ACTOR_NAVCOMP);
    sim_geometry_init(&geometry, &tumble_schedule_paper.mountings[0], &(sim_seat_t){0});
    sim_block_mount(&block, &geometry);
    heard_count = 0;
    heartbeats = 0;
}

static void run_until(uint64_t limit_us)
{
    sim_actor_t actor;
    tumble_can_frame_t frame;
    sim_clock_set(&virtual_clock, SIM_ACTOR_OPERATOR, limit_us); /* so that time gets there */
    while (sim_clock_next(&virtual_clock, limit_us, &actor)) {
        if (actor == SIM_ACTOR_BUS) {
            sim_bus_on_alarm(&bus);
        } else if (actor == SIM_ACTOR_BLOCK) {
            sim_block_on_alarm(&block);
        } else if (actor == SIM_ACTOR_NAVCOMP) {
            (void)sim_bus_receive(&bus, LISTENER, &frame);
        }
    }
}

static void command(uint8_t what)
{
    const tumble_can_frame_t frame = {.id = 0, .length = 2, .data = {what, 3}};
    ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, LISTENER, &frame));
}

/* Boot up, start, and stream until `limit_us`. */
static void stream_until(uint64_t limit_us)
{
    run_until(1000);
    command(1);
    run_until(limit_us);
}

/* The layout of docs/bus/block.dbc, read bit by bit. */
static int32_t bits_of(const tumble_can_frame_t *frame, int first, int count, bool is_signed)
{
    int64_t value = 0;
    for (int i = 0; i < count; i++) {
        const int bit = first + i;
        value |= (int64_t)(frame->data[bit / 8] >> (bit % 8) & 1) << i;
    }
    if (is_signed && (value >> (count - 1) & 1) != 0) {
        value -= (int64_t)1 << count;
    }
    return (int32_t)value;
}

/* CRC-8 of docs/bus, bit by bit: 0x2F, initial and final 0xFF, over the identifier's low byte and bytes 0 to 6. */
static uint8_t checksum_of(const tumble_can_frame_t *frame)
{
    uint32_t crc = 0xFF;
    for (int n = -1; n < 7; n++) {
        crc ^= (n < 0) ? frame->id & 0xFFU : frame->data[n];
        for (int bit = 0; bit < 8; bit++) {
            crc = ((crc << 1) ^ (((crc & 0x80U) != 0U) ? 0x2FU : 0U)) & 0xFFU;
        }
    }
    return (uint8_t)(crc ^ 0xFFU);
}

static uint8_t counter_of(uint32_t sample)
{
    return heard[2U * sample].data[6];
}

static void test_it_streams_while_operational_and_no_longer(void)
{
    run_until(500000);
    TEST_ASSERT_EQUAL_UINT32(0, heard_count);
    TEST_ASSERT_UINT32_WITHIN(1, 5, heartbeats); /* boot-up, then every 100 ms */
    command(1);
    run_until(1500000);
    TEST_ASSERT_UINT32_WITHIN(2, 200, heard_count);
    const uint32_t until_stop = heard_count;
    command(2);
    run_until(2500000);
    TEST_ASSERT_TRUE(heard_count <= until_stop + 1U);
}

static void test_one_sample_is_two_frames_in_order(void)
{
    stream_until(1000000);
    for (uint32_t n = 0; n + 1U < heard_count; n += 2) {
        TEST_ASSERT_EQUAL_HEX16(0x683, heard[n].id);
        TEST_ASSERT_EQUAL_HEX16(0x693, heard[n + 1].id);
        TEST_ASSERT_EQUAL_UINT8(8, heard[n].length);
        TEST_ASSERT_EQUAL_UINT8(8, heard[n + 1].length);
        TEST_ASSERT_EQUAL_HEX8(checksum_of(&heard[n]), heard[n].data[7]);
        TEST_ASSERT_EQUAL_HEX8(checksum_of(&heard[n + 1]), heard[n + 1].data[7]);
        TEST_ASSERT_EQUAL_UINT8(n / 2U, heard[n].data[6]);
        TEST_ASSERT_EQUAL_UINT8((n + 1U) & 0xFFU, heard[n + 1].data[3]); /* 2 counter + 1 */
    }
    TEST_ASSERT_UINT64_WITHIN(2, 10000, heard_us[4] - heard_us[2]);
}

/* At rest at 0 degrees, 2 V/g, 10 V over 2^23 counts: z shows -2 V, x and y nothing but noise of 3e-4 V (252 counts).
 */
static void test_the_frames_carry_the_sample(void)
{
    stream_until(300000);
    for (uint32_t n = 0; n + 1U < heard_count; n += 2) {
        const tumble_can_frame_t *const z = &heard[n + 1];
        TEST_ASSERT_INT32_WITHIN(1500, 0, bits_of(&heard[n], 0, 24, true));
        TEST_ASSERT_INT32_WITHIN(1500, 0, bits_of(&heard[n], 24, 24, true));
        TEST_ASSERT_INT32_WITHIN(1500, -1677722, bits_of(z, 0, 24, true));
        TEST_ASSERT_EQUAL_INT32(0, bits_of(z, 44, 4, false));
        TEST_ASSERT_EQUAL_INT32(50, bits_of(z, 48, 8, true)); /* 25 degrees */
        const int32_t taken_ms = bits_of(z, 32, 12, false);
        TEST_ASSERT_INT32_WITHIN(1, (int32_t)(heard_us[n + 1] / 1000U), taken_ms);
    }
}

static void test_every_pattern_of_counts_is_encoded(void)
{
    dice_t dice = {8};
    static const int32_t EDGES[] = {0, 1, -1, 8388607, -8388607, 8388606, 65536, -65536, 255, -256};
    for (int n = 0; n < 20000; n++) {
        tumble_block_sample_t sample;
        int32_t *const counts = sample.raw.counts;
        for (int i = 0; i < 3; i++) {
            counts[i] = (dice_below(&dice, 3) == 0U) ? EDGES[dice_below(&dice, COUNT_OF(EDGES))]
                                                     : dice_between(&dice, -8388607, 8388607);
        }
        sample.raw.counter = (uint16_t)dice_below(&dice, 65536);
        sample.timestamp_ms = (uint16_t)dice_below(&dice, 65536);
        sample.raw.status = (uint8_t)dice_below(&dice, 16);
        sample.temperature_half_c = (int8_t)dice_between(&dice, -128, 127);
        sim_block_frames_t frames;
        sim_block_encode(&sample, &frames);
        TEST_ASSERT_EQUAL_INT32(counts[0], bits_of(&frames.xy, 0, 24, true));
        TEST_ASSERT_EQUAL_INT32(counts[1], bits_of(&frames.xy, 24, 24, true));
        TEST_ASSERT_EQUAL_INT32(sample.raw.counter % 256U, bits_of(&frames.xy, 48, 8, false));
        TEST_ASSERT_EQUAL_INT32(counts[2], bits_of(&frames.z, 0, 24, true));
        TEST_ASSERT_EQUAL_INT32((2U * sample.raw.counter + 1U) % 256U, bits_of(&frames.z, 24, 8, false));
        TEST_ASSERT_EQUAL_INT32(sample.timestamp_ms % 4096U, bits_of(&frames.z, 32, 12, false));
        TEST_ASSERT_EQUAL_INT32(sample.raw.status, bits_of(&frames.z, 44, 4, false));
        TEST_ASSERT_EQUAL_INT32(sample.temperature_half_c, bits_of(&frames.z, 48, 8, true));
        TEST_ASSERT_EQUAL_HEX8(checksum_of(&frames.xy), frames.xy.data[7]);
        TEST_ASSERT_EQUAL_HEX8(checksum_of(&frames.z), frames.z.data[7]);
    }
}

/* The force is felt where the table is, not where it was when the block last looked. */
static void test_it_follows_the_table(void)
{
    static const sim_axis_dynamics_t DYNAMICS = {90.0, 180.0, 180.0};
    stream_until(300000);
    sim_axis_move(&axis, virtual_clock.now_us, 90.0, &DYNAMICS);
    run_until(4000000);
    const tumble_can_frame_t *const last_xy = &heard[heard_count - 2U];
    TEST_ASSERT_INT32_WITHIN(1500, -1677722, bits_of(last_xy, 0, 24, true));
    sim_axis_slip(&axis, 90.0, false);
    sim_block_disturb(&block);
    run_until(4100000);
    TEST_ASSERT_INT32_WITHIN(1500, 1677722, bits_of(&heard[heard_count - 1U], 0, 24, true));
}

static void test_lost_samples_leave_a_gap(void)
{
    stream_until(205000);
    const uint32_t before = heard_count / 2U;
    block.faults[SIM_FAULT_LOST_SAMPLES].count = 3;
    run_until(405000);
    TEST_ASSERT_EQUAL_UINT8(before - 1U, counter_of(before - 1U));
    TEST_ASSERT_EQUAL_UINT8(before + 3U, counter_of(before));
}

static void test_repeated_samples_come_twice(void)
{
    stream_until(205000);
    const uint32_t before = heard_count / 2U;
    block.faults[SIM_FAULT_REPEATED_SAMPLES].count = 1;
    run_until(405000);
    TEST_ASSERT_EQUAL_MEMORY(&heard[2U * before], &heard[2U * before + 2U], 2U * sizeof heard[0]);
    TEST_ASSERT_EQUAL_UINT8(before + 1U, counter_of(before + 2U));
}

static void test_a_reordered_sample_comes_behind_the_next(void)
{
    stream_until(205000);
    const uint32_t before = heard_count / 2U;
    block.faults[SIM_FAULT_REORDERED_SAMPLES].count = 1;
    run_until(405000);
    TEST_ASSERT_EQUAL_UINT8(before + 1U, counter_of(before));
    TEST_ASSERT_EQUAL_UINT8(before, counter_of(before + 1U));
    TEST_ASSERT_EQUAL_UINT8(before + 2U, counter_of(before + 2U));
}

static void test_a_spoilt_sample_has_a_wrong_checksum(void)
{
    stream_until(205000);
    const uint32_t before = heard_count;
    block.faults[SIM_FAULT_WRONG_CRC].count = 2;
    run_until(405000);
    uint32_t wrong = 0;
    for (uint32_t n = 0; n < heard_count; n++) {
        wrong += (checksum_of(&heard[n]) != heard[n].data[7]) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(2, wrong);
    TEST_ASSERT_TRUE(checksum_of(&heard[before + 1U]) != heard[before + 1U].data[7]);
}

static void test_a_mute_block_keeps_its_heartbeat(void)
{
    stream_until(205000);
    const uint32_t before = heard_count;
    const uint32_t beats = heartbeats;
    block.faults[SIM_FAULT_NO_SAMPLES].on = true;
    run_until(1205000);
    TEST_ASSERT_EQUAL_UINT32(before, heard_count);
    TEST_ASSERT_EQUAL_UINT32(beats + 10U, heartbeats);
}

static void test_status_bits_are_set(void)
{
    block.faults[SIM_FAULT_STATUS].value = 6;
    stream_until(205000);
    TEST_ASSERT_EQUAL_INT32(6, bits_of(&heard[1], 44, 4, false));
    block.faults[SIM_FAULT_STATUS].value = 0;
    block.sensor.faults[SIM_FAULT_SATURATED].channels = 1;
    run_until(305000);
    TEST_ASSERT_EQUAL_INT32(1, bits_of(&heard[heard_count - 1U], 44, 4, false));
}

/* Boots, waits to be started, counts from the beginning, its clock starts again. */
static void test_a_power_cycle_starts_it_afresh(void)
{
    stream_until(305000);
    sim_block_set_power(&block, false);
    run_until(405000);
    const uint32_t before = heard_count;
    sim_block_set_power(&block, true);
    run_until(505000);
    TEST_ASSERT_EQUAL_UINT32(before, heard_count);
    command(1);
    run_until(605000);
    TEST_ASSERT_EQUAL_UINT8(0, heard[before].data[6]);
    TEST_ASSERT_INT32_WITHIN(2, 105, bits_of(&heard[before + 1U], 32, 12, false));
}

static void test_the_sample_rate_can_be_written(void)
{
    stream_until(205000);
    const tumble_can_frame_t write = {.id = 0x603, .length = 8, .data = {0x2B, 0x00, 0x20, 0x00, 200, 0, 0, 0}};
    ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, LISTENER, &write));
    run_until(255000);
    const uint32_t before = heard_count;
    run_until(1255000);
    TEST_ASSERT_UINT32_WITHIN(2, before + 400U, heard_count);
}
