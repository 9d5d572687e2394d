#include "sim_master.h"

#include "core/bytes.h"

sim_clock_t virtual_clock;
sim_wire_t wire;
sim_bus_t bus;
sim_scenario_t scenario;
sim_angle_error_t angle_error;
sim_drive_t drive;

heard_t heard;

bool beating;
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

void pass_until(uint64_t limit_us)
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

void pass_ms(uint32_t ms)
{
    pass_until(virtual_clock.now_us + 1000U * (uint64_t)ms);
}

void expect_status_after(uint32_t ms, uint16_t expected, uint16_t mask)
{
    pass_ms(ms);
    TEST_ASSERT_EQUAL_HEX16(expected, heard.statusword & mask);
}

void send_frame(uint16_t id, uint8_t length, const uint8_t *data)
{
    tumble_can_frame_t frame = {.id = id, .length = length};
    memcpy(frame.data, data, length);
    ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&bus, MASTER_BUS_NODE, &frame));
    pass_ms(1);
}

void nmt(uint8_t command)
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

uint32_t sdo_write(uint16_t index, uint8_t subindex, uint32_t value, uint8_t size)
{
    const uint32_t told = ask((uint8_t)(0x23U | (4U - size) << 2), index, subindex, value);
    return (heard.answer[0] == 0x80U) ? told : 0U;
}

uint32_t sdo_read(uint16_t index, uint8_t subindex)
{
    const uint32_t value = ask(0x40, index, subindex, 0);
    TEST_ASSERT_TRUE_MESSAGE(heard.answer[0] != 0x80U, "cannot be read");
    return value;
}

void command(uint16_t controlword, int32_t target)
{
    uint8_t data[6];
    tumble_put_u16(data, controlword);
    tumble_put_u32(&data[2], (uint32_t)target);
    send_frame(0x202, 6, data);
}

void command_for(uint32_t ms, uint16_t controlword, int32_t target)
{
    command(controlword, target);
    pass_ms(ms);
}

void power_on(void)
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

void configure(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1400, 1, 0x80000202U, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1600, 0, 0, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1600, 1, 0x60400010U, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1600, 2, 0x607A0020U, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1600, 0, 2, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1400, 1, 0x202U, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1800, 1, 0x80000182U, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1A00, 0, 0, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1A00, 1, 0x60410010U, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1A00, 2, 0x60640020U, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1A00, 0, 2, 1));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1800, 1, 0x182U, 4));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x1016, 1, 0x000101F4U, 4));
    nmt(1);
    pass_ms(5);
}

void enable(void)
{
    command(0x0006, 0);
    command(0x0007, 0);
    command_for(5, 0x000F, 0);
    TEST_ASSERT_EQUAL_HEX16(0x0027, heard.statusword & 0x006FU);
}

void home(void)
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

void enable_and_home(void)
{
    enable();
    home();
}

void set_target(int32_t target)
{
    command(0x000F, target);
    command_for(5, 0x001F, target);
    TEST_ASSERT_EQUAL_HEX16(0x1000, heard.statusword & 0x1000U);
    command_for(5, 0x000F, target);
    TEST_ASSERT_EQUAL_HEX16(0, heard.statusword & 0x1000U);
}

void target_for(uint32_t ms, int32_t target)
{
    set_target(target);
    pass_ms(ms);
}
