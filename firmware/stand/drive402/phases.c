#include "stand/drive402/internal.h"

#include <stddef.h>

void tumble_drive_go(tumble_drive402_t *drive, tumble_drive_phase_t phase)
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

void tumble_drive_fail(tumble_drive402_t *drive, tumble_stand_fault_t fault)
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

void tumble_drive_look(tumble_drive402_t *drive, bool fresh)
{
    uint8_t before = PHASE_COUNT;
    while (before != drive->phase) {
        before = drive->phase;
        if (!is_watched_fault(drive) && (tumble_drive_rows[before].look != NULL)) {
            tumble_drive_rows[before].look(drive, fresh);
        }
        fresh = false;
    }
}

#define ENTER(name) tumble_drive_enter_##name
#define LOOK(name) tumble_drive_look_##name
#define FOR(member) (uint8_t)offsetof(tumble_drive_profile_t, member##_timeout_ms)
#define OR(name) (uint8_t)TUMBLE_STAND_FAULT_##name
#define IS(name) (uint8_t)TUMBLE_STAND_##name

static_assert(sizeof(tumble_drive_profile_t) <= UINT8_MAX, "an offset into the profile is one byte");

/* clang-format off */
const tumble_drive_row_t tumble_drive_rows[PHASE_COUNT] = {
    /*                    enter             look             lasts           or else       to the stand  is watched */
    [PHASE_ABSENT]    = {NULL,             LOOK(absent),    0,              0,            IS(OFFLINE),  0},
    [PHASE_CONFIGURE] = {ENTER(configure), LOOK(configure), 0,              0,            IS(OFFLINE),  0},
    [PHASE_START]     = {NULL,             LOOK(start),     FOR(start),     OR(PROTOCOL), IS(OFFLINE),  0},
    [PHASE_POWER]     = {ENTER(power),     LOOK(power),     FOR(power),     OR(POWER),    IS(OFFLINE),  0},
    [PHASE_IDLE]      = {NULL,             NULL,            0,              0,            IS(STOPPED),  WATCH_POWER},
    [PHASE_VERIFY]    = {ENTER(verify),    LOOK(verify),    FOR(handshake), OR(PROTOCOL), IS(MOVING),   WATCH_POWER},
    [PHASE_HOME_MODE] = {NULL,             LOOK(home_mode), FOR(handshake), OR(PROTOCOL), IS(HOMING),   WATCH_POWER},
    [PHASE_HOMING]    = {ENTER(homing),    LOOK(homing),    FOR(home),      OR(HOMING),   IS(HOMING),   WATCH_POWER},
    [PHASE_MOVE_MODE] = {NULL,             LOOK(move_mode), FOR(handshake), OR(PROTOCOL), IS(HOMING),   WATCH_POWER},
    [PHASE_TARGET]    = {ENTER(target),    LOOK(target),    FOR(handshake), OR(PROTOCOL), IS(MOVING),   WATCH_POWER | WATCH_MOTION},
    [PHASE_SET_POINT] = {ENTER(set_point), LOOK(set_point), FOR(handshake), OR(PROTOCOL), IS(MOVING),   WATCH_POWER | WATCH_MOTION},
    [PHASE_RELEASE]   = {ENTER(release),   LOOK(release),   FOR(handshake), OR(PROTOCOL), IS(MOVING),   WATCH_POWER | WATCH_MOTION},
    [PHASE_MOVING]    = {ENTER(moving),    LOOK(moving),    FOR(move),      OR(TIMEOUT),  IS(MOVING),   WATCH_POWER | WATCH_MOTION},
    [PHASE_STOPPING]  = {ENTER(stopping),  LOOK(stopping),  0,              0,            IS(MOVING),   0},
    [PHASE_STOPPED]   = {NULL,             NULL,            0,              0,            IS(STOPPED),  0},
    [PHASE_FAULT]     = {ENTER(fault),     LOOK(fault),     0,              0,            IS(FAULT),    0},
};
/* clang-format on */
