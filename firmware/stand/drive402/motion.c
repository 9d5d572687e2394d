#include "core/arith.h"
#include "core/one_copy.h"
#include "stand/bounds.h"
#include "stand/drive402/internal.h"

/* Homing. Bit 12 set after the start may still be that of an earlier homing. There are three ways to tell:
 *
 *     bit 12 before the start    after it
 *     set                        it must be seen clear first
 *     clear (by SDO, in the      it is new if the drive has heard the start, which 6040h tells, and two statuswords
 *     mode of homing)            later it is still set: a table at its mark is home at once, and bit 12 is never
 *                                seen clear
 *     set, methods 35 and 37     likewise: home is where the axis stands
 *
 * Otherwise a start that got lost would pass for a homing that never took place. */
#define STALE_STATUSWORDS 2U
#define UNHEARD 254U /* of `stale`: 6040h has yet to show the start; */
#define UNCLEARED UINT8_MAX
#define ON_THE_SPOT 35 /* and 37 */
#define ON_THE_SPOT_TOO 37
#define HOMING_OVER (TUMBLE_402_STATUS_HOMING_ATTAINED | TUMBLE_402_STATUS_HOMING_ERROR)

#define TURN_DEG 360.0
#define PAST_MARK 5U /* degrees: an axis may brake past its mark by so much, and stay there */

static uint16_t sixteen_bits(double quantity)
{
    const int32_t thousandths = tumble_thousandths(quantity);
    return (thousandths < (int32_t)UINT16_MAX) ? (uint16_t)(thousandths + 1) : UINT16_MAX;
}

/* What bounds the motion that begins. */
static void tell_motion(tumble_drive402_t *drive, bool homes, int64_t to_counts)
{
    const tumble_drive_profile_t *profile = drive->profile;
    const double speed_deg_s = homes ? profile->homing_fast_deg_s : profile->velocity_deg_s;
    const double brake_deg_s2 = homes ? 0.0 : profile->deceleration_deg_s2; /* 0: as it starts */
    double ramp_deg_s2 = homes ? profile->homing_acceleration_deg_s2 : profile->acceleration_deg_s2;
    if (tumble_is_positive(brake_deg_s2) && tumble_exceeds(ramp_deg_s2, brake_deg_s2)) {
        ramp_deg_s2 = brake_deg_s2;
    }
    drive->report.motion = (tumble_stand_motion_t){
        .speed_mdeg_s = (uint32_t)tumble_thousandths(speed_deg_s),
        .slow_mdeg_s = homes ? (uint32_t)tumble_thousandths(profile->homing_slow_deg_s) : 0U,
        .ramp_ms = tumble_is_positive(ramp_deg_s2) ? sixteen_bits(speed_deg_s / ramp_deg_s2) : 0U,
        .count_mdeg = sixteen_bits(TURN_DEG / profile->counts_per_revolution),
        .to_mdeg = tumble_thousandths(tumble_drive_angle_deg(profile, to_counts)),
    };
}

void tumble_drive_look_home_mode(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    const tumble_sdo_client_t *client = &drive->node->client;
    const int8_t method = drive->profile->homing_method;
    const bool spot = (method == ON_THE_SPOT) || (method == ON_THE_SPOT_TOO);
    if ((drive->asked != ASKED_READ) || (client->index != TUMBLE_402_STATUSWORD)) {
        if (tumble_drive_shows_mode(drive, TUMBLE_402_MODE_HOMING)) {
            tumble_drive_ask(drive, TUMBLE_402_STATUSWORD, 0);
        }
    } else if (tumble_drive_is_answered(drive)) {
        const bool clear = (tumble_sdo_client_u32(client) & HOMING_OVER) == 0U;
        drive->asked = ASKED_NOTHING;
        drive->stale = (clear || spot) ? UNHEARD : UNCLEARED;
        tumble_drive_go(drive, PHASE_HOMING);
    } else {
        /* on its way, or refused */
    }
}

