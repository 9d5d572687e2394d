/* What can go wrong with the drive, and other makers' units: each does what it says, and the axis stops. */
#include "sim_master.h"

#define COUNTS_PER_DEG 1000
#define REACHED 0x0400U

static void fresh(void)
{
    power_on();
    configure();
    enable_and_home();
}

static void set_up(void)
{
    sim_scenario_defaults(&scenario);
    fresh();
}

/* Half way to 180 degrees. */
static void set_out(void)
{
    target_for(1000, 180 * COUNTS_PER_DEG);
}

static void assert_stopped_within(uint64_t time_us)
{
    TEST_ASSERT_TRUE(sim_axis_end_us(&drive.axis) <= virtual_clock.now_us + time_us);
}

static void assert_state(uint16_t expected)
{
    TEST_ASSERT_EQUAL_HEX16(expected, heard.statusword & 0x004FU);
}

static void test_a_fault_stops_the_axis_and_is_told(void)
{
    set_out();
    sim_drive_fail(&drive, 0x2310, false);
    assert_stopped_within(600000);
    pass_ms(5);
    assert_state(0x000F); /* fault reaction: still braking */
    TEST_ASSERT_EQUAL_HEX16(0x2310, heard.emergency);
    TEST_ASSERT_EQUAL_HEX16(0x2310, sdo_read(0x603F, 0));
    pass_ms(1000);
    assert_state(0x0008);
    const int32_t stopped_at = heard.position;
    command_for(1000, 0x000F, 0);
    assert_state(0x0008); /* no way out but a reset */
    command_for(5, 0x0080, 0);
    assert_state(0x0040);
    TEST_ASSERT_EQUAL_HEX16(0x0000, heard.emergency); /* "no error" */
    TEST_ASSERT_EQUAL_HEX16(0, sdo_read(0x603F, 0));
    TEST_ASSERT_EQUAL_INT32(stopped_at, heard.position); /* known as before */
}

static void test_a_lasting_fault_cannot_be_reset(void)
{
    sim_drive_fail(&drive, 0x4210, true);
    pass_ms(100);
    command_for(5, 0x0080, 0);
    assert_state(0x0008);
    sim_drive_mend(&drive);
    command(0x0000, 0);
    command_for(5, 0x0080, 0);
    assert_state(0x0040);
}

/* The table jams at 45 degrees of a move: the error grows past 2 degrees, and 100 ms later it is a fault (8611h). */
static void test_a_jam_is_a_following_error(void)
{
    set_out();
    sim_axis_jam(&drive.axis, virtual_clock.now_us, true);
    sim_drive_disturb(&drive);
    const int32_t jammed_at = (int32_t)(drive.axis.jammed_deg * COUNTS_PER_DEG + 0.5);
    expect_status_after(100, 0x0027, 0x006FU);
    pass_ms(60);
    TEST_ASSERT_EQUAL_HEX16(0x8611, heard.emergency);
    TEST_ASSERT_EQUAL_HEX16(0x2000, heard.statusword & 0x2000U);
    pass_ms(1000);
    assert_state(0x0008);
    TEST_ASSERT_INT32_WITHIN(2, jammed_at, heard.position);
}

static void test_without_a_window_a_jam_goes_unnoticed(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6065, 0, 0xFFFFFFFFU, 4));
    set_out();
    sim_axis_jam(&drive.axis, virtual_clock.now_us, true);
    expect_status_after(5000, 0x0027, 0x006FU);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & REACHED);
}

/* Whether it was running or braking already. */
static void test_without_voltage_the_axis_coasts(void)
{
    for (int braking = 0; braking < 2; braking++) {
        fresh();
        set_out();
        if (braking == 1) {
            command_for(50, 0x0002, 0);
        }
        command_for(600, 0x0000, 0);
        assert_state(0x0040);
        TEST_ASSERT_FALSE(sim_axis_is_still(&drive.axis, virtual_clock.now_us));
        pass_ms(20000);
        TEST_ASSERT_TRUE(sim_axis_is_still(&drive.axis, virtual_clock.now_us));
    }
}

/* 500 ms without node 1: the axis stops, 8130h, and the node leaves Operational. A reset needs the master back. */
static void test_silence_of_the_master_stops_the_axis(void)
{
    set_out();
    beating = false;
    pass_ms(590);
    TEST_ASSERT_EQUAL_HEX16(0x8130, heard.emergency);
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT_REACTION, drive.power);
    assert_stopped_within(600000);
    pass_ms(1000);
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT, drive.power);
    TEST_ASSERT_EQUAL_UINT8(127, heard.nmt_state);
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6040, 0, 0x0080, 2));
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT, drive.power);
    beating = true;
    pass_ms(200);
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6040, 0, 0x0000, 2));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6040, 0, 0x0080, 2));
    TEST_ASSERT_EQUAL_INT(SIM_POWER_SWITCH_ON_DISABLED, drive.power);
}

/* 6007h: 0 nothing, 2 disable voltage, 3 quick stop. */
static void test_what_it_does_without_its_master_can_be_chosen(void)
{
    static const uint16_t OPTIONS[] = {0, 2, 3};
    static const sim_power_t STATES[] = {SIM_POWER_OPERATION_ENABLED, SIM_POWER_SWITCH_ON_DISABLED,
                                         SIM_POWER_QUICK_STOP_ACTIVE};
    for (size_t i = 0; i < COUNT_OF(OPTIONS); i++) {
        fresh();
        TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6007, 0, OPTIONS[i], 2));
        set_target(270 * COUNTS_PER_DEG);
        beating = false;
        pass_ms(590);
        TEST_ASSERT_EQUAL_INT(STATES[i], drive.power);
    }
}

