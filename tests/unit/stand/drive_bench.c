#include "drive_bench.h"

#include <stddef.h>

drive_bench_t bench;
scripted_drive_t played;
fake_port_t port;
tumble_drive_profile_t made;

/* Our node: nothing but the mirror and the dummies. */

#define RO TUMBLE_ACCESS_READ
#define RW (TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE)
#define DUMMY(index, type, size)                                                                                       \
    {index, 0, type, TUMBLE_HOME_IMMEDIATE, TUMBLE_ACCESS_WRITE | TUMBLE_ACCESS_MAP_RECEIVE, size, 0, 0, 0, 0, 0}
#define MIRROR(sub, type, access, size, member)                                                                        \
    {TUMBLE_DRIVE402_MIRROR,                                                                                           \
     sub,                                                                                                              \
     type,                                                                                                             \
     TUMBLE_HOME_OTHER,                                                                                                \
     access,                                                                                                           \
     size,                                                                                                             \
     0,                                                                                                                \
     0,                                                                                                                \
     0,                                                                                                                \
     offsetof(tumble_drive_mirror_t, member),                                                                          \
     0}

static const tumble_entry_t own_entries[] = {
    DUMMY(0x0005, TUMBLE_TYPE_UNSIGNED8, 1),
    DUMMY(0x0006, TUMBLE_TYPE_UNSIGNED16, 2),
    DUMMY(0x0007, TUMBLE_TYPE_UNSIGNED32, 4),
    MIRROR(1, TUMBLE_TYPE_UNSIGNED16, RO | TUMBLE_ACCESS_MAP_TRANSMIT, 2, controlword),
    MIRROR(2, TUMBLE_TYPE_INTEGER32, RO | TUMBLE_ACCESS_MAP_TRANSMIT, 4, target_position),
    MIRROR(3, TUMBLE_TYPE_INTEGER8, RO | TUMBLE_ACCESS_MAP_TRANSMIT, 1, mode),
    MIRROR(4, TUMBLE_TYPE_UNSIGNED16, RW | TUMBLE_ACCESS_MAP_RECEIVE, 2, statusword),
    MIRROR(5, TUMBLE_TYPE_INTEGER32, RW | TUMBLE_ACCESS_MAP_RECEIVE, 4, actual_position),
    MIRROR(6, TUMBLE_TYPE_INTEGER8, RW | TUMBLE_ACCESS_MAP_RECEIVE, 1, mode_display),
    MIRROR(7, TUMBLE_TYPE_INTEGER32, RW | TUMBLE_ACCESS_MAP_RECEIVE, 4, actual_velocity),
    MIRROR(8, TUMBLE_TYPE_UNSIGNED16, RW | TUMBLE_ACCESS_MAP_RECEIVE, 2, error_code),
};

static const tumble_object_table_t own_table = {own_entries, NULL, NULL, COUNT_OF(own_entries)};
static const tumble_node_defaults_t own_defaults = {
    .heartbeat_ms = 100, .consumers = {(SCRIPTED_DRIVE_NODE << 16) | 500U}, .on_error = TUMBLE_ON_ERROR_STAY};

static void own_heartbeat(void *context, uint8_t node, tumble_heartbeat_event_t event, tumble_nmt_state_t state)
{
    (void)context;
    if (node == SCRIPTED_DRIVE_NODE) {
        tumble_drive402_kind.heartbeat(&bench.drive, event, state);
    }
}

static void own_emergency(void *context, uint8_t node, const tumble_emergency_t *emergency)
{
    (void)context;
    if (node == SCRIPTED_DRIVE_NODE) {
        tumble_drive402_kind.emergency(&bench.drive, emergency);
    }
}

static void own_pdo(void *context, uint8_t number)
{
    (void)context;
    tumble_drive402_kind.pdo_received(&bench.drive, number);
}

static const tumble_node_events_t own_events = {
    .heartbeat = own_heartbeat, .emergency = own_emergency, .pdo_received = own_pdo};
const tumble_node_config_t own_config = {
    .table = &own_table, .defaults = &own_defaults, .events = &own_events, .node = SCRIPTED_MASTER_NODE};

