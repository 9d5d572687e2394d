#include "stand/bounds.h"

#include "core/arith.h"
#include "core/one_copy.h"

#define MS_PER_S 1000U
/* What calls the kind stays one function, so that firmware/calls.csv can name it. */

#define LEAST_CHANGE_MDEG 5U /* less is no progress */
#define LOOKS 4U             /* in a row that must agree: reports of a busy machine come at random */
#define LEAST_LOOK_MS 64U
#define UNKNOWN_RAMP_MS 1000U
#define MDEG_PER_DEG 1000U
#define MOST_S 1000000U
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

/* Has the axis a steady speed that it was not told? The first look of those that agree is what the others are compared
 * with: a gentle ramp would pass from one to the next. Where the ramp is not known, a slower speed may be its. */
static bool is_out_of_pace(tumble_motion_bounds_t *bounds, const tumble_stand_motion_t *motion, uint32_t speed)
{
    const bool both_too_fast =
        ((speed / 2U) > motion->speed_mdeg_s) && ((bounds->speed_mdeg_s / 2U) > motion->speed_mdeg_s);
    const uint32_t slow = bounds->homes ? motion->slow_mdeg_s : motion->speed_mdeg_s;
    if (both_too_fast || (distance((int32_t)speed, (int32_t)bounds->speed_mdeg_s) <= (bounds->speed_mdeg_s / 16U))) {
        bounds->looks = (uint8_t)(bounds->looks + (both_too_fast ? 2U : 1U));
    } else {
        bounds->looks = 1;
        bounds->speed_mdeg_s = speed;
    }
    const bool ramps = (motion->ramp_ms == 0U) && (speed < motion->speed_mdeg_s);
    return (bounds->looks >= LOOKS) && !ramps && (speed > (slow / 16U)) && (slow != 0U) && !is_about(speed, slow) &&
           !is_about(speed, motion->speed_mdeg_s);
}

/* Milliseconds for a way, at most some twelve days. */
static uint32_t duration_ms(uint32_t way_mdeg, uint32_t speed_mdeg_s)
{
    if (speed_mdeg_s >= MDEG_PER_DEG) {
        return (way_mdeg * 8U) / (speed_mdeg_s / 125U); /* ways are shorter than 2^29 mdeg */
    }
    const uint32_t s = (speed_mdeg_s != 0U) ? (way_mdeg / speed_mdeg_s) : MOST_S;
    return ((s < MOST_S) ? s : MOST_S) * MS_PER_S;
}

/* The motion is set going: from now on its time counts. */
static void begin_time(tumble_motion_bounds_t *bounds, const tumble_stand_motion_t *motion, int32_t here, uint32_t now)
{
    const uint32_t way = bounds->homes ? (uint32_t)motion->to_mdeg : distance(motion->to_mdeg, here);
    const uint32_t ramp_ms = (motion->ramp_ms != 0U) ? motion->ramp_ms : UNKNOWN_RAMP_MS;
    const uint32_t ms = duration_ms(way, motion->speed_mdeg_s) + ramp_ms;
    bounds->set_out = true;
    bounds->due = now + (ms - (ms / MS_PER_LOST_TICK));
    bounds->looked = now;
    bounds->looks = 0;
    bounds->from_mdeg = here;
    bounds->progress_mdeg = here;
    bounds->progressed = now;
}

/* Reports that no longer change, but for a flicker, for longer than the slowest motion needs to leave it. At its end, also
 * of one leg of several, an axis may rest; in homing it may for a while, such as where it turns back. */
static bool stalls(tumble_motion_bounds_t *bounds, const tumble_stand_motion_t *motion, int32_t here, uint32_t now,
                   uint32_t margin_ms)
{
    const uint32_t least = (motion->count_mdeg > LEAST_CHANGE_MDEG) ? motion->count_mdeg : LEAST_CHANGE_MDEG;
    const uint32_t slowest = (motion->slow_mdeg_s != 0U) ? motion->slow_mdeg_s : motion->speed_mdeg_s;
    const uint32_t leaves_ms = (slowest != 0U) ? duration_ms(2U * least, slowest) : 0U;
    if (distance(here, bounds->progress_mdeg) > least) {
        bounds->progress_mdeg = here;
        bounds->progressed = now;
    }
    const bool rests = !bounds->homes && (distance(here, motion->to_mdeg) <= (uint32_t)TUMBLE_OVERSHOOT_MDEG);
    return !rests && ((now - bounds->progressed) > ((bounds->homes ? margin_ms : (margin_ms / 2U)) + leaves_ms));
}

