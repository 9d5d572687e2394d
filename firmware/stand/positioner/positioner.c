#include "stand/positioner/positioner.h"

#include "core/arith.h"
#include "core/count.h"
#include "stand/bounds.h"

#include <stddef.h>

#define US_PER_MS UINT64_C(1000)
#define TURN_DEG 360.0

#define WRITE_AT 0U
#define WRITE_WATCH 1U /* so many registers */
#define WRITE_ORDER 5U
#define READ_AT 16U

#define IDENTITY 0x5450U
#define IS_MOVING 1U
#define IS_IN_POSITION 2U
#define IS_HOMED 4U
#define IS_FAULT 8U
#define IS_WATCHED 16U
#define IS_ANY 31U
#define COUNT_MDEG 100U /* flickers by more are no axis that is good for a calibration */

enum { ORDER_STOP = 0, ORDER_HOME, ORDER_GO, ORDER_RESET };
enum { READ_IDENTITY = 0, READ_STATUS, READ_NUMBER, READ_FAULT, READ_ANGLE, READ_ANGLE_LOW, READ_COUNT };

static bool is(const tumble_positioner_t *axis, tumble_stand_state_t state)
{
    return axis->state == (uint8_t)state;
}

static int64_t distance(int64_t a, int64_t b)
{
    return (a > b) ? (a - b) : (b - a);
}

static bool is_stopping(const tumble_positioner_t *axis)
{
    return axis->rung != (uint8_t)TUMBLE_RUNG_NONE;
}

static bool is_at_rest(const tumble_positioner_t *axis)
{
    return is(axis, TUMBLE_STAND_READY) || is(axis, TUMBLE_STAND_IN_POSITION) || is(axis, TUMBLE_STAND_STOPPED);
}

/* What is ordered of the controller. */

/* Tell the order once more, as a new one: with the next exchange, which goes at once. No order has the number 0. */
static void renew_order(tumble_positioner_t *axis)
{
    axis->number = (axis->number == UINT16_MAX) ? 1U : (uint16_t)(axis->number + 1U);
    axis->taken = false;
    axis->restart_timer = true;
}

/* Order it, as something new. */
static void send_order(tumble_positioner_t *axis, unsigned order)
{
    const bool stops = (order == (unsigned)ORDER_STOP) || (order == (unsigned)ORDER_RESET);
    axis->order = (uint8_t)order;
    axis->travelled = 0;
    axis->rung = (uint8_t)(stops ? TUMBLE_RUNG_TOLD : TUMBLE_RUNG_NONE);
    renew_order(axis);
}

/* Order a stop. One that is under way is not begun anew: its harsher means must come. */
static void halt(tumble_positioner_t *axis)
{
    if (!is_stopping(axis)) {
        send_order(axis, ORDER_STOP);
    }
}

/* Stop and wait for clear_fault; in FAULT, stop again. */
static void fail(tumble_positioner_t *axis, tumble_stand_fault_t fault)
{
    if (!is(axis, TUMBLE_STAND_FAULT)) {
        axis->fault = (uint8_t)fault;
        axis->state = (uint8_t)TUMBLE_STAND_FAULT;
    }
    if (axis->known) { /* else nothing has been set going */
        halt(axis);
    }
}

/* What the controller reports, what is wrong with it, and when an order has come to its end. */

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
static void check_report(tumble_positioner_t *axis, uint16_t number, uint16_t code)
{
    if (number == axis->number) {
        axis->taken = true;
        const bool first = !is(axis, TUMBLE_STAND_FAULT);
        const tumble_stand_fault_t fault = first ? fault_of(axis) : further_fault_of(axis);
        if (fault != TUMBLE_STAND_FAULT_NONE) {
            axis->report.fault_code = first ? code : axis->report.fault_code;
            fail(axis, fault);
        }
        if (axis->taken && !has(axis, IS_MOVING)) {
            come_to_rest(axis);
        }
    } else if (axis->taken) {
        fail(axis, (number == 0U) ? TUMBLE_STAND_FAULT_POWER : TUMBLE_STAND_FAULT_FOREIGN);
    } else {
        /* the order is on its way */
    }
}

