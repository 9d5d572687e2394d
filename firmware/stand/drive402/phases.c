/* phases.c - the table of phases, at the end: what each does, how long it may last, what it is for the stand; before it,
 * what they do, up to Operation enabled, then homing, moving and stopping.
 */
#include "stand/drive402/internal.h"

#include "core/arith.h"
#include "core/one_copy.h"
#include "stand/bounds.h"

#include <stddef.h>

TUMBLE_ONE_COPY void tumble_drive_go(tumble_drive402_t *drive, tumble_drive_phase_t phase)
{
    drive->phase = (uint8_t)phase;
    drive->restart_timer = true;
    drive->blocked = false;
    drive->settled = false;
    drive->report.motion = (tumble_stand_motion_t){0, 0, 0, 0, 0};
    if (tumble_drive_rows[phase].enter != NULL) {
        tumble_drive_rows[phase].enter(drive);
    }
}

TUMBLE_ONE_COPY void tumble_drive_fail(tumble_drive402_t *drive, tumble_stand_fault_t fault)
{
    drive->fault = (uint8_t)fault;
    drive->homed = drive->homed && (fault != TUMBLE_STAND_FAULT_POWER);
    if ((drive->phase >= (uint8_t)PHASE_POWER) || tumble_drive_may_turn(drive)) {
        tumble_drive_watch_stop(drive); /* before that nothing has been set going */
    }
    tumble_drive_go(drive, PHASE_FAULT);
}

static bool is_watched_fault(tumble_drive402_t *drive)
{
    const tumble_drive_row_t *row = &tumble_drive_rows[drive->phase];
    if (((row->watch & WATCH_POWER) != 0U) && (tumble_drive_power_state(drive) != TUMBLE_402_STATE_OPERATION_ENABLED)) {
        tumble_drive_fail(drive, tumble_drive_is_faulty(drive) ? TUMBLE_STAND_FAULT_DRIVE : TUMBLE_STAND_FAULT_POWER);
        return true;
    }
    if (((row->watch & WATCH_MOTION) != 0U) && tumble_drive_has(drive, TUMBLE_402_STATUS_FOLLOWING_ERROR)) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_STALL);
        return true;
    }
    return false;
}

void tumble_drive_check(tumble_drive402_t *drive, bool fresh)
{
    uint8_t before = PHASE_COUNT;
    drive->fresh = fresh;
    while (before != drive->phase) {
        before = drive->phase;
        if (!is_watched_fault(drive) && (tumble_drive_rows[before].check != NULL)) {
            tumble_drive_rows[before].check(drive);
        }
        drive->fresh = false;
    }
}

/* CONFIGURE and the changes of mode: one SDO after the other. */

static void ask_write(tumble_drive402_t *drive, const tumble_object_write_t *write)
{
    const tumble_status_t status = tumble_sdo_client_write(&drive->node->client, drive->drive_node, write->index,
                                                           write->subindex, write->value, write->size);
    drive->asked = (status == TUMBLE_OK) ? ASKED_WRITE : ASKED_NOTHING;
}

TUMBLE_ONE_COPY static void ask(tumble_drive402_t *drive, uint16_t index, uint8_t subindex)
{
    drive->asked = ASKED_READ;
    (void)tumble_sdo_client_read(&drive->node->client, drive->drive_node, index, subindex);
}

TUMBLE_ONE_COPY void tumble_drive_refused(tumble_drive402_t *drive, uint16_t index, uint8_t subindex, uint32_t abort)
{
    drive->report.refusal = (tumble_stand_refusal_t){index, subindex, drive->phase, abort};
    tumble_drive_fail(drive, TUMBLE_STAND_FAULT_PROTOCOL);
}

/* Is nothing under way any more? A transfer that went wrong is a fault. */
static bool is_answered(tumble_drive402_t *drive)
{
    const tumble_sdo_client_t *client = &drive->node->client;
    const tumble_status_t result = tumble_sdo_client_result(client);
    if (result == TUMBLE_E_SDO_BUSY) {
        return false;
    }
    if ((drive->asked != ASKED_NOTHING) && (result != TUMBLE_OK)) {
        drive->asked = ASKED_NOTHING;
        tumble_drive_refused(drive, client->index, client->subindex, client->abort);
        return false;
    }
    return true;
}

