/* What is ordered of the controller. */
#include "stand/positioner/internal.h"

void tumble_positioner_tell(tumble_positioner_t *axis)
{
    axis->number = (axis->number == UINT16_MAX) ? 1U : (uint16_t)(axis->number + 1U);
    axis->taken = false;
    axis->restart_timer = true;
}

void tumble_positioner_give(tumble_positioner_t *axis, unsigned order)
{
    const bool stops = (order == (unsigned)ORDER_STOP) || (order == (unsigned)ORDER_RESET);
    axis->order = (uint8_t)order;
    axis->travelled = 0;
    axis->rung = (uint8_t)(stops ? TUMBLE_RUNG_TOLD : TUMBLE_RUNG_NONE);
    tumble_positioner_tell(axis);
}

void tumble_positioner_halt(tumble_positioner_t *axis)
{
    if (!is_stopping(axis)) {
        tumble_positioner_give(axis, ORDER_STOP);
    }
}

void tumble_positioner_fail(tumble_positioner_t *axis, tumble_stand_fault_t fault)
{
    if (!is(axis, TUMBLE_STAND_FAULT)) {
        axis->fault = (uint8_t)fault;
        axis->state = (uint8_t)TUMBLE_STAND_FAULT;
    }
    if (axis->known) { /* else nothing has been set going */
        tumble_positioner_halt(axis);
    }
}