static int32_t mdeg_of(const tumble_positioner_t *axis, double counts)
{
    return tumble_thousandths(counts / axis->profile->counts_per_deg);
}

/* What bounds the motion that the controller makes. How it starts and brakes is its own affair. */
static void set_motion_bounds(tumble_positioner_t *axis)
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

static void take_report(tumble_positioner_t *axis, const uint16_t *values)
{
    const uint16_t status = values[READ_STATUS];
    const int32_t before = axis->actual;
    const bool contradicts = ((status & IS_MOVING) != 0U) && ((status & IS_IN_POSITION) != 0U);
    if ((values[READ_IDENTITY] != IDENTITY) || ((status & ~IS_ANY) != 0U) || contradicts) {
        tumble_count(&axis->report.stop.implausible);
        fail(axis, TUMBLE_STAND_FAULT_PROTOCOL);
        return;
    }
    axis->heard_us = axis->now_us;
    axis->status = status;
    axis->actual = counts_at(&values[READ_ANGLE]);
    if (!axis->known) { /* nothing is written before it is known what is there */
        axis->known = true;
        axis->number = values[READ_NUMBER];
        send_order(axis, axis->order);
        return;
    }
    axis->travelled += has(axis, IS_HOMED) ? 0U : (uint64_t)distance(axis->actual, before);
    check_report(axis, values[READ_NUMBER], values[READ_FAULT]);
    set_motion_bounds(axis);
}

/* The course of time. */

static void receive(tumble_positioner_t *axis)
{
    const tumble_exchange_link_t *link = axis->profile->link;
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS];
    const tumble_status_t status = axis->under_way ? link->end(link->context, values) : TUMBLE_E_PORT_BUSY;
    axis->under_way = axis->under_way && (status == TUMBLE_E_PORT_BUSY);
    if (status == TUMBLE_OK) {
        take_report(axis, values);
    } else if (status == TUMBLE_E_FRAME) {
        fail(axis, TUMBLE_STAND_FAULT_PROTOCOL);
    } else {
        /* the time will tell */
    }
}

static bool has_passed(const tumble_positioner_t *axis, uint64_t since_us, uint32_t ms)
{
    return (axis->now_us - since_us) >= (ms * US_PER_MS);
}

/* For so long nothing is exchanged: the watchdog runs out, and the axis brakes. */
static uint32_t silent_ms(const tumble_positioner_profile_t *profile)
{
    return (uint32_t)profile->watch_ms + profile->stop_timeout_ms;
}

static void climb(tumble_positioner_t *axis)
{
    const tumble_positioner_profile_t *profile = axis->profile;
    const bool told = (axis->rung == (uint8_t)TUMBLE_RUNG_TOLD);
    const uint32_t ms = told ? profile->stop_timeout_ms : (silent_ms(profile) + profile->silence_ms);
    if ((axis->rung < (uint8_t)TUMBLE_RUNG_UNCONFIRMED) && has_passed(axis, axis->since_us, ms)) {
        fail(axis, TUMBLE_STAND_FAULT_STOP);
        axis->rung = (uint8_t)(told ? TUMBLE_RUNG_SILENCE : TUMBLE_RUNG_UNCONFIRMED);
        renew_order(axis); /* as soon as it is not silent */
        tumble_count(&axis->report.stop.rungs[axis->rung - (uint8_t)TUMBLE_RUNG_AGAIN]);
    }
}