/* A drive that was there before us may send no heartbeat. Ask it to send one by writing its 1017h; from the first one
 * on it is watched. A drive that refuses cannot be watched, and must not move.
 *
 *     us      boot-up   write 1017h   write 1017h                            configure, start
 *               |         |             |                                      |
 *     drive     (off)     x timeout     answer, then heartbeat ... heartbeat --+--> present
 *
 * A timeout means that nobody is there yet: ask again. An answer without a heartbeat is not enough to be present. A
 * profile without a heartbeat's time says that the drive sends one unasked. */
static void check_absent(tumble_drive402_t *drive)
{
    const tumble_sdo_client_t *client = &drive->node->client;
    if ((tumble_sdo_client_result(client) == TUMBLE_E_SDO_BUSY) || (drive->profile->heartbeat_ms == 0U) ||
        (tumble_node_state(drive->node) == TUMBLE_NMT_INITIALISING)) {
        return;
    }
    const bool silent = client->abort == (uint32_t)TUMBLE_ABORT_TIMEOUT;
    if ((drive->asked == ASKED_NOTHING) || ((drive->asked == ASKED_WRITE) && silent)) {
        const tumble_object_write_t write = {TUMBLE_DRIVE_HEARTBEAT, 0, 2, drive->profile->heartbeat_ms};
        ask_write(drive, &write);
    } else if (is_answered(drive)) {
        drive->asked = ASKED_START; /* now it is to be heard */
    } else {
        /* refused */
    }
}

/* Outsiders may have changed our own process data while there was no drive: set them up again. They don't go before the
 * drive has the mapping that they have: it would answer a controlword of another length with an emergency message, or
 * take it for something else. A drive that is Operational may be turning, so it is told to stop by SDO first; whether it
 * takes that is seen at START. A drive that the ladder
 * of a stop has taken out of operation by NMT has no SDO: put it back into Pre-operational first. */
static void enter_configure(tumble_drive402_t *drive)
{
    tumble_nmt_t *nmt = &drive->node->nmt;
    tumble_drive_leave_sdo(drive);
    (void)tumble_drive_map_own(drive); /* as it passed at init */
    if (tumble_nmt_state_of(nmt, drive->drive_node) == TUMBLE_NMT_STOPPED) {
        (void)tumble_nmt_command(nmt, drive->drive_node, TUMBLE_NMT_ENTER_PRE_OPERATIONAL);
    }
    if (tumble_nmt_state_of(nmt, drive->drive_node) == TUMBLE_NMT_OPERATIONAL) {
        tumble_drive_tell_by_sdo(drive); /* it may be turning */
    }
    drive->report.limited = false;
    drive->write = 0;
}

#define HIGHEST 2U /* 607Dh:2, the last one written */

/* What has been asked for at a step of the configuration has been answered. Is there more to it? A drive may take a limit
 * and not keep it, so it is read back; a PDO that is kept must be what our own is the other end of. */
static bool goes_on(tumble_drive402_t *drive, const tumble_object_write_t *step)
{
    const bool limit = (step->index == TUMBLE_402_SOFTWARE_LIMIT);
    if (drive->asked == ASKED_WRITE) {
        if (limit) {
            ask(drive, step->index, step->subindex);
        }
        return limit;
    }
    const uint32_t ignored = limit ? 0U : TUMBLE_PDO_NO_RTR;
    if (((tumble_sdo_client_u32(&drive->node->client) ^ step->value) & ~ignored) != 0U) {
        tumble_drive_refused(drive, step->index, step->subindex, (uint32_t)TUMBLE_ABORT_VALUE);
        return true;
    }
    drive->report.limited = drive->report.limited || (limit && (step->subindex == HIGHEST));
    return false;
}

static void check_configure(tumble_drive402_t *drive)
{
    tumble_object_write_t step = {0, 0, 0, 0};
    if (!is_answered(drive)) {
        return;
    }
    for (; tumble_drive_configuration(drive, drive->write, &step); drive->write++) {
        if (drive->asked != ASKED_NOTHING) {
            if (goes_on(drive, &step)) {
                return;
            }
            drive->asked = ASKED_NOTHING;
        } else if (step.size == TUMBLE_DRIVE_READS) {
            ask(drive, step.index, step.subindex);
            return;
        } else if (step.size != 0U) {
            ask_write(drive, &step);
            return;
        } else {
            /* nothing to do at this step */
        }
    }
    tumble_drive_go(drive, PHASE_START);
    (void)tumble_drive_map_own(drive);
}

