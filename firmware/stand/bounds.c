#include "stand/bounds.h"

#include "core/arith.h"
#include "core/one_copy.h"

#define MS_PER_S 1000U
/* What calls the kind stays one function, so that firmware/calls.csv can name it. */

#define LEAST_CHANGE_MDEG 20U /* less is no progress */
#define LOOKS 3U              /* in a row that must agree */
#define LEAST_LOOK_MS 64U
#define TICK 10U /* times are counted in units of 2^10 us */
#define MS_PER_LOST_TICK 43U

int32_t tumble_thousandths(double quantity)
{
    return tumble_within(quantity, 1e6) ? (int32_t)tumble_nearest(quantity * 1000.0) : 1000000000;
}

static tumble_motion_bounds_t *bounds_of(const tumble_stand_t *stand)
{
    void *report = (uint8_t *)stand->self + stand->kind->report_at;
    return &((tumble_stand_report_t *)report)->bounds;
}

static uint32_t distance(int32_t a, int32_t b)
{
    return (a > b) ? ((uint32_t)a - (uint32_t)b) : ((uint32_t)b - (uint32_t)a);
}

TUMBLE_ONE_COPY static int32_t here_mdeg(const tumble_stand_t *stand)
{
    return tumble_thousandths(stand->kind->angle_deg(stand->self));
}

static bool is_at_goal(const tumble_motion_bounds_t *bounds, int32_t here)
{
    return bounds->homes || (distance(here, bounds->goal_mdeg) <= (uint32_t)TUMBLE_OVERSHOOT_MDEG);
}

/* Within 30 %. */
static bool is_about(uint32_t speed, uint32_t told)
{
    return distance((int32_t)speed, (int32_t)told) <= ((told / 10U) * 3U);
}

/* Has the axis a steady speed that it was not told? */
static bool is_out_of_pace(tumble_motion_bounds_t *bounds, const tumble_stand_motion_t *told, uint32_t speed)
{
    const bool both_mad = ((speed / 2U) > told->speed_mdeg_s) && ((bounds->speed_mdeg_s / 2U) > told->speed_mdeg_s);
    const bool agrees =
        both_mad || (distance((int32_t)speed, (int32_t)bounds->speed_mdeg_s) <= (bounds->speed_mdeg_s / 8U));
    const uint32_t slow = bounds->homes ? told->slow_mdeg_s : told->speed_mdeg_s;
    bounds->looks = agrees ? (uint8_t)(bounds->looks + 1U) : 1U;
    bounds->speed_mdeg_s = speed;
    return (bounds->looks >= LOOKS) && (speed > (slow / 16U)) && (slow != 0U) && !is_about(speed, slow) &&
           !is_about(speed, told->speed_mdeg_s);
}

/* The motion is set going: from now on its time counts. */
static void set_out(tumble_motion_bounds_t *bounds, const tumble_stand_motion_t *told, int32_t here, uint32_t now)
{
    const uint32_t way = bounds->homes ? (uint32_t)told->to_mdeg : distance(told->to_mdeg, here);
    const uint32_t eighths = (told->speed_mdeg_s / 125U) + ((told->speed_mdeg_s < 125U) ? 1U : 0U); /* deg/s */
    const uint32_t ms = ((way * 8U) / eighths) + told->ramp_ms; /* mdeg over deg/s; ways are shorter than 2^29 mdeg */
    bounds->told = true;
    bounds->due = now + (ms - (ms / MS_PER_LOST_TICK));
    bounds->looked = now;
    bounds->looks = 0;
    bounds->from_mdeg = here;
}

static tumble_stand_fault_t judge(tumble_motion_bounds_t *bounds, const tumble_stand_motion_t *told, int32_t here,
                                  uint32_t now, uint32_t margin_ms)
{
    if ((here < bounds->lowest_mdeg) || (here > bounds->highest_mdeg)) {
        return TUMBLE_STAND_FAULT_RUNAWAY;
    }
    if (told->speed_mdeg_s == 0U) {
        bounds->told = false;
        return TUMBLE_STAND_FAULT_NONE;
    }
    if (!bounds->told) {
        set_out(bounds, told, here, now);
    }
    if ((int32_t)(now - bounds->due) > (int32_t)margin_ms) {
        return bounds->homes ? TUMBLE_STAND_FAULT_HOMING : TUMBLE_STAND_FAULT_TIMEOUT;
    }
    const uint32_t passed = now - bounds->looked;
    const uint32_t change = distance(here, bounds->from_mdeg);
    if (change <= ((told->count_mdeg > LEAST_CHANGE_MDEG) ? told->count_mdeg : LEAST_CHANGE_MDEG)) {
        const bool stalls = (passed > (margin_ms / 2U)) && (bounds->homes || !is_at_goal(bounds, here));
        return stalls ? TUMBLE_STAND_FAULT_STALL : TUMBLE_STAND_FAULT_NONE;
    }
    if ((here == bounds->before_mdeg) || (passed < LEAST_LOOK_MS) || (passed < (told->ramp_ms / 4U))) {
        return TUMBLE_STAND_FAULT_NONE; /* no new report, or too soon */
    }
    bounds->looked = now;
    bounds->from_mdeg = here;
    return is_out_of_pace(bounds, told, (change * MS_PER_S) / passed) ? TUMBLE_STAND_FAULT_SCALE
                                                                      : TUMBLE_STAND_FAULT_NONE;
}