void tumble_drive_enter_homing(tumble_drive402_t *drive)
{
    tell_motion(drive, true, (int64_t)drive->homing_counts * drive->profile->sign);
    tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE | TUMBLE_402_CONTROL_START_HOMING);
}

/* Has the drive heard the start? A start that got lost is given again: it has seen no edge yet. */
static void confirm_start(tumble_drive402_t *drive)
{
    if (!tumble_drive_is_answered(drive)) {
        return;
    }
    drive->asked = ASKED_NOTHING;
    if ((tumble_sdo_client_u32(&drive->node->client) & TUMBLE_402_CONTROL_START_HOMING) != 0U) {
        drive->stale = STALE_STATUSWORDS;
    } else {
        tumble_drive_enter_homing(drive);
    }
}

static void look_attained(tumble_drive402_t *drive)
{
    if (drive->stale == UNCLEARED) {
        return; /* it may be that of the homing before */
    }
    if (drive->stale == UNHEARD) {
        tumble_drive_ask(drive, TUMBLE_402_CONTROLWORD, 0);
    } else if (drive->stale > 0U) {
        drive->stale--;
    } else if (tumble_drive_has(drive, TUMBLE_402_STATUS_HOMING_ERROR)) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_HOMING);
    } else if (tumble_drive_has(drive, TUMBLE_402_STATUS_TARGET_REACHED)) {
        tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE);
        tumble_drive_go(drive, PHASE_MOVE_MODE);
    } else {
        /* attained, not yet at rest */
    }
}

void tumble_drive_look_homing(tumble_drive402_t *drive, bool fresh)
{
    if (tumble_drive_is_blocked(drive)) {
        return;
    }
    if (fresh && !tumble_drive_has(drive, HOMING_OVER)) {
        drive->stale = 0;
        tumble_drive_leave_sdo(drive);
    } else if (drive->asked != ASKED_NOTHING) {
        confirm_start(drive);
    } else if (fresh) {
        look_attained(drive);
    } else {
        /* nothing new */
    }
}

/* 6064h, which was asked for by SDO. */
TUMBLE_ONE_COPY static void take_answer(tumble_drive402_t *drive)
{
    drive->asked = ASKED_NOTHING;
    drive->mirror->actual_position = (int32_t)tumble_sdo_client_u32(&drive->node->client);
    tumble_drive_take_position(drive);
}

static uint32_t size_of(int64_t counts)
{
    return (uint32_t)((counts < 0) ? -counts : counts);
}

/* Is the axis where homing ends: at the mark's position, which is 0 or the home offset? Drives differ in the sign of the
 * offset. */
static bool is_home(const tumble_drive402_t *drive, int32_t offset)
{
    const uint32_t home = size_of(tumble_drive_unwrapped(drive->profile, offset, 0));
    const uint32_t here = size_of(drive->actual_counts);
    const uint32_t most = (uint32_t)PAST_MARK * drive->rest_counts;
    return ((here > home) ? (here - home) : (home - here)) <= most;
}

/* Reports may be as frozen as they were on the way, and a drive that wraps would turn to its next target the wrong way
 * round. So a position that is not near 0 must be the home offset of the drive. */
void tumble_drive_look_move_mode(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    const tumble_sdo_client_t *client = &drive->node->client;
    if (!drive->homed) {
        if (tumble_drive_shows_mode(drive, TUMBLE_402_MODE_PROFILE_POSITION)) {
            drive->homed = true;
            drive->tracked = false;   /* a report from before the new zero may be the last one known: ask */
            drive->actual_counts = 0; /* a drive that wraps and stands a count below zero is no circle above it */
            tumble_drive_ask(drive, TUMBLE_402_POSITION_ACTUAL, 0);
        }
        return;
    }
    if (!tumble_drive_is_answered(drive)) {
        return; /* the answer is on its way */
    }
    const bool is_offset = (client->index == TUMBLE_402_HOME_OFFSET);
    if (!is_offset) {
        take_answer(drive);
    }
    if (drive->phase != (uint8_t)PHASE_MOVE_MODE) {
        /* it has turned too far */
    } else if (is_home(drive, is_offset ? (int32_t)tumble_sdo_client_u32(client) : 0)) {
        drive->asked = ASKED_NOTHING;
        drive->arrived = true;
        drive->at_goal = false;
        tumble_drive_go(drive, PHASE_IDLE);
    } else if (is_offset) {
        drive->homed = false;
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_HOMING);
    } else {
        tumble_drive_ask(drive, TUMBLE_402_HOME_OFFSET, 0);
    }
}

