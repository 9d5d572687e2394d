#include "simulation/drive.h"

#include "core/bytes.h"
#include "simulation/drive_internal.h"

#include <stddef.h>
#include <string.h>

#define COMMUNICATION_LOST 0x8100U /* error code: left Operational while the axis was enabled */
#define BRAKE_FACTOR 4.0           /* without power the brake works this much harder than the motor can */

/* 6007h */
#define ON_LOSS_NOTHING 0
#define ON_LOSS_DISABLE_VOLTAGE 2
#define ON_LOSS_QUICK_STOP 3

/* The node's callbacks */

static tumble_abort_t check_write(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    const sim_drive_t *const drive = context;
    (void)size;
    if (entry->index == TUMBLE_402_SOFTWARE_LIMIT && !drive->config->software_limits) {
        return TUMBLE_ABORT_NO_OBJECT;
    }
    if (entry->index != TUMBLE_402_MODE) {
        return TUMBLE_ABORT_NONE;
    }
    const int8_t mode = tumble_get_i8(bytes);
    if (mode != TUMBLE_402_MODE_PROFILE_POSITION && mode != TUMBLE_402_MODE_HOMING) {
        return TUMBLE_ABORT_VALUE;
    }
    const bool halt = (drive->objects.controlword & TUMBLE_402_CONTROL_HALT) != 0U;
    return (halt && mode != drive->mode) ? TUMBLE_ABORT_DEVICE_STATE : TUMBLE_ABORT_NONE;
}

/* An axis under power has lost its master. */
static void abort_connection(sim_drive_t *drive)
{
    const bool silent = tumble_nmt_any_lost(&drive->node.nmt);
    if (drive->power != SIM_POWER_OPERATION_ENABLED) {
        return;
    }
    switch (drive->objects.abort_connection_option_code) {
    case ON_LOSS_NOTHING:
        break;
    case ON_LOSS_DISABLE_VOLTAGE:
        sim_drive_enter(drive, SIM_POWER_SWITCH_ON_DISABLED);
        break;
    case ON_LOSS_QUICK_STOP:
        sim_drive_enter(drive, SIM_POWER_QUICK_STOP_ACTIVE);
        break;
    default:
        sim_drive_fail(drive, silent ? TUMBLE_402_ERROR_HEARTBEAT : COMMUNICATION_LOST, false);
        break;
    }
}

static void state_changed(void *context, tumble_nmt_state_t state)
{
    if (state != TUMBLE_NMT_OPERATIONAL) {
        abort_connection(context);
    }
}

static void heartbeat(void *context, uint8_t node, tumble_heartbeat_event_t event, tumble_nmt_state_t state)
{
    (void)node;
    (void)state;
    if (event == TUMBLE_HEARTBEAT_LOST) {
        abort_connection(context);
    }
}

static void wake_up(sim_drive_t *drive);

static void reset(void *context, bool application)
{
    sim_drive_t *const drive = context;
    abort_connection(drive); /* either reset leaves Operational */
    if (application) {
        sim_drive_stop_axis(drive, drive->config->acceleration_deg_s2);
        wake_up(drive);
    }
}

static const tumble_object_hooks_t HOOKS = {.write = check_write};
static const tumble_node_events_t EVENTS = {.state_changed = state_changed, .heartbeat = heartbeat, .reset = reset};

static const tumble_node_config_t NODE = {.table = &tumble_drive_table,
                                          .defaults = &tumble_drive_defaults,
                                          .hooks = &HOOKS,
                                          .events = &EVENTS,
                                          .node = TUMBLE_DRIVE_NODE};

static uint32_t in_units(double value)
{
    return (value >= 4294967295.0) ? UINT32_MAX : (uint32_t)(value + 0.5);
}

/* The table's values are those of a drive with 360,000 counts a turn that counts in them; this one may count otherwise.
 */
static tumble_drive_objects_t initial_objects(const sim_drive_config_t *config)
{
    tumble_drive_objects_t objects = tumble_drive_objects_initial;
    const double finer =
        (double)config->counts_per_turn / (double)objects.position_encoder_resolution_encoder_increments;
    objects.position_encoder_resolution_encoder_increments = config->counts_per_turn;
    objects.position_window = in_units((double)objects.position_window * finer);
    objects.following_error_window = in_units((double)objects.following_error_window * finer);
    objects.profile_velocity = in_units(config->speed_deg_s * config->velocity_per_deg_s);
    objects.profile_acceleration = in_units(config->acceleration_deg_s2 * config->acceleration_per_deg_s2);
    objects.profile_deceleration = objects.profile_acceleration;
    objects.quick_stop_deceleration = objects.profile_acceleration;
    objects.homing_acceleration = objects.profile_acceleration;
    objects.homing_speeds_speed_during_search_for_switch = in_units(0.5 * (double)objects.profile_velocity);
    objects.homing_speeds_speed_during_search_for_zero = in_units(0.05 * (double)objects.profile_velocity);
    return objects;
}