static void watch(tumble_positioner_t *axis)
{
    const tumble_positioner_profile_t *profile = axis->profile;
    const bool silent = has_passed(axis, axis->heard_us, profile->silence_ms);
    if (axis->known && silent && !is(axis, TUMBLE_STAND_FAULT)) {
        fail(axis, TUMBLE_STAND_FAULT_HEARTBEAT);
    } else if (is_stopping(axis)) {
        climb(axis);
    } else if (is(axis, TUMBLE_STAND_HOMING) && has_passed(axis, axis->since_us, profile->home_timeout_ms)) {
        fail(axis, TUMBLE_STAND_FAULT_HOMING);
    } else if (is(axis, TUMBLE_STAND_MOVING) && has_passed(axis, axis->since_us, profile->move_timeout_ms)) {
        fail(axis, TUMBLE_STAND_FAULT_TIMEOUT);
    } else {
        /* nothing is late */
    }
}

/* Nothing, before it is known what is there; the order, until it is taken: a controller that was switched off must not find
 * it again. */
static uint8_t registers_to_write(const tumble_positioner_t *axis)
{
    if (!axis->known) {
        return 0U;
    }
    return axis->taken ? WRITE_WATCH : WRITE_ORDER;
}

static void send(tumble_positioner_t *axis)
{
    const tumble_positioner_profile_t *profile = axis->profile;
    const uint32_t target = (uint32_t)axis->target;
    const tumble_exchange_t exchange = {
        .write_at = WRITE_AT,
        .read_at = READ_AT,
        .writes = registers_to_write(axis),
        .reads = READ_COUNT,
        .values = {profile->watch_ms, axis->number, axis->order, (uint16_t)(target >> 16U), (uint16_t)target, 0U},
    };
    const bool silent = (axis->rung == (uint8_t)TUMBLE_RUNG_SILENCE) &&
                        (axis->restart_timer || !has_passed(axis, axis->since_us, silent_ms(profile)));
    axis->due_us = axis->now_us + (profile->cycle_ms * US_PER_MS);
    if (!axis->under_way && !silent) {
        axis->under_way = (profile->link->begin(profile->link->context, &exchange) == TUMBLE_OK);
    }
}

static void positioner_step(void *self, uint64_t now_us)
{
    tumble_positioner_t *axis = self;
    axis->now_us = now_us;
    receive(axis);
    if (axis->restart_timer) {
        axis->restart_timer = false;
        axis->since_us = now_us;
        axis->due_us = now_us;
    }
    watch(axis);
    if (now_us >= axis->due_us) {
        send(axis);
    }
}

static uint64_t positioner_next_us(const void *self)
{
    const tumble_positioner_t *axis = self;
    return axis->restart_timer ? 0U : axis->due_us;
}

/* What the rest of the firmware asks for. */

static bool is_usable(const tumble_positioner_profile_t *profile)
{
    return (profile != NULL) && (profile->link != NULL) && (profile->link->begin != NULL) &&
           (profile->link->end != NULL) && tumble_is_positive(tumble_abs(profile->counts_per_deg)) &&
           tumble_is_positive(profile->window_deg) && (profile->speed_deg_s >= 0.0) &&
           tumble_is_finite(profile->speed_deg_s) && (profile->home_timeout_ms != 0U) &&
           (profile->move_timeout_ms != 0U) && (profile->stop_timeout_ms != 0U) && (profile->cycle_ms != 0U) &&
           ((profile->silence_ms / 2U) >= profile->cycle_ms) && ((profile->watch_ms / 2U) >= profile->cycle_ms);
}

/* Beyond what 32 bits hold: false. */
static bool to_counts(const tumble_positioner_profile_t *profile, double angle_deg, int32_t *counts)
{
    const double exact = angle_deg * profile->counts_per_deg;
    if (!tumble_within(exact, (double)INT32_MAX)) {
        return false;
    }
    *counts = (int32_t)tumble_nearest(exact);
    return true;
}