/* Moving. The drive takes a target at the rising edge of bit 4 and acknowledges it by bit 12:
 *
 *     phase       TARGET               | SET_POINT  | RELEASE  | MOVING           | IDLE
 *     607Ah       old > new; read back = new                                             we send
 *     bit 4       _____________________/~~~~~~~~~~~~\__________________________________  new set-point
 *     bit 12      ________________________________/~~~~~~~~~~\_________________________  acknowledged
 *     bit 10      ~~~~~~~~~~~~~~~~~~~~~~~????????????????????\__________________/~~~~~~  target reached
 *
 * There is one critical moment. Until bit 12 has fallen again, bit 10 may still belong to the target before: reading it
 * earlier would report a table in position that has not begun to turn. So MOVING, where bit 10 counts, comes last.
 */

/* A drive whose counts wrap takes the shorter way round. Ask for a quarter of its circle at a time, so that the shorter
 * way is always the one that the cable allows. */
void tumble_drive_enter_target(tumble_drive402_t *drive)
{
    const int64_t quarter = (int64_t)(drive->profile->wrap_counts / 4U);
    const int64_t way = drive->goal_counts - drive->actual_counts;
    drive->set_counts = drive->goal_counts;
    if ((quarter != 0) && (way > quarter)) {
        drive->set_counts = drive->actual_counts + quarter;
    } else if ((quarter != 0) && (way < -quarter)) {
        drive->set_counts = drive->actual_counts - quarter;
    } else {
        /* in one go */
    }
    drive->mirror->target_position = tumble_drive_wrapped(drive->profile, drive->set_counts);
    tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE);
}

/* Process data are not acknowledged. A drive that has missed the target would turn to an old one at the edge of bit 4.
 * So the target is read back by SDO, and sent again until the drive holds it. */
void tumble_drive_look_target(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    const bool taken = tumble_drive_has(drive, TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE);
    if (tumble_drive_is_blocked(drive) || (taken && !drive->profile->acknowledges_enabling) ||
        !tumble_drive_is_answered(drive)) {
        return;
    }
    if (drive->asked == ASKED_NOTHING) {
        tumble_drive_ask(drive, TUMBLE_402_TARGET_POSITION, 0);
        return;
    }
    drive->asked = ASKED_NOTHING;
    if (tumble_sdo_client_u32(&drive->node->client) == (uint32_t)drive->mirror->target_position) {
        tumble_drive_go(drive, PHASE_SET_POINT);
    } else {
        tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE);
        drive->blocked = true;
    }
}

/* Bit 12 that has been set since the drive was enabled acknowledges its first set-point by falling. */
void tumble_drive_enter_set_point(tumble_drive402_t *drive)
{
    drive->falls = tumble_drive_has(drive, TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE);
    tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE | TUMBLE_402_CONTROL_NEW_SET_POINT);
}

void tumble_drive_look_set_point(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    const bool is_set = tumble_drive_has(drive, TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE);
    if (!tumble_drive_is_blocked(drive) && (is_set != drive->falls)) {
        tumble_drive_go(drive, PHASE_RELEASE);
    }
}

void tumble_drive_enter_release(tumble_drive402_t *drive)
{
    tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE);
}

void tumble_drive_look_release(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    if (!tumble_drive_is_blocked(drive) && !tumble_drive_has(drive, TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE)) {
        tumble_drive_go(drive, PHASE_MOVING);
    }
}

void tumble_drive_enter_moving(tumble_drive402_t *drive)
{
    tell_motion(drive, false, drive->set_counts);
}