/* The next look at the speed, if it is time for one and a report shows that the axis has gone on. */
static bool is_at_another_speed(tumble_motion_bounds_t *bounds, const tumble_stand_motion_t *motion, int32_t here,
                                uint32_t now)
{
    const uint32_t passed = now - bounds->looked;
    const uint32_t change = distance(here, bounds->from_mdeg);
    if ((motion->speed_mdeg_s == 0U) || (bounds->progressed != now) || (passed < LEAST_LOOK_MS) ||
        (passed < (motion->ramp_ms / 4U))) {
        return false;
    }
    bounds->looked = now;
    bounds->from_mdeg = here;
    const uint32_t speed = (change < (UINT32_MAX / MS_PER_S)) ? ((change * MS_PER_S) / passed) : UINT32_MAX;
    return is_out_of_pace(bounds, motion, speed);
}

static tumble_stand_fault_t judge(tumble_motion_bounds_t *bounds, const tumble_stand_motion_t *motion, int32_t here,
                                  uint32_t now, uint32_t margin_ms)
{
    if ((here < bounds->lowest_mdeg) || (here > bounds->highest_mdeg)) {
        return TUMBLE_STAND_FAULT_RUNAWAY;
    }
    if (motion->count_mdeg == 0U) { /* it has not set out */
        bounds->set_out = false;
        return TUMBLE_STAND_FAULT_NONE;
    }
    if (!bounds->set_out) {
        begin_time(bounds, motion, here, now);
    }
    const uint32_t late = now - bounds->due;
    if ((late <= (uint32_t)INT32_MAX) && (late > margin_ms)) {
        return bounds->homes ? TUMBLE_STAND_FAULT_HOMING : TUMBLE_STAND_FAULT_TIMEOUT;
    }
    if (stalls(bounds, motion, here, now, margin_ms)) {
        return TUMBLE_STAND_FAULT_STALL;
    }
    return is_at_another_speed(bounds, motion, here, now) ? TUMBLE_STAND_FAULT_SCALE : TUMBLE_STAND_FAULT_NONE;
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
    } else {
        bounds->moves = false;
        const bool arrived = (state == TUMBLE_STAND_IN_POSITION);
        bounds->lost = bounds->lost && !(arrived && bounds->homes);
        if (arrived && bounds->set_out && !is_at_goal(bounds, here)) {
            fault = TUMBLE_STAND_FAULT_STALL;
        }
    }
    if (fault != TUMBLE_STAND_FAULT_NONE) {
        tumble_stand_stop(stand);
        bounds->fault = (uint8_t)fault;
        bounds->lost = true;
    }
}

/* A homing that has come to its end has found the position again, also before the next step. */
static bool has_homed(const tumble_motion_bounds_t *bounds, tumble_stand_state_t state)
{
    return bounds->homes && bounds->moves && (state == TUMBLE_STAND_IN_POSITION);
}

void tumble_stand_lose_position(const tumble_stand_t *stand)
{
    bounds_of(stand)->lost = true;
}

TUMBLE_ONE_COPY static tumble_status_t begin_motion(const tumble_stand_t *stand, bool homes, double goal_deg)
{
    tumble_motion_bounds_t *bounds = bounds_of(stand);
    if ((bounds->fault != 0U) || (!homes && bounds->lost && !has_homed(bounds, stand->kind->state(stand->self)))) {
        return TUMBLE_E_STAND_STATE;
    }
    const tumble_status_t status = homes ? stand->kind->home(stand->self) : stand->kind->move(stand->self, goal_deg);
    if (status == TUMBLE_OK) {
        const int32_t here = here_mdeg(stand);
        const int32_t goal = tumble_thousandths(goal_deg);
        *bounds = (tumble_motion_bounds_t){
            .lowest_mdeg = INT32_MIN, .highest_mdeg = INT32_MAX, .goal_mdeg = goal, .moves = true, .homes = homes};
        bounds->lost = homes; /* until it is at home */
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
    return (bounds->lost && rests && !has_homed(bounds, state)) ? TUMBLE_STAND_READY : state;
}

/* That the axis was not seen to rest matters more than why it was told to. */
TUMBLE_ONE_COPY tumble_stand_fault_t tumble_stand_fault(const tumble_stand_t *stand)
{
    const tumble_stand_fault_t fault = stand->kind->fault(stand->self);
    const uint8_t given_up = bounds_of(stand)->fault;
    return ((given_up != 0U) && (fault != TUMBLE_STAND_FAULT_STOP)) ? (tumble_stand_fault_t)given_up : fault;
}