void run_ms(unsigned ms)
{
    for (unsigned i = 0; i < ms; i++) {
        port.now_us += 1000U;
        scripted_drive_step(&played, &port);
        tumble_can_frame_t frame;
        while (tumble_link_receive(&bench.node.link, &frame) == TUMBLE_OK) {
            (void)tumble_node_receive(&bench.node, &frame, port.now_us);
            tumble_drive402_kind.step(&bench.drive, port.now_us);
        }
        tumble_drive402_kind.step(&bench.drive, port.now_us);
        tumble_node_step(&bench.node, port.now_us);
        while (fake_port_take(&port, &frame)) {
            scripted_drive_hear(&played, &port, &frame);
        }
    }
    TEST_ASSERT_FALSE(port.overflowed);
    TEST_ASSERT_NULL_MESSAGE(played.wrong, played.wrong);
    TEST_ASSERT_TRUE((played.write_count <= SCRIPTED_WRITES) && (played.control_count <= SCRIPTED_CONTROLS));
}

tumble_stand_state_t stand_state(void)
{
    return bench.stand.kind->state(bench.stand.self);
}

void assert_state_after(unsigned ms, tumble_stand_state_t state)
{
    run_ms(ms);
    TEST_ASSERT_EQUAL_INT(state, stand_state());
}

void run_to(tumble_stand_state_t state, unsigned most_ms)
{
    for (unsigned i = 0; (i < most_ms) && (stand_state() != state); i++) {
        run_ms(1);
    }
    assert_state_after(0, state);
}

tumble_status_t drive_init(const tumble_drive_profile_t *profile, uint8_t drive_node)
{
    const tumble_stand_setup_t setup = {.profile = profile,
                                        .node = &bench.node,
                                        .mirror = &bench.mirror,
                                        .cable_min_deg = -30.0,
                                        .cable_max_deg = 400.0,
                                        .stand_node = drive_node};
    return tumble_drive402_kind.init(&bench.drive, &setup);
}

static void start_computer(const tumble_drive_profile_t *profile)
{
    memset(&bench, 0, sizeof bench);
    const tumble_node_binding_t binding = {.port = &port.port, .other = &bench.mirror, .context = &bench};
    ASSERT_STATUS(TUMBLE_OK, tumble_node_init(&bench.node, &own_config, &binding));
    ASSERT_STATUS(TUMBLE_OK, drive_init(profile, SCRIPTED_DRIVE_NODE));
    bench.stand = (tumble_stand_t){&tumble_drive402_kind, &bench.drive};
    tumble_node_set_state(&bench.node, TUMBLE_NMT_OPERATIONAL);
}

void bench_setup(const tumble_drive_profile_t *profile)
{
    played = (scripted_drive_t){.dead = true, .fake = &port};
    fake_port_init(&port);
    start_computer(profile);
    run_ms(5);
}

void restart_computer(void)
{
    start_computer(&common);
}

void boot_drive(void)
{
    drive_boots(0);
    run_to(TUMBLE_STAND_READY, 500);
}

void bring_up(const tumble_drive_profile_t *profile)
{
    bench_setup(profile);
    boot_drive();
}

void go_home(void)
{
    home_for(0);
    run_to(TUMBLE_STAND_IN_POSITION, 500);
}

void bring_home(const tumble_drive_profile_t *profile)
{
    bring_up(profile);
    go_home();
}

void assert_fault(tumble_stand_fault_t fault)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT, stand_state());
    TEST_ASSERT_EQUAL_INT(fault, bench.stand.kind->fault(bench.stand.self));
}

void assert_fault_after(unsigned ms, tumble_stand_fault_t fault)
{
    run_ms(ms);
    assert_fault(fault);
}

void run_to_fault(tumble_stand_fault_t fault, unsigned most_ms)
{
    run_to(TUMBLE_STAND_FAULT, most_ms);
    assert_fault(fault);
}

void assert_angle(double expected_deg)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, expected_deg, bench.stand.kind->angle_deg(bench.stand.self));
}

void move_for(unsigned ms, double angle_deg)
{
    ASSERT_STATUS(TUMBLE_OK, bench.stand.kind->move(bench.stand.self, angle_deg));
    run_ms(ms);
}

