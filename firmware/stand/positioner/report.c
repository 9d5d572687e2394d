/* What the controller reports, what is wrong with it, and when an order has come to its end. */
#include "stand/positioner/internal.h"

#include "core/arith.h"
#include "core/count.h"
#include "stand/bounds.h"

#define IDENTITY 0x5450U
#define IS_MOVING 1U
#define IS_IN_POSITION 2U
#define IS_HOMED 4U
#define IS_FAULT 8U
#define IS_WATCHED 16U
#define IS_ANY 31U
#define COUNT_MDEG 100U /* flickers by more are no axis that is good for a calibration */

static bool has(const tumble_positioner_t *axis, unsigned bit)
{
    return (axis->status & bit) != 0U;
}

/* In FAULT the axis may still be set going, such as by an order that was given up and arrives late. */
static tumble_stand_fault_t further_fault_of(const tumble_positioner_t *axis)
{
    return has(axis, IS_MOVING) ? TUMBLE_STAND_FAULT_POSITION : TUMBLE_STAND_FAULT_NONE;
}

/* What is wrong with a controller that has our order. */
static tumble_stand_fault_t fault_of(const tumble_positioner_t *axis)
{
    const bool moves = is(axis, TUMBLE_STAND_MOVING) && !is_stopping(axis);
    const bool held = is(axis, TUMBLE_STAND_IN_POSITION) || is(axis, TUMBLE_STAND_STOPPED);
    const bool strayed = distance(axis->actual, axis->target) > axis->window_counts;
    const bool outside = (axis->actual < axis->lowest_counts) || (axis->actual > axis->highest_counts);
    tumble_stand_fault_t fault = TUMBLE_STAND_FAULT_NONE;
    if (has(axis, IS_FAULT)) {
        fault = TUMBLE_STAND_FAULT_DRIVE;
    } else if (!has(axis, IS_WATCHED)) {
        fault = is(axis, TUMBLE_STAND_OFFLINE) ? TUMBLE_STAND_FAULT_PROTOCOL : TUMBLE_STAND_FAULT_POWER;
    } else if (((moves || held) && !has(axis, IS_HOMED)) || (held && strayed) || (moves && outside) ||
               (is_at_rest(axis) && has(axis, IS_MOVING))) {
        fault = TUMBLE_STAND_FAULT_POSITION;
    } else if (is(axis, TUMBLE_STAND_HOMING) && (axis->travelled > axis->most_travel)) {
        fault = TUMBLE_STAND_FAULT_HOMING;
    } else {
        /* all is well */
    }
    return fault;
}

/* The end of what was ordered, if the axis rests; in FAULT only the stop has an end. */
static void come_to_rest(tumble_positioner_t *axis)
{
    const bool there = has(axis, IS_IN_POSITION) && has(axis, IS_HOMED) &&
                       (distance(axis->actual, axis->target) <= axis->window_counts);
    if (is_stopping(axis)) {
        axis->rung = (uint8_t)TUMBLE_RUNG_NONE;
        if (!is(axis, TUMBLE_STAND_FAULT)) {
            axis->target = axis->actual;
            axis->state = (uint8_t)(has(axis, IS_HOMED) ? TUMBLE_STAND_STOPPED : TUMBLE_STAND_READY);
        }
    } else if ((is(axis, TUMBLE_STAND_HOMING) || is(axis, TUMBLE_STAND_MOVING)) && there) {
        axis->state = (uint8_t)TUMBLE_STAND_IN_POSITION;
    } else {
        /* it has not set out yet, or rested before */
    }
}

/* Until the controller has our order, its report tells of the one before. */
static void look(tumble_positioner_t *axis, uint16_t number, uint16_t code)
{
    if (number == axis->number) {
        axis->taken = true;
        const bool first = !is(axis, TUMBLE_STAND_FAULT);
        const tumble_stand_fault_t fault = first ? fault_of(axis) : further_fault_of(axis);
        if (fault != TUMBLE_STAND_FAULT_NONE) {
            axis->report.fault_code = first ? code : axis->report.fault_code;
            tumble_positioner_fail(axis, fault);
        }
        if (axis->taken && !has(axis, IS_MOVING)) {
            come_to_rest(axis);
        }
    } else if (axis->taken) {
        tumble_positioner_fail(axis, (number == 0U) ? TUMBLE_STAND_FAULT_POWER : TUMBLE_STAND_FAULT_FOREIGN);
    } else {
        /* the order is on its way */
    }
}

static int32_t mdeg_of(const tumble_positioner_t *axis, double counts)
{
    return tumble_thousandths(counts / axis->profile->counts_per_deg);
}

/* What bounds the motion that the controller makes. How it starts and brakes is its own affair. */
static void tell_motion(tumble_positioner_t *axis)
{
    const bool homes = is(axis, TUMBLE_STAND_HOMING);
    const bool turns = axis->taken && !is_stopping(axis) && (homes || is(axis, TUMBLE_STAND_MOVING));
    const double travel = tumble_abs((double)axis->most_travel / axis->profile->counts_per_deg);
    axis->report.motion = (tumble_stand_motion_t){0, 0, 0, 0, 0};
    if (turns) {
        axis->report.motion = (tumble_stand_motion_t){
            .speed_mdeg_s = (uint32_t)tumble_thousandths(axis->profile->speed_deg_s),
            .ramp_ms = 0U,
            .count_mdeg = COUNT_MDEG,
            .to_mdeg = homes ? tumble_thousandths(travel) : mdeg_of(axis, (double)axis->target),
        };
    }
}

static int32_t counts_at(const uint16_t *values)
{
    const uint32_t raw = ((uint32_t)values[0] << 16U) | values[1];
    return (raw <= (uint32_t)INT32_MAX) ? (int32_t)raw : -(int32_t)(UINT32_MAX - raw) - 1;
}

void tumble_positioner_report(tumble_positioner_t *axis, const uint16_t *values)
{
    const uint16_t status = values[READ_STATUS];
    const int32_t before = axis->actual;
    const bool contradicts = ((status & IS_MOVING) != 0U) && ((status & IS_IN_POSITION) != 0U);
    if ((values[READ_IDENTITY] != IDENTITY) || ((status & ~IS_ANY) != 0U) || contradicts) {
        tumble_count(&axis->report.stop.implausible);
        tumble_positioner_fail(axis, TUMBLE_STAND_FAULT_PROTOCOL);
        return;
    }
    axis->heard_us = axis->now_us;
    axis->status = status;
    axis->actual = counts_at(&values[READ_ANGLE]);
    if (!axis->known) { /* nothing is written before it is known what is there */
        axis->known = true;
        axis->number = values[READ_NUMBER];
        tumble_positioner_give(axis, axis->order);
        return;
    }
    axis->travelled += has(axis, IS_HOMED) ? 0U : (uint64_t)distance(axis->actual, before);
    look(axis, values[READ_NUMBER], values[READ_FAULT]);
    tell_motion(axis);
}
