/* power402.h - the power state machine of a CiA 402 drive (CiA 402-2, figure 9): what a controlword makes of a state.
 *
 * Pure functions over the closed list of states; what a transition does to the axis is its caller's business.
 */
#ifndef TUMBLE_SIMULATION_POWER402_H
#define TUMBLE_SIMULATION_POWER402_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    SIM_POWER_NOT_READY = 0,
    SIM_POWER_SWITCH_ON_DISABLED,
    SIM_POWER_READY_TO_SWITCH_ON,
    SIM_POWER_SWITCHED_ON,
    SIM_POWER_OPERATION_ENABLED,
    SIM_POWER_QUICK_STOP_ACTIVE,
    SIM_POWER_FAULT_REACTION,
    SIM_POWER_FAULT
} sim_power_t;

/* The state that `controlword` leads to. A fault reset acts on its rising edge against `previous`, and only when the
 * cause of the fault is gone. */
sim_power_t sim_power_next(sim_power_t state, uint16_t controlword, uint16_t previous, bool cause_gone);

/* Bits 0 to 6 of the statusword (with bit 4, voltage, always on). */
uint16_t sim_power_status(sim_power_t state);

#endif