void home_for(unsigned ms)
{
    ASSERT_STATUS(TUMBLE_OK, bench.stand.kind->home(bench.stand.self));
    run_ms(ms);
}

void stop_for(unsigned ms)
{
    bench.stand.kind->stop(bench.stand.self);
    run_ms(ms);
}

void move_to(double angle_deg)
{
    move_for(0, angle_deg);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_MOVING, stand_state());
    run_to(TUMBLE_STAND_IN_POSITION, 3000);
}

void start_move(const tumble_drive_profile_t *profile)
{
    bring_home(profile);
    move_for(20, 90.0);
    TEST_ASSERT_TRUE(played.moving);
}

void clear_fault(void)
{
    tumble_status_t status = bench.stand.kind->clear_fault(bench.stand.self);
    for (unsigned ms = 0; (status == TUMBLE_E_STAND_STATE) && (ms < 3000U); ms++) {
        run_ms(1);
        status = bench.stand.kind->clear_fault(bench.stand.self);
    }
    ASSERT_STATUS(TUMBLE_OK, status);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, bench.stand.kind->fault(bench.stand.self));
    TEST_ASSERT_EQUAL_UINT16(0, bench.drive.report.fault_code);
}

void recover(tumble_stand_state_t state)
{
    clear_fault();
    run_to(state, 500);
}

void stop_at_rest(void)
{
    bench.stand.kind->stop(bench.stand.self);
    run_to(TUMBLE_STAND_STOPPED, 100);
}

void report_now(void)
{
    scripted_drive_report(&played);
    run_ms(2);
}

void drive_boots(unsigned ms)
{
    scripted_drive_boot(&played, &port);
    run_ms(ms);
}

void drive_fails(uint16_t code, unsigned ms)
{
    scripted_drive_fail(&played, &port, code);
    run_ms(ms);
}

void assert_refused(uint16_t index, uint8_t subindex, tumble_stand_step_t step, uint32_t abort)
{
    const tumble_stand_refusal_t refusal = bench.drive.report.refusal;
    assert_fault(TUMBLE_STAND_FAULT_PROTOCOL);
    TEST_ASSERT_EQUAL_HEX16(index, refusal.index);
    TEST_ASSERT_EQUAL_UINT8(subindex, refusal.subindex);
    TEST_ASSERT_EQUAL_UINT8(step, refusal.step);
    TEST_ASSERT_EQUAL_HEX32(abort, refusal.abort);
}

tumble_drive_profile_t halting(void)
{
    tumble_drive_profile_t profile = common;
    profile.stop = TUMBLE_STOP_BY_HALT;
    return profile;
}

tumble_drive_profile_t wrapping(void)
{
    tumble_drive_profile_t profile = common;
    profile.wrap_counts = 36000;
    return profile;
}

const tumble_drive_pdo_t common_receive[] = {
    {0, {.cob_id = 0x202, .type = 255, .count = 2, .map = {0x60400010, 0x607A0020}}}};
const tumble_drive_pdo_t common_transmit[] = {{0,
                                               {.cob_id = 0x40000182,
                                                .type = 255,
                                                .count = 2,
                                                .inhibit_100us = 7,
                                                .event_ms = 10,
                                                .map = {0x60410010, 0x60640020}}}};
const tumble_drive_profile_t common = {
    .counts_per_revolution = 36000.0,
    .velocity_units_per_deg_s = 100.0,
    .acceleration_units_per_deg_s2 = 100.0,
    .sign = 1,
    .window_counts = 10,
    .velocity_deg_s = 1000.0, /* as the scripted drive turns */
    .acceleration_deg_s2 = 180.0,
    .quick_stop_deg_s2 = 720.5,
    .homing_fast_deg_s = 20.0,
    .homing_method = -3,
    .receive = common_receive,
    .transmit = common_transmit,
    .receive_count = 1,
    .transmit_count = 1,
    .heartbeat_ms = 100,
    .heartbeat_timeout_ms = 500,
    .start_timeout_ms = 200,
    .power_timeout_ms = 300,
    .handshake_timeout_ms = 150,
    .home_timeout_ms = 2000,
    .move_timeout_ms = 1500,
    .stop_timeout_ms = 400,
};