/* VERIFY. Somebody else on the bus may have changed what was written at configuration. It is read back before every
 * motion; what differs is written again until the drive keeps it, or the handshake's time is over. A drive may round its
 * quantities; limits it must keep as they are. */

static void enter_verify(tumble_drive402_t *drive)
{
    drive->write = tumble_drive_first_of_motion(drive);
}

static bool keeps(const tumble_sdo_client_t *client, const tumble_object_write_t *wanted)
{
    const uint32_t value = tumble_sdo_client_u32(client);
    const uint32_t off = (value > wanted->value) ? (value - wanted->value) : (wanted->value - value);
    return off <= ((wanted->index == TUMBLE_402_SOFTWARE_LIMIT) ? 0U : (1U + (wanted->value / 64U)));
}

static void check_verify(tumble_drive402_t *drive)
{
    tumble_object_write_t wanted = {0, 0, 0, 0};
    if (!is_answered(drive)) {
        return;
    }
    (void)tumble_drive_configuration(drive, drive->write, &wanted);
    if (drive->asked == ASKED_READ) {
        drive->asked = ASKED_NOTHING;
        if (!keeps(&drive->node->client, &wanted)) {
            drive->report.refusal = (tumble_stand_refusal_t){wanted.index, wanted.subindex,
                                                             (uint8_t)TUMBLE_STAND_STEP_VERIFY, TUMBLE_ABORT_VALUE};
            ask_write(drive, &wanted);
            return;
        }
        drive->write++;
        drive->restart_timer = true; /* of one object */
    }
    while (tumble_drive_configuration(drive, drive->write, &wanted) && (wanted.size == 0U)) {
        drive->write++;
    }
    if (wanted.index >= TUMBLE_DRIVE_PROFILE_OBJECTS) {
        ask(drive, wanted.index, wanted.subindex);
    } else {
        drive->report.refusal = (tumble_stand_refusal_t){0, 0, 0, TUMBLE_ABORT_NONE};
        tumble_drive_go(drive, (tumble_drive_phase_t)drive->wanted);
    }
}

/* Write the mode, then read its display until it shows it. */
static bool shows_mode(tumble_drive402_t *drive, int8_t mode)
{
    if (!is_answered(drive)) {
        return false;
    }
    if (drive->asked == ASKED_NOTHING) {
        const tumble_object_write_t write = {TUMBLE_402_MODE, 0, 1, (uint32_t)mode};
        drive->mirror->mode = mode; /* in case that process data carry it */
        ask_write(drive, &write);
        return false;
    }
    if ((drive->asked == ASKED_READ) && (tumble_sdo_client_u32(&drive->node->client) == (uint32_t)mode)) {
        drive->asked = ASKED_NOTHING;
        return true;
    }
    ask(drive, TUMBLE_402_MODE_DISPLAY, 0);
    return false;
}

/* START and POWER: the ramp of CiA 402. Each statusword asks for the next controlword; the drive may take its time.
 *
 *     statusword (6041h)        controlword (6040h)
 *
 *     any                  <--  0000h  disable voltage, on entering POWER
 *     switch on disabled   -->  0006h  shutdown
 *     ready to switch on   -->  0007h  switch on
 *     switched on          -->  000Fh  enable operation
 *     operation enabled         ready; go on to the phase that is wanted
 *
 *     fault                -->  0080h  fault reset, once and only if it may be reset; then from the top
 *
 * A set-point acts on the rising edge of bit 4, and Halt stays set in the controlword. Beginning at 0000h clears both.
 */

static void control_once(tumble_drive402_t *drive, unsigned word)
{
    if (drive->mirror->controlword != word) {
        tumble_drive_control(drive, word);
    }
}

/* A drive that is under power already may be turning: this computer has restarted, or a cable was loose. POWER begins
 * by switching the voltage off, and the axis would coast. So stop it first. */
static void check_start(tumble_drive402_t *drive)
{
    if (drive->asked != ASKED_START) {
        const bool taken = tumble_nmt_command(&drive->node->nmt, drive->drive_node, TUMBLE_NMT_START) == TUMBLE_OK;
        drive->asked = taken ? ASKED_START : ASKED_NOTHING;
    } else if (drive->fresh) {
        drive->asked = ASKED_NOTHING;
        tumble_drive_go(drive, tumble_drive_may_turn(drive) ? PHASE_STOPPING : PHASE_POWER);
    } else {
        /* its first process data are on their way */
    }
}

