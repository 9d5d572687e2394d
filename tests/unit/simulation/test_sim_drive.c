/* The simulated drive in its normal life, and the traps of the set-point handshake. */
#include "core/bytes.h"
#include "simulation/drive.h"
#include "support.h"

#include <string.h>

enum { MASTER_BUS_NODE = 0, DRIVE_BUS_NODE = 1 };

/* What has come from the drive. */
typedef struct {
    uint16_t statusword;
    int32_t position;
    uint32_t status_frames;
    uint32_t position_frames;
    uint16_t emergency; /* last error code */
    uint32_t emergencies;
    uint8_t answer[8]; /* of the last SDO */
    bool answered;
    uint8_t nmt_state;
} heard_t;

static sim_clock_t virtual_clock;
static sim_wire_t wire;
static sim_bus_t bus;
static sim_scenario_t scenario;
static sim_angle_error_t angle_error;
static sim_drive_t drive;

static heard_t heard;

/* does the master send its heartbeat? */
static bool beating;
static uint64_t next_beat_us;

static void master_take(const tumble_can_frame_t *frame)
{
    const uint8_t *const d = frame->data;
    if (frame->id == 0x182U) {
        heard.statusword = (uint16_t)(d[0] | d[1] << 8);
        heard.status_frames++;
        if (frame->length >= 6U) {
            heard.position = (int32_t)tumble_get_u32(&d[2]);
            heard.position_frames++;
        }
    } else if (frame->id == 0x082U) {
        heard.emergency = (uint16_t)(d[0] | d[1] << 8);
        heard.emergencies++;
    } else if (frame->id == 0x582U) {
        memcpy(heard.answer, d, 8);
        heard.answered = true;
    } else if (frame->id == 0x702U) {
        heard.nmt_state = d[0];
    }
}

static void master_beat(void)
{
    const tumble_can_frame_t frame = {.id = 0x701, .length = 1, .data = {5}};
    if (beating) {
        (void)sim_bus_send(&bus, MASTER_BUS_NODE, &frame);
    }
    next_beat_us = virtual_clock.now_us + 100000U;
    sim_clock_set(&virtual_clock, SIM_ACTOR_OPERATOR, next_beat_us);
}

static void pass_until(uint64_t limit_us)
{
    sim_actor_t actor;
    tumble_can_frame_t frame;
    sim_clock_set(&virtual_clock, SIM_ACTOR_FAULTS, limit_us); /* so that time gets there */
    while (sim_clock_next(&virtual_clock, limit_us, &actor)) {
        if (actor == SIM_ACTOR_BUS) {
            sim_bus_on_alarm(&bus);
        } else if (actor == SIM_ACTOR_DRIVE) {
            sim_drive_on_alarm(&drive);
        } else if (actor == SIM_ACTOR_OPERATOR) {
            master_beat();
        } else if (actor == SIM_ACTOR_NAVCOMP) {
            while (sim_bus_receive(&bus, MASTER_BUS_NODE, &frame) == TUMBLE_OK) {
                master_take(&frame);
            }
        }
    }
}

static void pass_ms(uint32_t ms)
{
    pass_until(virtual_clock.now_us + 1000U * (uint64_t)ms);
}

/* what the statusword has of these bits */
static void expect_status_after(uint32_t ms, uint16_t expected, uint16_t mask)
{
    pass_ms(ms);
    TEST_ASSERT_EQUAL_HEX16(expected, heard.statusword & mask);
}

static void send_frame(uint16_t id, uint8_t length, const uint8_t *data)
{
    tumble_can_frame_t frame = {.id = id, .length = length};
    memcpy(frame.data, data, length);
    ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, MASTER_BUS_NODE, &frame));
    pass_ms(1);
}

static void nmt(uint8_t command)
{
    const uint8_t data[2] = {command, 2};
    send_frame(0x000, 2, data);
}

/* Returns the value of the answer, which may be an abort code. */
static uint32_t ask(uint8_t specifier, uint16_t index, uint8_t subindex, uint32_t value)
{
    uint8_t data[8] = {specifier, (uint8_t)index, (uint8_t)(index >> 8), subindex};
    tumble_put_u32(&data[4], value);
    heard.answered = false;
    send_frame(0x602, 8, data);
    for (int n = 0; n < 50 && !heard.answered; n++) {
        pass_ms(1);
    }
    TEST_ASSERT_TRUE_MESSAGE(heard.answered, "the drive does not answer");
    return tumble_get_u32(&heard.answer[4]);
}

/* Abort code, 0 when it was written. */
static uint32_t sdo_write(uint16_t index, uint8_t subindex, uint32_t value, uint8_t size)
{
    const uint32_t told = ask((uint8_t)(0x23U | (4U - size) << 2), index, subindex, value);
    return (heard.answer[0] == 0x80U) ? told : 0U;
}

static uint32_t sdo_read(uint16_t index, uint8_t subindex)
{
    const uint32_t value = ask(0x40, index, subindex, 0);
    TEST_ASSERT_TRUE_MESSAGE(heard.answer[0] != 0x80U, "cannot be read");
    return value;
}

/* Receive PDO 1: controlword and target. */
static void command(uint16_t controlword, int32_t target)
{
    uint8_t data[6];
    tumble_put_u16(data, controlword);
    tumble_put_u32(&data[2], (uint32_t)target);
    send_frame(0x202, 6, data);
}

/* and let so long pass */
static void command_for(uint32_t ms, uint16_t controlword, int32_t target)
{
    command(controlword, target);
    pass_ms(ms);
}