static void test_leaving_operational_stops_the_axis(void)
{
    set_out();
    nmt(128);
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT_REACTION, drive.power);
    TEST_ASSERT_EQUAL_HEX16(0x8100, heard.emergency);
    assert_stopped_within(600000);
}

/* Power lost: it brakes, is off the bus, and forgets mapping, home and mode. */
static void test_a_power_cycle_forgets_everything(void)
{
    set_out();
    sim_drive_set_power(&drive, false);
    assert_stopped_within(300000);
    const uint32_t frames = heard.status_frames;
    pass_ms(500);
    TEST_ASSERT_EQUAL_UINT32(frames, heard.status_frames);
    sim_drive_set_power(&drive, true);
    pass_ms(20);
    TEST_ASSERT_EQUAL_UINT8(0, heard.nmt_state); /* boot-up */
    TEST_ASSERT_EQUAL_UINT32(1, sdo_read(0x1600, 0));
    TEST_ASSERT_EQUAL_HEX16(0x0040, sdo_read(0x6041, 0) & 0x004FU);
    TEST_ASSERT_EQUAL_INT32(0, (int32_t)sdo_read(0x6064, 0)); /* wherever it stands */
    TEST_ASSERT_TRUE(drive.zero_deg > 60.0);
}

static void test_nmt_resets_stop_the_axis(void)
{
    set_out();
    nmt(130); /* communication */
    TEST_ASSERT_EQUAL_INT(SIM_POWER_FAULT_REACTION, drive.power);
    assert_stopped_within(600000);
    TEST_ASSERT_EQUAL_INT(SIM_HOMING_ATTAINED, drive.homing);
    fresh();
    set_out();
    nmt(129); /* all of it */
    assert_stopped_within(600000);
    pass_ms(20);
    TEST_ASSERT_EQUAL_UINT8(0, heard.nmt_state);
    TEST_ASSERT_EQUAL_INT(SIM_HOMING_NONE, drive.homing);
    TEST_ASSERT_EQUAL_UINT32(1, sdo_read(0x1600, 0));
}

static void start_homing(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 6, 1));
    command(0x000F, 0);
    command(0x001F, 0);
}

static void test_homing_fails_when_there_is_no_mark(void)
{
    drive.faults[SIM_FAULT_HOMING_FAILS].on = true;
    start_homing();
    expect_status_after(30000, 0x2400, 0x3400U);
}

static void test_homing_may_never_end(void)
{
    drive.faults[SIM_FAULT_HOMING_ENDLESS].on = true;
    start_homing();
    expect_status_after(600000, 0, 0x3400U);
}

static void test_a_target_may_never_be_reached(void)
{
    drive.faults[SIM_FAULT_NEVER_REACHED].value = 0.5;
    target_for(30000, 45 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & REACHED);
    TEST_ASSERT_EQUAL_INT32(44500, heard.position);
    TEST_ASSERT_EQUAL_HEX16(0x0027, heard.statusword & 0x006FU); /* and no fault either */
}

static void test_slip_shows_in_the_position_only_if_the_encoder_sees_it(void)
{
    target_for(5000, 45 * COUNTS_PER_DEG);
    sim_axis_slip(&drive.axis, 0.3, false);
    sim_drive_disturb(&drive);
    pass_ms(100);
    TEST_ASSERT_EQUAL_INT32(45000, heard.position);
    sim_axis_slip(&drive.axis, 0.3, true);
    sim_drive_disturb(&drive);
    pass_ms(100);
    TEST_ASSERT_EQUAL_INT32(45300, heard.position);
}

static void test_other_units_and_sign(void)
{
    sim_scenario_defaults(&scenario);
    scenario.drive.counts_per_turn = 65536;
    scenario.drive.sign = -1;
    scenario.drive.velocity_per_deg_s = 10.0;
    scenario.drive.acceleration_per_deg_s2 = 1.0;
    fresh();
    TEST_ASSERT_EQUAL_UINT32(65536, sdo_read(0x608F, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6081, 0, 450, 4)); /* 45 deg/s */
    set_target(-65536 / 4);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 90.0 / 45.0 + 45.0 / 180.0, drive.axis.motion.end_s);
    pass_ms(5000);
    ASSERT_SAME_DOUBLE(90.0, drive.axis.motion.end_position);
    TEST_ASSERT_EQUAL_INT32(-16384, heard.position);
}

/* Positions modulo one turn: 350 is 20 degrees from 330, and 10 is 20 degrees from 350; the count stays below a turn.
 */
static void test_positions_that_wrap_go_the_shorter_way(void)
{
    sim_scenario_defaults(&scenario);
    scenario.drive.wrap_counts = 360000;
    fresh();
    target_for(5000, 350 * COUNTS_PER_DEG);
    ASSERT_SAME_DOUBLE(-10.0, drive.axis.motion.end_position);
    TEST_ASSERT_EQUAL_INT32(350000, heard.position);
    target_for(5000, 10 * COUNTS_PER_DEG);
    ASSERT_SAME_DOUBLE(10.0, drive.axis.motion.end_position);
    target_for(5000, 180 * COUNTS_PER_DEG);
    target_for(5000, 350 * COUNTS_PER_DEG);
    ASSERT_SAME_DOUBLE(350.0, drive.axis.motion.end_position);
    TEST_ASSERT_EQUAL_INT32(350000, heard.position);
}

/* While it moves it reports at its control cycle; at rest only when something changes. */
static void test_it_reports_while_it_moves(void)
{
    const uint32_t before = heard.position_frames;
    pass_ms(1000);
    TEST_ASSERT_EQUAL_UINT32(before, heard.position_frames);
    target_for(1500, 90 * COUNTS_PER_DEG);
    TEST_ASSERT_UINT32_WITHIN(15, before + 75U, heard.position_frames);
}
