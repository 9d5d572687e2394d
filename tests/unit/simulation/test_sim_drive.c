/* The simulated drive in its normal life, and the traps of the set-point handshake. */
#include "sim_master.h"

#define COUNTS_PER_DEG 1000
#define REACHED 0x0400U
#define ACKNOWLEDGED 0x1000U

static void set_up(void)
{
    sim_scenario_defaults(&scenario);
    power_on();
    configure();
}

static void test_it_boots_and_tells_what_it_is(void)
{
    TEST_ASSERT_EQUAL_HEX32(0x00020192, sdo_read(0x1000, 0));
    TEST_ASSERT_EQUAL_UINT32(360000, sdo_read(0x608F, 1));
    TEST_ASSERT_EQUAL_UINT8(1, (uint8_t)sdo_read(0x6061, 0));
    TEST_ASSERT_EQUAL_HEX16(0x0040, heard.statusword & 0x004FU); /* Switch on disabled */
}

static void test_power_up_goes_through_all_states(void)
{
    command(0x000F, 0); /* too early */
    expect_status_after(5, 0x0040, 0x004FU);
    command_for(5, 0x0006, 0);
    TEST_ASSERT_EQUAL_HEX16(0x0021, heard.statusword & 0x006FU);
    command_for(5, 0x0007, 0);
    TEST_ASSERT_EQUAL_HEX16(0x0023, heard.statusword & 0x006FU);
    command_for(5, 0x000F, 0);
    TEST_ASSERT_EQUAL_HEX16(0x0027, heard.statusword & 0x006FU);
}

/* From 10 degrees down past the mark, up to it: position 0 is there. */
static void test_homing_finds_the_mark(void)
{
    enable();
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6098, 0, 34, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 6, 1));
    command_for(50, 0x001F, 0);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & 0x3400U); /* under way: neither reached nor attained */
    expect_status_after(20000, 0x1400, 0x3400U);
    TEST_ASSERT_EQUAL_INT32(0, heard.position);
    ASSERT_SAME_DOUBLE(0.0, drive.axis.motion.end_position);
}

static void test_home_offset_is_the_position_at_the_mark(void)
{
    enable();
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x607C, 0, (uint32_t)-2500, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6098, 0, 34, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 6, 1));
    command_for(20000, 0x001F, 0);
    TEST_ASSERT_EQUAL_INT32(-2500, heard.position);
}

/* Method 35: where it stands is home; nothing moves. */
static void test_homing_on_the_spot(void)
{
    enable();
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 6, 1));
    command_for(50, 0x001F, 0);
    TEST_ASSERT_EQUAL_HEX16(0x1400, heard.statusword & 0x3400U);
    ASSERT_SAME_DOUBLE(10.0, drive.axis.motion.end_position);
}

static void test_a_move_reaches_its_target(void)
{
    enable_and_home();
    set_target(45 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & REACHED);
    expect_status_after(2000, REACHED, REACHED);
    TEST_ASSERT_EQUAL_INT32(45000, heard.position);
    ASSERT_SAME_DOUBLE(45.0, drive.axis.motion.end_position);
}

/* 45 degrees at 90 deg/s and 180 deg/s2 take 1 s; the swing of 0.02 degrees is within the window of 0.01 after
 * ln 2 / ln 1000 of 0.5 s; then 20 ms of window time, then the reaction time. */
static void test_target_reached_comes_when_the_window_says_so(void)
{
    enable_and_home();
    const uint64_t start_us = virtual_clock.now_us;
    set_target(45 * COUNTS_PER_DEG);
    const uint64_t earliest_us = start_us + 1000000U + 50171U + 20000U;
    pass_until(earliest_us - 1000U);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & REACHED);
    pass_until(earliest_us + 15000U);
    TEST_ASSERT_EQUAL_HEX16(REACHED, heard.statusword & REACHED);
}