static tumble_status_t positioner_init(void *self, const tumble_stand_setup_t *setup)
{
    tumble_positioner_t *axis = self;
    const tumble_positioner_profile_t *profile = setup->profile;
    int32_t window = 0;
    int32_t from = 0;
    int32_t to = 0;
    int32_t turn = 0;
    if (!is_usable(profile) || !to_counts(profile, profile->window_deg, &window) ||
        !to_counts(profile, setup->cable_min_deg, &from) || !to_counts(profile, setup->cable_max_deg, &to) ||
        !to_counts(profile, TURN_DEG, &turn)) {
        return TUMBLE_E_ARGUMENT;
    }
    const int64_t window_counts = distance(window, 0);
    *axis = (tumble_positioner_t){
        .report = {.stop = axis->report.stop, .bounds = {.lost = axis->report.bounds.lost}},
        .profile = profile,
        .window_counts = window_counts,
        .lowest_counts = (int64_t)((from < to) ? from : to) - window_counts,
        .highest_counts = (int64_t)((from < to) ? to : from) + window_counts,
        .most_travel = (uint64_t)(distance(to, from) + distance(turn, 0)),
    };
    return TUMBLE_OK;
}

static tumble_status_t set_out(tumble_positioner_t *axis, unsigned order, tumble_stand_state_t state, int32_t target)
{
    if (!is_at_rest(axis) || ((order == (unsigned)ORDER_GO) && is(axis, TUMBLE_STAND_READY))) {
        return TUMBLE_E_STAND_STATE;
    }
    axis->target = target;
    axis->state = (uint8_t)state;
    send_order(axis, order);
    return TUMBLE_OK;
}

static tumble_status_t positioner_home(void *self)
{
    return set_out(self, ORDER_HOME, TUMBLE_STAND_HOMING, 0);
}

static tumble_status_t positioner_move(void *self, double angle_deg)
{
    const tumble_positioner_t *axis = self;
    int32_t target = 0;
    return to_counts(axis->profile, angle_deg, &target) ? set_out(self, ORDER_GO, TUMBLE_STAND_MOVING, target)
                                                        : TUMBLE_E_ARGUMENT;
}

static void positioner_stop(void *self)
{
    tumble_positioner_t *axis = self;
    if (is(axis, TUMBLE_STAND_OFFLINE)) {
        return; /* it has no other order */
    }
    halt(axis);
    if (!is(axis, TUMBLE_STAND_FAULT)) {
        axis->state = (uint8_t)TUMBLE_STAND_MOVING; /* until it is seen at rest */
    }
}

static tumble_status_t positioner_clear_fault(void *self)
{
    tumble_positioner_t *axis = self;
    const bool enforces = is_stopping(axis) && (axis->rung != (uint8_t)TUMBLE_RUNG_UNCONFIRMED);
    if (!is(axis, TUMBLE_STAND_FAULT) || enforces) {
        return TUMBLE_E_STAND_STATE;
    }
    axis->state = (uint8_t)TUMBLE_STAND_OFFLINE;
    axis->fault = (uint8_t)TUMBLE_STAND_FAULT_NONE;
    axis->report.fault_code = 0;
    axis->rung = (uint8_t)TUMBLE_RUNG_NONE;
    axis->order = (uint8_t)ORDER_RESET;
    axis->known = false;
    return TUMBLE_OK;
}

static tumble_stand_state_t positioner_state(const void *self)
{
    return (tumble_stand_state_t)((const tumble_positioner_t *)self)->state;
}

static tumble_stand_fault_t positioner_fault(const void *self)
{
    return (tumble_stand_fault_t)((const tumble_positioner_t *)self)->fault;
}

static double positioner_angle_deg(const void *self)
{
    const tumble_positioner_t *axis = self;
    return (double)axis->actual / axis->profile->counts_per_deg;
}

const tumble_stand_kind_t tumble_positioner_kind = {
    .bytes = (uint16_t)sizeof(tumble_positioner_t),
    .report_at = (uint16_t)offsetof(tumble_positioner_t, report),
    .numbers = {{(uint8_t)TUMBLE_STAND_NUMBER_F64, (uint8_t)offsetof(tumble_positioner_profile_t, counts_per_deg)},
                {(uint8_t)TUMBLE_STAND_NUMBER_NONE, 0U},
                {(uint8_t)TUMBLE_STAND_NUMBER_NONE, 0U}},
    TUMBLE_STAND_FUNCTIONS(positioner),
};
