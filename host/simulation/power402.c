#include "simulation/power402.h"

#include "canopen/cia402.h"

typedef enum { DISABLE_VOLTAGE, QUICK_STOP, SHUTDOWN, SWITCH_ON, ENABLE } command_t;

/* Bits 0 to 3: switch on, enable voltage, quick stop (active when 0), enable operation. */
static command_t command_of(uint16_t controlword)
{
    if ((controlword & 0x0002U) == 0U) {
        return DISABLE_VOLTAGE;
    }
    if ((controlword & 0x0004U) == 0U) {
        return QUICK_STOP;
    }
    if ((controlword & 0x0001U) == 0U) {
        return SHUTDOWN;
    }
    return ((controlword & 0x0008U) == 0U) ? SWITCH_ON : ENABLE;
}

static sim_power_t from_ready(command_t command)
{
    switch (command) {
    case DISABLE_VOLTAGE:
    case QUICK_STOP:
        return SIM_POWER_SWITCH_ON_DISABLED;
    case SWITCH_ON:
        return SIM_POWER_SWITCHED_ON;
    case ENABLE:
        return SIM_POWER_OPERATION_ENABLED; /* through Switched on */
    default:
        return SIM_POWER_READY_TO_SWITCH_ON;
    }
}

static sim_power_t from_powered(command_t command, bool enabled)
{
    switch (command) {
    case DISABLE_VOLTAGE:
        return SIM_POWER_SWITCH_ON_DISABLED;
    case QUICK_STOP:
        return enabled ? SIM_POWER_QUICK_STOP_ACTIVE : SIM_POWER_SWITCH_ON_DISABLED;
    case SHUTDOWN:
        return SIM_POWER_READY_TO_SWITCH_ON;
    case SWITCH_ON:
        return SIM_POWER_SWITCHED_ON;
    default:
        return SIM_POWER_OPERATION_ENABLED;
    }
}

sim_power_t sim_power_next(sim_power_t state, uint16_t controlword, uint16_t previous, bool cause_gone)
{
    const command_t command = command_of(controlword);
    switch (state) {
    case SIM_POWER_SWITCH_ON_DISABLED:
        return (command == SHUTDOWN) ? SIM_POWER_READY_TO_SWITCH_ON : state;
    case SIM_POWER_READY_TO_SWITCH_ON:
        return from_ready(command);
    case SIM_POWER_SWITCHED_ON:
    case SIM_POWER_OPERATION_ENABLED:
        return from_powered(command, state == SIM_POWER_OPERATION_ENABLED);
    case SIM_POWER_QUICK_STOP_ACTIVE:
        return (command == DISABLE_VOLTAGE) ? SIM_POWER_SWITCH_ON_DISABLED : state;
    case SIM_POWER_FAULT: {
        const uint16_t risen = (uint16_t)(controlword & (uint16_t)~previous & TUMBLE_402_CONTROL_FAULT_RESET);
        return (risen != 0U && cause_gone) ? SIM_POWER_SWITCH_ON_DISABLED : state;
    }
    default:
        return state; /* Not ready and Fault reaction are left by the drive itself */
    }
}

uint16_t sim_power_status(sim_power_t state)
{
    static const uint16_t BITS[] = {
        [SIM_POWER_NOT_READY] = TUMBLE_402_STATE_NOT_READY,
        [SIM_POWER_SWITCH_ON_DISABLED] = TUMBLE_402_STATE_SWITCH_ON_DISABLED,
        [SIM_POWER_READY_TO_SWITCH_ON] = TUMBLE_402_STATE_READY_TO_SWITCH_ON,
        [SIM_POWER_SWITCHED_ON] = TUMBLE_402_STATE_SWITCHED_ON,
        [SIM_POWER_OPERATION_ENABLED] = TUMBLE_402_STATE_OPERATION_ENABLED,
        [SIM_POWER_QUICK_STOP_ACTIVE] = TUMBLE_402_STATE_QUICK_STOP_ACTIVE,
        [SIM_POWER_FAULT_REACTION] = TUMBLE_402_STATE_FAULT_REACTION,
        [SIM_POWER_FAULT] = TUMBLE_402_STATE_FAULT,
    };
    return BITS[state] | TUMBLE_402_STATUS_VOLTAGE;
}