/* Begin at the bottom of the ramp while the axis is at rest, so that no old set-point and no old Halt survives. */
static void enter_power(tumble_drive402_t *drive)
{
    tumble_drive_control(drive, TUMBLE_402_CONTROL_DISABLE_VOLTAGE);
}

/* The reset acts on the rising edge of bit 7, which must have been seen low before. */
static void check_power_fault(tumble_drive402_t *drive)
{
    const uint16_t word = drive->mirror->controlword;
    if ((word == TUMBLE_402_CONTROL_DISABLE_VOLTAGE) && drive->may_reset) {
        drive->may_reset = false;
        tumble_drive_control(drive, TUMBLE_402_CONTROL_FAULT_RESET);
    } else if (word != TUMBLE_402_CONTROL_FAULT_RESET) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_DRIVE);
    } else {
        /* the drive is leaving its fault, or the time will tell */
    }
}

static void check_power(tumble_drive402_t *drive)
{
    if (tumble_drive_is_blocked(drive)) {
        return;
    }
    switch (tumble_drive_power_state(drive)) {
    case TUMBLE_402_STATE_SWITCH_ON_DISABLED:
        control_once(drive, TUMBLE_402_CONTROL_SHUTDOWN);
        break;
    case TUMBLE_402_STATE_READY_TO_SWITCH_ON:
        control_once(drive, TUMBLE_402_CONTROL_SWITCH_ON);
        break;
    case TUMBLE_402_STATE_SWITCHED_ON:
        control_once(drive, TUMBLE_402_CONTROL_ENABLE);
        break;
    case TUMBLE_402_STATE_OPERATION_ENABLED:
        if (drive->mirror->controlword == TUMBLE_402_CONTROL_ENABLE) {
            drive->may_reset = false;
            drive->report.fault_code = 0; /* what it told of on its way up is over */
            tumble_drive_go(drive, (drive->wanted == (uint8_t)PHASE_IDLE) ? PHASE_IDLE : PHASE_VERIFY);
        }
        break;
    case TUMBLE_402_STATE_FAULT:
        check_power_fault(drive);
        break;
    default:
        break; /* on its way */
    }
}

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
static void set_motion_bounds(tumble_drive402_t *drive, bool homes, int64_t to_counts)
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

static void check_home_mode(tumble_drive402_t *drive)
{
    const tumble_sdo_client_t *client = &drive->node->client;
    const int8_t method = drive->profile->homing_method;
    const bool spot = (method == ON_THE_SPOT) || (method == ON_THE_SPOT_TOO);
    if ((drive->asked != ASKED_READ) || (client->index != TUMBLE_402_STATUSWORD)) {
        if (shows_mode(drive, TUMBLE_402_MODE_HOMING)) {
            ask(drive, TUMBLE_402_STATUSWORD, 0);
        }
    } else if (is_answered(drive)) {
        const bool clear = (tumble_sdo_client_u32(client) & HOMING_OVER) == 0U;
        drive->asked = ASKED_NOTHING;
        drive->stale = (clear || spot) ? UNHEARD : UNCLEARED;
        tumble_drive_go(drive, PHASE_HOMING);
    } else {
        /* on its way, or refused */
    }
}

static void enter_homing(tumble_drive402_t *drive)
{
    set_motion_bounds(drive, true, (int64_t)drive->homing_counts * drive->profile->sign);
    tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE | TUMBLE_402_CONTROL_START_HOMING);
}

/* Has the drive heard the start? A start that got lost is given again: it has seen no edge yet. */
static void confirm_start(tumble_drive402_t *drive)
{
    if (!is_answered(drive)) {
        return;
    }
    drive->asked = ASKED_NOTHING;
    if ((tumble_sdo_client_u32(&drive->node->client) & TUMBLE_402_CONTROL_START_HOMING) != 0U) {
        drive->stale = STALE_STATUSWORDS;
    } else {
        enter_homing(drive);
    }
}