static bool is_near(const tumble_drive402_t *drive)
{
    const int64_t off = drive->actual_counts - drive->set_counts;
    const int64_t window = (int64_t)drive->profile->window_counts;
    return (window == 0) || ((off <= window) && (off >= -window));
}

/* Target reached tells of an angle that may not have been reported yet: where statusword and position travel apart, the
 * last report may be from the way. A drive that reports on change alone will not report again, so it is asked at once.
 * Whichever comes first counts. */
static bool is_placed(tumble_drive402_t *drive)
{
    if (!drive->placed && tumble_drive_is_answered(drive)) {
        if (drive->asked == ASKED_NOTHING) {
            tumble_drive_ask(drive, TUMBLE_402_POSITION_ACTUAL, 0);
        } else {
            take_answer(drive);
        }
    }
    return drive->placed;
}

void tumble_drive_look_moving(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    if (!tumble_drive_has(drive, TUMBLE_402_STATUS_TARGET_REACHED) || !is_placed(drive) || !is_near(drive)) {
        return;
    }
    tumble_drive_leave_sdo(drive);
    if (drive->set_counts != drive->goal_counts) {
        tumble_drive_go(drive, PHASE_TARGET);
        return;
    }
    drive->arrived = true;
    drive->at_goal = true;
    tumble_drive_go(drive, PHASE_IDLE);
}

/* Stopping. */

static bool stops_by_halt(const tumble_drive402_t *drive)
{
    return drive->profile->stop == (uint8_t)TUMBLE_STOP_BY_HALT;
}

static void tell_to_stop(tumble_drive402_t *drive)
{
    tumble_drive_control(drive, stops_by_halt(drive) ? (TUMBLE_402_CONTROL_ENABLE | TUMBLE_402_CONTROL_HALT)
                                                     : TUMBLE_402_CONTROL_QUICK_STOP);
}

/* A drive that comes here is powered up: from now on a fault is reset only by command. */
void tumble_drive_enter_stopping(tumble_drive402_t *drive)
{
    tumble_drive_leave_sdo(drive);
    drive->arrived = false;
    drive->may_reset = false;
    tumble_drive_watch_stop(drive);
    tell_to_stop(drive);
    if (stops_by_halt(drive)) {
        tumble_drive_tell_by_sdo(drive); /* a Halt that was not heard does not show */
    }
}

/* Until the drive has begun to stop it is told again at every report: process data are not acknowledged. */
void tumble_drive_look_stopping(tumble_drive402_t *drive, bool fresh)
{
    if (tumble_drive_is_blocked(drive) || !fresh) {
        return;
    }
    const bool rests = tumble_drive_rests(drive);
    if (tumble_drive_is_faulty(drive)) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_DRIVE);
    } else if (rests) {
        tumble_drive_end_stop(drive);
        tumble_drive_go(drive, PHASE_STOPPED);
    } else if (tumble_drive_power_state(drive) == TUMBLE_402_STATE_OPERATION_ENABLED) {
        tell_to_stop(drive);
    } else {
        /* it brakes */
    }
}

/* Whatever the drive is doing, tell it to stop, and again until it begins; a drive that is silent may still hear us. */
void tumble_drive_enter_fault(tumble_drive402_t *drive)
{
    tumble_drive_leave_sdo(drive);
    drive->arrived = false;
    tumble_drive_control(drive, TUMBLE_402_CONTROL_QUICK_STOP);
}

void tumble_drive_look_fault(tumble_drive402_t *drive, bool fresh)
{
    if (!fresh) {
        return;
    }
    const bool rests = tumble_drive_rests(drive);
    if (tumble_drive_power_state(drive) == TUMBLE_402_STATE_OPERATION_ENABLED) {
        if (drive->rung == (uint8_t)TUMBLE_RUNG_NONE) {
            tumble_drive_watch_stop(drive);
        }
        tumble_drive_control(drive, TUMBLE_402_CONTROL_QUICK_STOP);
    } else if (tumble_drive_is_stopping(drive) && rests) {
        tumble_drive_end_stop(drive);
    } else {
        /* it brakes, or has come to rest */
    }
}