/* A fresh drive at 10 degrees, master beating, drive booted. The scenario may be changed before. */
static void power_on(void)
{
    sim_wire_init(&wire);
    sim_clock_init(&virtual_clock);
    sim_bus_init(&bus, &virtual_clock, &wire, 500000);
    sim_bus_attach(&bus, MASTER_BUS_NODE, SIM_ACTOR_NAVCOMP);
    sim_angle_error_init(&angle_error, 1, &tumble_schedule_paper, SIM_LAW_SIGMA1, 4e-5);
    scenario.drive.axis.resolution_deg = 360.0 / (double)scenario.drive.counts_per_turn;
    sim_drive_init(&drive, &scenario.drive, &virtual_clock, &bus, DRIVE_BUS_NODE, &angle_error, 10.0);
    memset(&heard, 0, sizeof heard);
    beating = true;
    master_beat();
    pass_ms(10);
}

/* PDOs mapped, Operational, watching our heartbeat. */
static void configure(void)
{
    static const struct {
        uint16_t index;
        uint8_t subindex;
        uint8_t size;
        uint32_t value;
    } writes[] = {
        {0x1400, 1, 4, 0x80000202U}, {0x1600, 0, 1, 0}, {0x1600, 1, 4, 0x60400010U},
        {0x1600, 2, 4, 0x607A0020U}, {0x1600, 0, 1, 2}, {0x1400, 1, 4, 0x202U},
        {0x1800, 1, 4, 0x80000182U}, {0x1A00, 0, 1, 0}, {0x1A00, 1, 4, 0x60410010U},
        {0x1A00, 2, 4, 0x60640020U}, {0x1A00, 0, 1, 2}, {0x1800, 1, 4, 0x182U},
        {0x1016, 1, 4, 0x000101F4U},
    };
    for (size_t i = 0; i < COUNT_OF(writes); i++) {
        TEST_ASSERT_EQUAL_HEX32(0, sdo_write(writes[i].index, writes[i].subindex, writes[i].value, writes[i].size));
    }
    nmt(1);
    pass_ms(5);
}

static void enable(void)
{
    command(0x0006, 0);
    command(0x0007, 0);
    command_for(5, 0x000F, 0);
    TEST_ASSERT_EQUAL_HEX16(0x0027, heard.statusword & 0x006FU);
}

/* Homed, in profile position mode, at rest at 0. */
static void home(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6098, 0, 34, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 6, 1));
    command_for(20000, 0x001F, 0);
    TEST_ASSERT_EQUAL_HEX16(0x1400, heard.statusword & 0x3400U);
    command(0x000F, 0);
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 1, 1));
    pass_ms(5);
    TEST_ASSERT_EQUAL_INT32(0, heard.position);
}

static void enable_and_home(void)
{
    enable();
    home();
}

/* The set-point handshake as it should be: target first, then the edge, until it is taken; then bit 4 down. */
static void set_target(int32_t target)
{
    command(0x000F, target);
    command_for(5, 0x001F, target);
    TEST_ASSERT_EQUAL_HEX16(0x1000, heard.statusword & 0x1000U);
    command_for(5, 0x000F, target);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & 0x1000U);
}

static void target_for(uint32_t ms, int32_t target)
{
    set_target(target);
    pass_ms(ms);
}

#define COUNTS_PER_DEG 1000
#define REACHED 0x0400U
#define ACKNOWLEDGED 0x1000U

static void restart(void)
{
    power_on();
    configure();
}

static void fresh(void)
{
    restart();
    enable_and_home();
}

static void set_up(void)
{
    sim_scenario_defaults(&scenario);
    fresh();
}

static void test_it_boots_and_tells_what_it_is(void)
{
    restart();
    TEST_ASSERT_EQUAL_HEX32(0x00020192, sdo_read(0x1000, 0));
    TEST_ASSERT_EQUAL_UINT32(360000, sdo_read(0x608F, 1));
    TEST_ASSERT_EQUAL_UINT8(1, (uint8_t)sdo_read(0x6061, 0));
    TEST_ASSERT_EQUAL_HEX16(0x0040, heard.statusword & 0x004FU); /* Switch on disabled */
}

static void test_power_up_goes_through_all_states(void)
{
    restart();
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
    restart();
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
    restart();
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
    restart();
    enable();
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x6060, 0, 6, 1));
    command_for(50, 0x001F, 0);
    TEST_ASSERT_EQUAL_HEX16(0x1400, heard.statusword & 0x3400U);
    ASSERT_SAME_DOUBLE(10.0, drive.axis.motion.end_position);
}

static void test_a_move_reaches_its_target(void)
{
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
    command(0x000F, 30 * COUNTS_PER_DEG);
    command_for(3000, 0x001F, 60 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_INT32(30 * COUNTS_PER_DEG, heard.position);
}

static void test_a_forgiving_drive_takes_the_target_of_the_same_frame(void)
{
    scenario.drive.latches_stale_target = false;
    fresh();
    command_for(3000, 0x001F, 60 * COUNTS_PER_DEG);
    TEST_ASSERT_EQUAL_INT32(60 * COUNTS_PER_DEG, heard.position);
}

/* Without an edge nothing happens, however often the target changes. */
static void test_a_set_point_needs_an_edge(void)
{
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
    scenario.drive.reaction_us = 30000;
    restart();
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
    restart();
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
    restart();
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
        fresh();
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

/* What can go wrong with the drive, and other makers' units: each does what it says, and the axis stops. */

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