static void check_attained(tumble_drive402_t *drive)
{
    if (drive->stale == UNCLEARED) {
        return; /* it may be that of the homing before */
    }
    if (drive->stale == UNHEARD) {
        ask(drive, TUMBLE_402_CONTROLWORD, 0);
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

static void check_homing(tumble_drive402_t *drive)
{
    if (tumble_drive_is_blocked(drive)) {
        return;
    }
    if (drive->fresh && !tumble_drive_has(drive, HOMING_OVER)) {
        drive->stale = 0;
        tumble_drive_leave_sdo(drive);
    } else if (drive->asked != ASKED_NOTHING) {
        confirm_start(drive);
    } else if (drive->fresh) {
        check_attained(drive);
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
static void check_move_mode(tumble_drive402_t *drive)
{
    const tumble_sdo_client_t *client = &drive->node->client;
    if (!drive->homed) {
        if (shows_mode(drive, TUMBLE_402_MODE_PROFILE_POSITION)) {
            drive->homed = true;
            drive->tracked = false;   /* a report from before the new zero may be the last one known: ask */
            drive->actual_counts = 0; /* a drive that wraps and stands a count below zero is no circle above it */
            ask(drive, TUMBLE_402_POSITION_ACTUAL, 0);
        }
        return;
    }
    if (!is_answered(drive)) {
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
        ask(drive, TUMBLE_402_HOME_OFFSET, 0);
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
static void enter_target(tumble_drive402_t *drive)
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
static void check_target(tumble_drive402_t *drive)
{
    const bool taken = tumble_drive_has(drive, TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE);
    if (tumble_drive_is_blocked(drive) || (taken && !drive->profile->acknowledges_enabling) || !is_answered(drive)) {
        return;
    }
    if (drive->asked == ASKED_NOTHING) {
        ask(drive, TUMBLE_402_TARGET_POSITION, 0);
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
static void enter_set_point(tumble_drive402_t *drive)
{
    drive->falls = tumble_drive_has(drive, TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE);
    tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE | TUMBLE_402_CONTROL_NEW_SET_POINT);
}

static void check_set_point(tumble_drive402_t *drive)
{
    const bool is_set = tumble_drive_has(drive, TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE);
    if (!tumble_drive_is_blocked(drive) && (is_set != drive->falls)) {
        tumble_drive_go(drive, PHASE_RELEASE);
    }
}

static void enter_release(tumble_drive402_t *drive)
{
    tumble_drive_control(drive, TUMBLE_402_CONTROL_ENABLE);
}

static void check_release(tumble_drive402_t *drive)
{
    if (!tumble_drive_is_blocked(drive) && !tumble_drive_has(drive, TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE)) {
        tumble_drive_go(drive, PHASE_MOVING);
    }
}

static void enter_moving(tumble_drive402_t *drive)
{
    set_motion_bounds(drive, false, drive->set_counts);
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
    if (!drive->placed && is_answered(drive)) {
        if (drive->asked == ASKED_NOTHING) {
            ask(drive, TUMBLE_402_POSITION_ACTUAL, 0);
        } else {
            take_answer(drive);
        }
    }
    return drive->placed;
}

static void check_moving(tumble_drive402_t *drive)
{
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

static void command_stop(tumble_drive402_t *drive)
{
    tumble_drive_control(drive, stops_by_halt(drive) ? (TUMBLE_402_CONTROL_ENABLE | TUMBLE_402_CONTROL_HALT)
                                                     : TUMBLE_402_CONTROL_QUICK_STOP);
}

/* A drive that comes here is powered up: from now on a fault is reset only by command. */
static void enter_stopping(tumble_drive402_t *drive)
{
    tumble_drive_leave_sdo(drive);
    drive->arrived = false;
    drive->may_reset = false;
    tumble_drive_watch_stop(drive);
    command_stop(drive);
    if (stops_by_halt(drive)) {
        tumble_drive_tell_by_sdo(drive); /* a Halt that was not heard does not show */
    }
}

/* Until the drive has begun to stop it is told again at every report: process data are not acknowledged. */
static void check_stopping(tumble_drive402_t *drive)
{
    if (tumble_drive_is_blocked(drive) || !drive->fresh) {
        return;
    }
    const bool rests = tumble_drive_rests(drive);
    if (tumble_drive_is_faulty(drive)) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_DRIVE);
    } else if (rests) {
        tumble_drive_end_stop(drive);
        tumble_drive_go(drive, PHASE_STOPPED);
    } else if (tumble_drive_power_state(drive) == TUMBLE_402_STATE_OPERATION_ENABLED) {
        command_stop(drive);
    } else {
        /* it brakes */
    }
}

/* Whatever the drive is doing, tell it to stop, and again until it begins; a drive that is silent may still hear us. */
static void enter_fault(tumble_drive402_t *drive)
{
    tumble_drive_leave_sdo(drive);
    drive->arrived = false;
    tumble_drive_control(drive, TUMBLE_402_CONTROL_QUICK_STOP);
}

static void check_fault(tumble_drive402_t *drive)
{
    if (!drive->fresh) {
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

/* The table. */

#define ENTER(name) enter_##name
#define CHECK(name) check_##name
#define FOR(member) (uint8_t)offsetof(tumble_drive_profile_t, member##_timeout_ms)
#define OR(name) (uint8_t)TUMBLE_STAND_FAULT_##name
#define IS(name) (uint8_t)TUMBLE_STAND_##name

static_assert(sizeof(tumble_drive_profile_t) <= UINT8_MAX, "an offset into the profile is one byte");
static_assert(((unsigned)PHASE_POWER == (unsigned)TUMBLE_STAND_STEP_POWER) &&
                  ((unsigned)PHASE_HOME_MODE == (unsigned)TUMBLE_STAND_STEP_HOMING_MODE) &&
                  ((unsigned)PHASE_MOVING == (unsigned)TUMBLE_STAND_STEP_MOTION),
              "a refusal tells the phase by its number");

/* clang-format off */
const tumble_drive_row_t tumble_drive_rows[PHASE_COUNT] = {
    /*                    enter             check            lasts           or else       to the stand  is watched */
    [PHASE_ABSENT]    = {NULL,             CHECK(absent),    0,              0,            IS(OFFLINE),  0},
    [PHASE_CONFIGURE] = {ENTER(configure), CHECK(configure), 0,              0,            IS(OFFLINE),  0},
    [PHASE_START]     = {NULL,             CHECK(start),     FOR(start),     OR(PROTOCOL), IS(OFFLINE),  0},
    [PHASE_POWER]     = {ENTER(power),     CHECK(power),     FOR(power),     OR(POWER),    IS(OFFLINE),  0},
    [PHASE_IDLE]      = {NULL,             NULL,            0,              0,            IS(STOPPED),  WATCH_POWER},
    [PHASE_VERIFY]    = {ENTER(verify),    CHECK(verify),    FOR(handshake), OR(PROTOCOL), IS(MOVING),   WATCH_POWER},
    [PHASE_HOME_MODE] = {NULL,             CHECK(home_mode), FOR(handshake), OR(PROTOCOL), IS(HOMING),   WATCH_POWER},
    [PHASE_HOMING]    = {ENTER(homing),    CHECK(homing),    FOR(home),      OR(HOMING),   IS(HOMING),   WATCH_POWER},
    [PHASE_MOVE_MODE] = {NULL,             CHECK(move_mode), FOR(handshake), OR(PROTOCOL), IS(HOMING),   WATCH_POWER},
    [PHASE_TARGET]    = {ENTER(target),    CHECK(target),    FOR(handshake), OR(PROTOCOL), IS(MOVING),   WATCH_POWER | WATCH_MOTION},
    [PHASE_SET_POINT] = {ENTER(set_point), CHECK(set_point), FOR(handshake), OR(PROTOCOL), IS(MOVING),   WATCH_POWER | WATCH_MOTION},
    [PHASE_RELEASE]   = {ENTER(release),   CHECK(release),   FOR(handshake), OR(PROTOCOL), IS(MOVING),   WATCH_POWER | WATCH_MOTION},
    [PHASE_MOVING]    = {ENTER(moving),    CHECK(moving),    FOR(move),      OR(TIMEOUT),  IS(MOVING),   WATCH_POWER | WATCH_MOTION},
    [PHASE_STOPPING]  = {ENTER(stopping),  CHECK(stopping),  0,              0,            IS(MOVING),   0},
    [PHASE_STOPPED]   = {NULL,             NULL,            0,              0,            IS(STOPPED),  0},
    [PHASE_FAULT]     = {ENTER(fault),     CHECK(fault),     0,              0,            IS(FAULT),    0},
};
/* clang-format on */
