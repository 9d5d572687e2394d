#include "simulation/drive_internal.h"

/* 605Ah */
#define QUICK_STOP_BY_ITS_OWN_RAMP 2

#define COAST_FACTOR 0.1 /* without voltage friction alone holds the axis: so much of what the motor can do */

static double quick_deceleration(const sim_drive_t *drive)
{
    const bool own = drive->objects.quick_stop_option_code == QUICK_STOP_BY_ITS_OWN_RAMP;
    return sim_drive_acceleration(drive,
                                  own ? drive->objects.quick_stop_deceleration : drive->objects.profile_deceleration);
}

static double deceleration_into(const sim_drive_t *drive, sim_power_t power)
{
    switch (power) {
    case SIM_POWER_QUICK_STOP_ACTIVE:
    case SIM_POWER_FAULT_REACTION:
        return quick_deceleration(drive);
    case SIM_POWER_SWITCH_ON_DISABLED:
        return drive->config->acceleration_deg_s2 * COAST_FACTOR;
    default:
        return sim_drive_dynamics(drive).deceleration_deg_s2;
    }
}

void sim_drive_enter(sim_drive_t *drive, sim_power_t power)
{
    const sim_power_t before = drive->power;
    const bool brakes = before == SIM_POWER_QUICK_STOP_ACTIVE && drive->clock->now_us < sim_axis_end_us(&drive->axis);
    if (power == before) {
        return;
    }
    drive->power = power;
    if (power == SIM_POWER_OPERATION_ENABLED) {
        drive->target_deg = drive->axis.motion.end_position;
        drive->reached = true;
        drive->halted = false;
        drive->acknowledged = false;
        drive->unused = drive->config->acknowledges_enabling;
    } else if (before == SIM_POWER_OPERATION_ENABLED || brakes) {
        sim_drive_stop_axis(drive, deceleration_into(drive, power));
    }
    if (before == SIM_POWER_FAULT && power == SIM_POWER_SWITCH_ON_DISABLED) {
        drive->objects.error_code = 0;
        tumble_emcy_clear(&drive->node.emcy, TUMBLE_ERROR_MANUFACTURER);
    }
}

static bool stands(const sim_drive_t *drive)
{
    double velocity;
    (void)sim_axis_commanded_deg(&drive->axis, drive->clock->now_us, &velocity);
    return velocity == 0.0;
}

static uint16_t profile_position_status(const sim_drive_t *drive)
{
    const bool reached = (drive->halted || drive->reached) && stands(drive);
    return (
        uint16_t)((reached ? TUMBLE_402_STATUS_TARGET_REACHED : 0U) |
                  ((drive->acknowledged || drive->unused) ? TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE : 0U) |
                  ((drive->objects.error_code == TUMBLE_402_ERROR_FOLLOWING) ? TUMBLE_402_STATUS_FOLLOWING_ERROR : 0U));
}

static uint16_t homing_status(const sim_drive_t *drive)
{
    switch (drive->homing) {
    case SIM_HOMING_ATTAINED:
        return TUMBLE_402_STATUS_HOMING_ATTAINED | TUMBLE_402_STATUS_TARGET_REACHED;
    case SIM_HOMING_ERROR:
        return TUMBLE_402_STATUS_HOMING_ERROR | TUMBLE_402_STATUS_TARGET_REACHED;
    case SIM_HOMING_NONE:
        return stands(drive) ? TUMBLE_402_STATUS_TARGET_REACHED : 0U; /* interrupted or not started */
    default:
        return 0;
    }
}

uint16_t sim_drive_status(const sim_drive_t *drive)
{
    uint16_t status = sim_power_status(drive->power) | TUMBLE_402_STATUS_REMOTE;
    status |= drive->limited ? TUMBLE_402_STATUS_LIMIT_ACTIVE : 0U;
    if (drive->mode == TUMBLE_402_MODE_PROFILE_POSITION) {
        status |= profile_position_status(drive);
    } else if (drive->mode == TUMBLE_402_MODE_HOMING) {
        status |= homing_status(drive);
    }
    return status;
}

/* Quick stop and fault reaction end when the axis rests. */
void sim_drive_finish_stop(sim_drive_t *drive)
{
    if (drive->clock->now_us < sim_axis_end_us(&drive->axis)) {
        return;
    }
    if (drive->power == SIM_POWER_QUICK_STOP_ACTIVE) {
        sim_drive_enter(drive, SIM_POWER_SWITCH_ON_DISABLED);
    } else if (drive->power == SIM_POWER_FAULT_REACTION) {
        sim_drive_enter(drive, SIM_POWER_FAULT);
    }
}

void sim_drive_fail(sim_drive_t *drive, uint16_t code, bool lasting)
{
    if (!drive->powered) {
        return;
    }
    drive->broken = drive->broken || lasting;
    drive->objects.error_code = code;
    if (code != TUMBLE_402_ERROR_HEARTBEAT) { /* the node reports that one by itself */
        tumble_emcy_raise(&drive->node.emcy, code, TUMBLE_ERROR_MANUFACTURER, NULL);
    }
    sim_drive_enter(drive, SIM_POWER_FAULT_REACTION);
    sim_clock_set(drive->clock, SIM_ACTOR_DRIVE, drive->clock->now_us);
}
