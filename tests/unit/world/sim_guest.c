#include "sim_guest.h"

const bench_watcher_t NOBODY = {0};

double least_deg;
double most_deg;
uint32_t answer;

static void on_frame(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    (void)context;
    (void)time_us;
    (void)sender;
    if (frame->id == 0x581U) {
        answer = (frame->data[0] == 0x80U) ? tumble_get_u32(&frame->data[4]) : 0U;
    }
}

const bench_watcher_t LISTENER = {.on_frame = on_frame};

void begin(const char *lines, const bench_watcher_t *watcher)
{
    TEST_ASSERT_NULL(read_lines(lines));
    ASSERT_STATUS(TUMBLE_OK, bench_world_init(&world, &config, 1, watcher));
}

double table_deg(void)
{
    return sim_axis_actual_deg(world.axis, world.clock.now_us);
}

void pass(uint64_t time_us)
{
    const uint64_t end_us = world.clock.now_us + time_us;
    least_deg = table_deg();
    most_deg = least_deg;
    while (bench_world_next_us(&world) <= end_us && bench_world_advance(&world)) {
        const double deg = table_deg();
        least_deg = (deg < least_deg) ? deg : least_deg;
        most_deg = (deg > most_deg) ? deg : most_deg;
    }
    bench_world_pass(&world, end_us);
}

void guest_send(uint16_t id, uint8_t length, const uint8_t *data)
{
    tumble_can_frame_t frame = {.id = id, .length = length};
    memcpy(frame.data, data, length);
    ASSERT_STATUS(TUMBLE_OK, sim_bus_send(&world.bus, BENCH_BUS_GUEST, &frame));
}

void write_bytes(uint8_t node, uint16_t index, uint8_t subindex, uint32_t value, uint8_t size)
{
    uint8_t data[8] = {(uint8_t)(0x23U | ((4U - size) << 2U)), (uint8_t)index, (uint8_t)(index >> 8), subindex};
    tumble_put_u32(&data[4], value);
    answer = UINT32_MAX;
    guest_send((uint16_t)(0x600U + node), 8, data);
    pass(20000);
}

void write_u32(uint8_t node, uint16_t index, uint8_t subindex, uint32_t value)
{
    write_bytes(node, index, subindex, value, 4);
}

tumble_status_t command(tumble_command_t wanted, double angle_deg)
{
    const tumble_status_t status = (wanted == TUMBLE_COMMAND_TURN_AXIS)
                                       ? tumble_navcomp_turn(&world.navcomp, angle_deg)
                                       : tumble_navcomp_command(&world.navcomp, wanted, 0);
    sim_clock_set(&world.clock, SIM_ACTOR_NAVCOMP, world.clock.now_us);
    return status;
}

tumble_navcomp_progress_t progress(void)
{
    tumble_navcomp_progress_t seen;
    tumble_navcomp_progress(&world.navcomp, &seen);
    return seen;
}

tumble_navcomp_counters_t counters(void)
{
    tumble_navcomp_counters_t seen;
    tumble_navcomp_counters(&world.navcomp, &seen);
    return seen;
}

void begin_homing(const char *lines, const bench_watcher_t *watcher, uint64_t time_us)
{
    begin(lines, watcher);
    pass(2U * SECOND);
    ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_HOME_AXIS, 0));
    pass(time_us);
}

void start_turning(const char *lines)
{
    begin_homing(lines, &LISTENER, 20U * SECOND);
    ASSERT_STATUS(TUMBLE_OK, command(TUMBLE_COMMAND_TURN_AXIS, 390.0));
    pass(2U * SECOND);
    TEST_ASSERT_FALSE(bench_world_is_at_rest(&world));
}