/* The trap: target and edge in one frame take the target of the frame before. */
static void test_a_target_in_the_frame_of_the_edge_is_stale(void)
{
    enable_and_home();
    command(0x000F, 30 * COUNTS_PER_DEG);
    command_for(3000, 0x001F, 60 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_INT32(30 * COUNTS_PER_DEG, heard.position);
}

static void test_a_forgiving_drive_takes_the_target_of_the_same_frame(void)
{
    sim_scenario_defaults(&scenario);
    scenario.drive.latches_stale_target = false;
    power_on();
    configure();
    enable_and_home();
    command_for(3000, 0x001F, 60 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_INT32(60 * COUNTS_PER_DEG, heard.position);
}

/* Without an edge nothing happens, however often the target changes. */
static void test_a_set_point_needs_an_edge(void)
{
    enable_and_home();
    command_for(1000, 0x000F, 30 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_INT32(0, heard.position);
    command(0x001F, 30 * COUNTS_PER_DEG); /* the edge */
    command(0x001F, 60 * COUNTS_PER_DEG); /* bit 4 stays: none */
    pass_ms(3000);
    TEST_ASSERT_EQUAL_INT32(30 * COUNTS_PER_DEG, heard.position);
    TEST_ASSERT_EQUAL_HEX16(ACKNOWLEDGED, heard.statusword & ACKNOWLEDGED); /* until bit 4 falls */
    command_for(5, 0x000F, 60 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & ACKNOWLEDGED);
}

/* One more set-point waits for the end of the move; while it waits bit 12 stays, and a third is not taken. */
static void test_set_points_are_buffered(void)
{
    enable_and_home();
    set_target(90 * COUNTS_PER_DEG);
    command(0x000F, 45 * COUNTS_PER_DEG);
    command(0x001F, 45 * COUNTS_PER_DEG);
    command_for(5, 0x000F, 45 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_HEX16(ACKNOWLEDGED, heard.statusword & ACKNOWLEDGED);
    command(0x000F, 10 * COUNTS_PER_DEG);
    command(0x001F, 10 * COUNTS_PER_DEG); /* ignored */
    command(0x000F, 10 * COUNTS_PER_DEG);
    ASSERT_SAME_DOUBLE(90.0, drive.axis.motion.end_position);
    pass_ms(1650);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & (REACHED | ACKNOWLEDGED)); /* off to the second */
    pass_ms(3000);
    TEST_ASSERT_EQUAL_INT32(45 * COUNTS_PER_DEG, heard.position);
}

/* Bit 5: the new target counts at once. Bit 6: it counts from the last one. */
static void test_change_at_once_and_relative(void)
{
    enable_and_home();
    target_for(500, 180 * COUNTS_PER_DEG);
    command(0x002F, 20 * COUNTS_PER_DEG);
    command(0x003F, 20 * COUNTS_PER_DEG);
    ASSERT_SAME_DOUBLE(20.0, drive.axis.motion.end_position);
    pass_ms(4000);
    TEST_ASSERT_EQUAL_INT32(20 * COUNTS_PER_DEG, heard.position);
    command(0x004F, -5 * COUNTS_PER_DEG);
    command(0x005F, -5 * COUNTS_PER_DEG);
    pass_ms(2000);
    TEST_ASSERT_EQUAL_INT32(15 * COUNTS_PER_DEG, heard.position);
}

/* The statusword follows after the reaction time: until then a master reads the old "target reached". */
static void test_the_statusword_lags(void)
{
    sim_scenario_defaults(&scenario);
    scenario.drive.reaction_us = 30000;
    power_on();
    configure();
    command(0x0006, 0);
    command(0x0007, 0);
    command_for(100, 0x000F, 0);
    home();
    pass_ms(50); /* until the bits of homing are gone */
    command(0x000F, 90 * COUNTS_PER_DEG);
    command_for(20, 0x001F, 90 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_HEX16(REACHED, (uint16_t)sdo_read(0x6041, 0) & (REACHED | ACKNOWLEDGED));
    pass_ms(20);
    TEST_ASSERT_EQUAL_HEX16(ACKNOWLEDGED, (uint16_t)sdo_read(0x6041, 0) & (REACHED | ACKNOWLEDGED));
}

static void test_halt_stops_and_goes_on(void)
{
    enable_and_home();
    target_for(800, 180 * COUNTS_PER_DEG);
    command_for(1500, 0x010F, 180 * COUNTS_PER_DEG);
    const int32_t halted_at = heard.position;
    TEST_ASSERT_TRUE(halted_at > 30 * COUNTS_PER_DEG && halted_at < 150 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_HEX16(REACHED, heard.statusword & REACHED); /* at rest */
    pass_ms(1000);
    TEST_ASSERT_EQUAL_INT32(halted_at, heard.position);
    command_for(4000, 0x000F, 180 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_INT32(180 * COUNTS_PER_DEG, heard.position);
}

/* Device state: 0800 0022h. Writing the mode in force is no change. */
static void test_the_mode_cannot_change_while_halted(void)
{
    enable();
    command(0x010F, 0);
    TEST_ASSERT_EQUAL_HEX32(0x08000022, sdo_write(0x6060, 0, 6, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 1, 1));
    TEST_ASSERT_EQUAL_UINT8(1, (uint8_t)sdo_read(0x6061, 0));
    command(0x000F, 0);
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 6, 1));
    pass_ms(5);
    TEST_ASSERT_EQUAL_UINT8(6, (uint8_t)sdo_read(0x6061, 0));
    TEST_ASSERT_EQUAL_HEX32(0x06090030, sdo_write(0x6060, 0, 3, 1)); /* velocity mode: not there */
}

/* Falling bit 4 ends homing where it is; it counts as not homed. */
static void test_homing_can_be_interrupted(void)
{
    enable();
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6098, 0, 34, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 6, 1));
    command_for(100, 0x001F, 0);
    command_for(5, 0x000F, 0);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & 0x3400U); /* it still brakes */
    expect_status_after(1000, REACHED, 0x3400U);            /* interrupted: reached, not attained */
    TEST_ASSERT_TRUE(virtual_clock.now_us > sim_axis_end_us(&drive.axis));
}

/* Quick stop: by its own ramp, then Switch on disabled by itself (605Ah = 2). */
static void test_quick_stop(void)
{
    enable_and_home();
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6085, 0, 90 * COUNTS_PER_DEG, 4)); /* 90 deg/s2 */
    target_for(1000, 270 * COUNTS_PER_DEG);
    command_for(5, 0x0002, 270 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_HEX16(0x0007, heard.statusword & 0x006FU);
    const uint64_t stop_us = sim_axis_end_us(&drive.axis) - drive.axis.start_us;
    TEST_ASSERT_UINT64_WITHIN(20000, 1000000, stop_us);
    expect_status_after(1200, 0x0040, 0x004FU);
    command_for(1000, 0x001F, 0);
    TEST_ASSERT_EQUAL_HEX16(0x0040, heard.statusword & 0x004FU); /* no way back without shutdown */
}

/* Target reached means that the axis stands, whatever it was doing when it was told to stop. */
static void test_target_reached_waits_for_the_end_of_a_quick_stop(void)
{
    for (int homing = 0; homing < 2; homing++) {
        set_up();
        enable_and_home();
        TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6085, 0, 9 * COUNTS_PER_DEG, 4)); /* 9 deg/s2 */
        TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, (homing == 1) ? 6 : 1, 1));
        command((homing == 1) ? 0x001F : 0x000F, 270 * COUNTS_PER_DEG);
        command_for(100, 0x001F, 270 * COUNTS_PER_DEG);
        command_for(5, 0x0002, 270 * COUNTS_PER_DEG);
        while (virtual_clock.now_us < sim_axis_end_us(&drive.axis)) {
            TEST_ASSERT_EQUAL_HEX16(0x0007, heard.statusword & 0x006FU);
            TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & REACHED);
            pass_ms(10);
        }
        TEST_ASSERT_GREATER_THAN_UINT64(1000000, sim_axis_end_us(&drive.axis) - drive.axis.start_us);
    }
}