/* Everything as after power-on, but for where the axis is. */
static void wake_up(sim_drive_t *drive)
{
    const double here = drive->axis.motion.end_position;
    drive->objects = initial_objects(drive->config);
    drive->power = SIM_POWER_SWITCH_ON_DISABLED;
    drive->seen_controlword = 0;
    drive->seen_target = 0;
    drive->mode = drive->objects.modes_of_operation;
    drive->acknowledged = false;
    drive->buffered = false;
    drive->halted = false;
    drive->limited = false;
    drive->reached = true;
    drive->homing = SIM_HOMING_NONE;
    drive->zero_deg = here;
    drive->target_deg = here;
    drive->last_target = 0;
    drive->follow_us = SIM_NEVER;
    drive->cycle_us = SIM_NEVER;
    drive->publish_us = SIM_NEVER;
    drive->looked = true;
    drive->status = sim_drive_status(drive);
    drive->objects.statusword = drive->status;
    drive->objects.modes_of_operation_display = drive->mode;
}

static void boot(sim_drive_t *drive)
{
    const tumble_node_binding_t binding = {.port = &drive->port, .variables = &drive->objects, .context = drive};
    wake_up(drive);
    const tumble_status_t status = tumble_node_init(&drive->node, &NODE, &binding);
    assert(status == TUMBLE_OK);
    (void)status;
    drive->powered = true;
    sim_clock_set(drive->clock, SIM_ACTOR_DRIVE, drive->clock->now_us);
}

void sim_drive_init(sim_drive_t *drive, const sim_drive_config_t *config, sim_clock_t *clock, sim_bus_t *bus,
                    uint8_t bus_node, sim_angle_error_t *error, double angle_deg)
{
    memset(drive, 0, sizeof *drive);
    drive->config = config;
    drive->clock = clock;
    drive->bus = (sim_bus_end_t){bus, bus_node};
    drive->port = sim_bus_port(&drive->bus);
    sim_bus_attach(bus, bus_node, SIM_ACTOR_DRIVE);
    sim_axis_init(&drive->axis, &config->axis, error, angle_deg);
    boot(drive);
}

void sim_drive_set_power(sim_drive_t *drive, bool on)
{
    if (on == drive->powered) {
        return;
    }
    sim_bus_set_down(drive->bus.bus, drive->bus.node, !on);
    if (on) {
        boot(drive);
        return;
    }
    drive->powered = false;
    drive->power = SIM_POWER_NOT_READY;
    sim_drive_stop_axis(drive, drive->config->acceleration_deg_s2 * BRAKE_FACTOR);
    sim_clock_set(drive->clock, SIM_ACTOR_DRIVE, SIM_NEVER);
}

void sim_drive_mend(sim_drive_t *drive)
{
    drive->broken = false;
}

void sim_drive_disturb(sim_drive_t *drive)
{
    if (drive->powered) {
        drive->cycle_us = drive->clock->now_us;
        sim_clock_set(drive->clock, SIM_ACTOR_DRIVE, drive->clock->now_us);
    }
}

/* Position and velocity as seen in the last control cycle. True: the position has changed. */
static bool publish_motion(sim_drive_t *drive)
{
    const uint64_t now = drive->clock->now_us;
    double velocity;
    (void)sim_axis_commanded_deg(&drive->axis, now, &velocity);
    const int32_t position = sim_drive_reported_counts(drive, sim_axis_encoder_deg(&drive->axis, now));
    const bool changed = position != drive->objects.position_actual_value;
    drive->objects.position_actual_value = position;
    drive->objects.velocity_actual_value =
        (int32_t)(velocity * (double)drive->config->sign * drive->config->velocity_per_deg_s);
    drive->looked = false;
    return changed;
}

/* The statusword follows after the reaction time. True: it has changed. */
static bool publish_status(sim_drive_t *drive)
{
    const uint64_t now = drive->clock->now_us;
    const uint16_t status = sim_drive_status(drive);
    if (status != drive->status) {
        drive->status = status;
        drive->publish_us = now + drive->config->reaction_us;
    }
    if (drive->publish_us > now) {
        return false;
    }
    const bool changed = drive->objects.statusword != drive->status;
    drive->publish_us = SIM_NEVER;
    drive->objects.statusword = drive->status;
    return changed;
}

/* Refresh what the dictionary shows; what has changed goes out by PDO. */
static void publish(sim_drive_t *drive)
{
    const bool moved = drive->looked && publish_motion(drive);
    const bool changed = publish_status(drive) || moved;
    drive->objects.modes_of_operation_display = drive->mode;
    for (uint8_t number = 0; changed && number < TUMBLE_MAX_TRANSMIT_PDOS; number++) {
        tumble_pdo_trigger(&drive->node.pdos, number);
    }
}

void sim_drive_on_alarm(sim_drive_t *drive)
{
    const uint64_t now = drive->clock->now_us;
    tumble_can_frame_t frame;
    if (!drive->powered) {
        return;
    }
    while (tumble_link_receive(&drive->node.link, &frame) == TUMBLE_OK) {
        (void)tumble_node_receive(&drive->node, &frame, now);
        sim_drive_obey(drive);
    }
    sim_drive_advance(drive);
    publish(drive);
    tumble_node_step(&drive->node, now);
    uint64_t next_us = sim_drive_next_motion_us(drive);
    next_us = (drive->publish_us < next_us) ? drive->publish_us : next_us;
    const uint64_t node_us = sim_clock_again_us(drive->clock, tumble_node_next_us(&drive->node));
    sim_clock_set(drive->clock, SIM_ACTOR_DRIVE, (node_us < next_us) ? node_us : next_us);
}