TUMBLE_ONE_COPY void tumble_stand_step(const tumble_stand_t *stand, uint64_t now_us, uint32_t margin_ms)
{
    tumble_motion_bounds_t *bounds = bounds_of(stand);
    stand->kind->step(stand->self, now_us);
    if (!bounds->moves) {
        return;
    }
    const tumble_stand_state_t state = stand->kind->state(stand->self);
    const int32_t here = here_mdeg(stand);
    tumble_stand_fault_t fault = TUMBLE_STAND_FAULT_NONE;
    if ((state == TUMBLE_STAND_MOVING) || (state == TUMBLE_STAND_HOMING)) {
        fault = judge(bounds, &tumble_stand_report(stand)->motion, here, (uint32_t)(now_us >> TICK), margin_ms);
        bounds->before_mdeg = here;
    } else {
        bounds->moves = false;
        if ((state == TUMBLE_STAND_IN_POSITION) && !is_at_goal(bounds, here)) {
            fault = TUMBLE_STAND_FAULT_STALL;
        }
    }
    if (fault != TUMBLE_STAND_FAULT_NONE) {
        tumble_stand_stop(stand);
        bounds->fault = (uint8_t)fault;
        bounds->lost = true;
    }
}

TUMBLE_ONE_COPY static tumble_status_t begin_motion(const tumble_stand_t *stand, bool homes, double goal_deg)
{
    tumble_motion_bounds_t *bounds = bounds_of(stand);
    if ((bounds->fault != 0U) || (bounds->lost && !homes)) {
        return TUMBLE_E_STAND_STATE;
    }
    const tumble_status_t status = homes ? stand->kind->home(stand->self) : stand->kind->move(stand->self, goal_deg);
    if (status == TUMBLE_OK) {
        const int32_t here = here_mdeg(stand);
        const int32_t goal = tumble_thousandths(goal_deg);
        *bounds = (tumble_motion_bounds_t){
            .lowest_mdeg = INT32_MIN, .highest_mdeg = INT32_MAX, .goal_mdeg = goal, .moves = true, .homes = homes};
        if (!homes) {
            bounds->lowest_mdeg = ((here < goal) ? here : goal) - TUMBLE_OVERSHOOT_MDEG;
            bounds->highest_mdeg = ((here < goal) ? goal : here) + TUMBLE_OVERSHOOT_MDEG;
        }
    }
    return status;
}

tumble_status_t tumble_stand_home(const tumble_stand_t *stand)
{
    return begin_motion(stand, true, 0.0);
}

tumble_status_t tumble_stand_move(const tumble_stand_t *stand, double angle_deg)
{
    return begin_motion(stand, false, angle_deg);
}

TUMBLE_ONE_COPY void tumble_stand_stop(const tumble_stand_t *stand)
{
    bounds_of(stand)->moves = false;
    stand->kind->stop(stand->self);
}

/* Of a motion that was given up: not before the kind has seen the axis at rest. What the kind itself has found wrong
 * is cleared with it. */
TUMBLE_ONE_COPY tumble_status_t tumble_stand_clear_fault(const tumble_stand_t *stand)
{
    tumble_motion_bounds_t *bounds = bounds_of(stand);
    if (bounds->fault == 0U) {
        return stand->kind->clear_fault(stand->self);
    }
    const tumble_stand_state_t state = stand->kind->state(stand->self);
    tumble_status_t status = TUMBLE_OK;
    if (state == TUMBLE_STAND_FAULT) {
        status = stand->kind->clear_fault(stand->self);
    } else if ((state == TUMBLE_STAND_MOVING) || (state == TUMBLE_STAND_HOMING)) {
        status = TUMBLE_E_STAND_STATE;
    } else {
        /* it rests */
    }
    bounds->fault = (uint8_t)((status == TUMBLE_OK) ? 0U : bounds->fault);
    return status;
}

TUMBLE_ONE_COPY tumble_stand_state_t tumble_stand_state(const tumble_stand_t *stand)
{
    const tumble_motion_bounds_t *bounds = bounds_of(stand);
    const tumble_stand_state_t state = stand->kind->state(stand->self);
    if (bounds->fault != 0U) {
        return TUMBLE_STAND_FAULT;
    }
    const bool rests = (state == TUMBLE_STAND_STOPPED) || (state == TUMBLE_STAND_IN_POSITION);
    return (bounds->lost && rests) ? TUMBLE_STAND_READY : state;
}

/* That the axis was not seen to rest matters more than why it was told to. */
TUMBLE_ONE_COPY tumble_stand_fault_t tumble_stand_fault(const tumble_stand_t *stand)
{
    const tumble_stand_fault_t fault = stand->kind->fault(stand->self);
    const uint8_t given_up = bounds_of(stand)->fault;
    return ((given_up != 0U) && (fault != TUMBLE_STAND_FAULT_STOP)) ? (tumble_stand_fault_t)given_up : fault;
}
