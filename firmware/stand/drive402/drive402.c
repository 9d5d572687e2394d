#include "stand/drive402/internal.h"

#include "core/arith.h"
#include "core/one_copy.h"
#include "stand/drive402/profile_fields.h"

#include <stddef.h>
#include <string.h>

#define US_PER_MS 1000U
#define MAX_NODE 127U
#define TURN_DEG 360.0
#define TIMED_MS 400U       /* a longer timer is none: the axis would be out of sight between two reports */
#define UNKNOWN_DEG_S 360.0 /* of a drive whose velocity is left as it is */
#define REST_DEG 1.0        /* an axis at rest may stray so far: hands at the block, a brake that takes over */

static bool reports_by_timer(const tumble_drive_profile_t *profile)
{
    bool timed = true;
    for (uint8_t i = 0; i < profile->transmit_count; i++) {
        const uint16_t event_ms = profile->transmit[i].setup.event_ms;
        timed = timed && (event_ms != 0U) && (event_ms <= TIMED_MS);
    }
    return timed;
}

/* The cable's limits, as counts of homing and of the drive's own limits. */
static void bound(tumble_drive402_t *drive, double min_deg, double max_deg)
{
    const tumble_drive_profile_t *profile = drive->profile;
    const bool turned = (profile->sign < 0);
    int64_t at_min;
    int64_t at_max;
    drive->homing_counts =
        tumble_drive_way(profile, tumble_is_positive(profile->homing_travel_deg) ? profile->homing_travel_deg
                                                                                 : ((max_deg - min_deg) + TURN_DEG));
    if (profile->software_limits && (profile->wrap_counts == 0U) && tumble_drive_counts(profile, min_deg, &at_min) &&
        tumble_drive_counts(profile, max_deg, &at_max)) {
        drive->low_counts = (int32_t)(turned ? at_max : at_min);
        drive->high_counts = (int32_t)(turned ? at_min : at_max);
    }
}

static tumble_status_t drive_init(void *self, const tumble_stand_setup_t *setup)
{
    tumble_drive402_t *drive = self;
    const tumble_drive_profile_t *profile = setup->profile;
    if ((setup->stand_node == 0U) || (setup->stand_node > MAX_NODE) ||
        (tumble_drive402_validate(profile, setup->node->config->node) != TUMBLE_OK)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_stop_counters_t counted;
    counted = drive->report.stop; /* they outlast an NMT reset */
    *drive = (tumble_drive402_t){
        .profile = profile,
        .node = setup->node,
        .mirror = setup->mirror,
        .drive_node = setup->stand_node,
        .wanted = (uint8_t)PHASE_IDLE,
        .counts_per_s = tumble_drive_way(/* of one second */
                                         profile, tumble_is_positive(profile->velocity_deg_s) ? profile->velocity_deg_s
                                                                                              : UNKNOWN_DEG_S),
        .rest_counts = tumble_drive_way(profile, REST_DEG),
        .timed = reports_by_timer(profile),
    };
    drive->report.stop = counted;
    *setup->mirror =
        (tumble_drive_mirror_t){.controlword = TUMBLE_402_CONTROL_QUICK_STOP, .mode = TUMBLE_402_MODE_PROFILE_POSITION};
    bound(drive, setup->cable_min_deg, setup->cable_max_deg);
    return tumble_drive_map_own(drive) ? TUMBLE_OK : TUMBLE_E_ARGUMENT;
}

/* What the node tells. */

static void configure(tumble_drive402_t *drive)
{
    drive->wanted = (uint8_t)PHASE_IDLE;
    tumble_drive_go(drive, PHASE_CONFIGURE);
}

/* What it had been told is gone with its power, and so is its position. */
static void booted(tumble_drive402_t *drive)
{
    drive->present = true;
    drive->homed = false;
    if (drive->phase <= (uint8_t)PHASE_START) {
        configure(drive);
    } else if (drive->phase != (uint8_t)PHASE_FAULT) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_POWER);
    } else {
        /* clear_fault will configure it */
    }
    tumble_drive_end_stop(drive); /* it let go of the axis when it lost its power */
}

static void lost(tumble_drive402_t *drive)
{
    drive->present = false;
    if ((drive->phase != (uint8_t)PHASE_ABSENT) && (drive->phase != (uint8_t)PHASE_FAULT)) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_HEARTBEAT);
    }
}

static void drive_heartbeat(void *self, tumble_heartbeat_event_t event, tumble_nmt_state_t state)
{
    tumble_drive402_t *drive = self;
    if ((event != TUMBLE_HEARTBEAT_LOST) && (state != TUMBLE_NMT_OPERATIONAL)) {
        drive->homed = false; /* it may have booted, and the message been lost */
    }
    const bool leads = (drive->phase >= (uint8_t)PHASE_POWER) && (drive->phase != (uint8_t)PHASE_FAULT);
    if (event == TUMBLE_HEARTBEAT_BOOTED) {
        booted(drive);
    } else if (event == TUMBLE_HEARTBEAT_LOST) {
        lost(drive);
    } else if (event == TUMBLE_HEARTBEAT_BEGAN) {
        drive->present = true;
        if (drive->phase == (uint8_t)PHASE_ABSENT) {
            configure(drive);
        } else if (drive->phase == (uint8_t)PHASE_FAULT) {
            tumble_drive_control(drive, TUMBLE_402_CONTROL_QUICK_STOP); /* it may not have heard the first */
        } else {
            /* it was not missed */
        }
    } else if ((event == TUMBLE_HEARTBEAT_CHANGED) && leads && (state != TUMBLE_NMT_OPERATIONAL)) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_PROTOCOL); /* somebody else has taken it out of operation */
    } else {
        /* nothing that matters here */
    }
}

static void drive_emergency(void *self, const tumble_emergency_t *message)
{
    tumble_drive402_t *drive = self;
    if ((message->code != TUMBLE_EMCY_NO_ERROR) || (drive->phase != (uint8_t)PHASE_FAULT)) {
        drive->report.fault_code = message->code; /* an error that is over is none of a later fault */
    }
}

static void drive_pdo_received(void *self, uint8_t number)
{
    tumble_drive402_t *drive = self;
    if (number >= drive->profile->transmit_count) {
        return;
    }
    const tumble_drive_pdo_t *pdo = &drive->profile->transmit[number];
    if (tumble_drive_carries(pdo, TUMBLE_DRIVE_POSITION)) {
        tumble_drive_take_position(drive);
    } else {
        drive->placed = drive->placed && (drive->phase == (uint8_t)PHASE_MOVING) &&
                        tumble_drive_has(drive, TUMBLE_402_STATUS_TARGET_REACHED);
    }
    tumble_drive_check(drive, tumble_drive_carries(pdo, TUMBLE_DRIVE_STATUS));
}

/* Time. */

static uint32_t timeout_ms(const tumble_drive402_t *drive)
{
    uint32_t ms;
    (void)memcpy(&ms, (const unsigned char *)drive->profile + tumble_drive_rows[drive->phase].timeout, sizeof ms);
    return ms;
}

static uint64_t deadline_us(const tumble_drive402_t *drive)
{
    const bool limited = (tumble_drive_rows[drive->phase].timeout != 0U);
    return limited ? (drive->entered_us + ((uint64_t)timeout_ms(drive) * US_PER_MS)) : TUMBLE_NEVER;
}

/* A drive that stays in its fault is no lack of power. */
static void end_late(tumble_drive402_t *drive)
{
    const bool faulty = (drive->phase == (uint8_t)PHASE_POWER) && tumble_drive_is_faulty(drive);
    const uint8_t late = tumble_drive_rows[drive->phase].late;
    /* A mode is told by its display, what was read back as something else has been named, all else is the statusword. */
    const bool named = (drive->report.refusal.index != 0U);
    if ((late == (uint8_t)TUMBLE_STAND_FAULT_PROTOCOL) && !named) {
        const bool mode = (drive->phase == (uint8_t)PHASE_HOME_MODE) || (drive->phase == (uint8_t)PHASE_MOVE_MODE);
        tumble_drive_refused(drive, mode ? TUMBLE_402_MODE_DISPLAY : TUMBLE_402_STATUSWORD, 0,
                             (uint32_t)TUMBLE_ABORT_TIMEOUT);
        return;
    }
    tumble_drive_fail(drive, faulty ? TUMBLE_STAND_FAULT_DRIVE : (tumble_stand_fault_t)late);
}

static void drive_step(void *self, uint64_t now_us)
{
    tumble_drive402_t *drive = self;
    tumble_drive_check(drive, false);
    if (drive->restart_timer) {
        drive->restart_timer = false;
        drive->entered_us = now_us;
    }
    if (now_us >= deadline_us(drive)) {
        end_late(drive);
    } else if (now_us >= tumble_drive_blind_us(drive)) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_PROTOCOL);
    } else {
        /* in time */
    }
    tumble_drive_climb(drive, now_us);
    drive->report.rung = drive->rung;
}

static uint64_t drive_next_us(const void *self)
{
    const tumble_drive402_t *drive = self;
    const uint64_t watch_us = tumble_earlier(tumble_drive_blind_us(drive), tumble_drive_next_rung_us(drive));
    const bool free_to_go = drive->blocked && tumble_drive_is_sent(drive);
    const bool by_sdo = (drive->asked == ASKED_WRITE) || (drive->asked == ASKED_READ);
    /* On the way an answer may have to wait for a statusword: it makes nothing due. */
    const bool may_wait = (drive->phase >= (uint8_t)PHASE_TARGET) && (drive->phase <= (uint8_t)PHASE_MOVING);
    const bool answered = by_sdo && !may_wait && (tumble_sdo_client_result(&drive->node->client) != TUMBLE_E_SDO_BUSY);
    return (drive->restart_timer || free_to_go || answered) ? 0U : tumble_earlier(deadline_us(drive), watch_us);
}

/* The stand. */

static tumble_stand_state_t drive_state(const void *self)
{
    const tumble_drive402_t *drive = self;
    const bool prepares = (drive->phase == (uint8_t)PHASE_POWER) || (drive->phase == (uint8_t)PHASE_VERIFY);
    if (prepares && (drive->wanted != (uint8_t)PHASE_IDLE)) {
        return (drive->wanted == (uint8_t)PHASE_HOME_MODE) ? TUMBLE_STAND_HOMING : TUMBLE_STAND_MOVING;
    }
    const tumble_stand_state_t known = (tumble_stand_state_t)tumble_drive_rows[drive->phase].state;
    if (known != TUMBLE_STAND_STOPPED) {
        return known;
    }
    if (!drive->homed) {
        return TUMBLE_STAND_READY;
    }
    if (!drive->arrived) {
        return TUMBLE_STAND_STOPPED;
    }
    const bool off_again = drive->at_goal && !tumble_drive_has(drive, TUMBLE_402_STATUS_TARGET_REACHED);
    return off_again ? TUMBLE_STAND_MOVING : TUMBLE_STAND_IN_POSITION;
}

/* Do this as soon as the drive is powered: at once, or after a stop by way of POWER. */
TUMBLE_ONE_COPY static tumble_status_t begin(tumble_drive402_t *drive, tumble_drive_phase_t action)
{
    drive->wanted = (uint8_t)action;
    drive->travel = 0;
    drive->reported_us = drive->node->now_us;
    drive->spare_counts = drive->counts_per_s / 2U;
    tumble_drive_go(drive, (drive->phase == (uint8_t)PHASE_IDLE) ? PHASE_VERIFY : PHASE_POWER);
    return TUMBLE_OK;
}

static tumble_status_t drive_home(void *self)
{
    tumble_drive402_t *drive = self;
    if (!tumble_drive_is_at_rest(drive)) {
        return TUMBLE_E_STAND_STATE;
    }
    drive->homed = false;
    return begin(drive, PHASE_HOME_MODE);
}

static tumble_status_t drive_move(void *self, double angle_deg)
{
    tumble_drive402_t *drive = self;
    int64_t counts;
    if (!tumble_drive_counts(drive->profile, angle_deg, &counts)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!tumble_drive_is_at_rest(drive) || !drive->homed) {
        return TUMBLE_E_STAND_STATE;
    }
    drive->goal_counts = counts;
    return begin(drive, PHASE_TARGET);
}

/* Before the drive is powered nothing moves. From then on tell the axis to stop, whatever we believe it is doing. */
static void drive_stop(void *self)
{
    tumble_drive402_t *drive = self;
    drive->wanted = (uint8_t)PHASE_IDLE;
    if (drive->phase == (uint8_t)PHASE_FAULT) {
        if (tumble_drive_may_turn(drive)) {
            tumble_drive_watch_stop(drive);
        }
        tumble_drive_control(drive, TUMBLE_402_CONTROL_QUICK_STOP);
    } else if ((drive->phase > (uint8_t)PHASE_POWER) && (drive->phase < (uint8_t)PHASE_STOPPING)) {
        tumble_drive_go(drive, PHASE_STOPPING);
    } else {
        /* absent, on its way up, or stopping already */
    }
}

static tumble_status_t drive_clear_fault(void *self)
{
    tumble_drive402_t *drive = self;
    if ((drive->phase != (uint8_t)PHASE_FAULT) || tumble_drive_is_stopping(drive)) {
        return TUMBLE_E_STAND_STATE;
    }
    tumble_emcy_clear(&drive->node->emcy, TUMBLE_ERROR_PROFILE);
    drive->rung = (uint8_t)TUMBLE_RUNG_NONE;
    drive->fault = (uint8_t)TUMBLE_STAND_FAULT_NONE;
    drive->report.fault_code = 0;
    drive->report.refusal = (tumble_stand_refusal_t){0, 0, 0, TUMBLE_ABORT_NONE};
    drive->may_reset = true;
    if (drive->present) {
        configure(drive);
    } else {
        tumble_drive_go(drive, PHASE_ABSENT);
    }
    return TUMBLE_OK;
}

/* A drive that faults over its following error says so in its emergency message, or in bit 13. */
static tumble_stand_fault_t drive_fault(const void *self)
{
    const tumble_drive402_t *drive = self;
    const bool bit_13 = (drive->mirror->mode == TUMBLE_402_MODE_PROFILE_POSITION) &&
                        tumble_drive_has(drive, TUMBLE_402_STATUS_FOLLOWING_ERROR);
    const bool stalled = bit_13 || (drive->report.fault_code == TUMBLE_402_ERROR_FOLLOWING);
    if ((drive->fault == (uint8_t)TUMBLE_STAND_FAULT_DRIVE) && stalled) {
        return TUMBLE_STAND_FAULT_STALL;
    }
    return (tumble_stand_fault_t)drive->fault;
}

static double drive_angle_deg(const void *self)
{
    const tumble_drive402_t *drive = self;
    return tumble_drive_angle_deg(drive->profile, drive->actual_counts);
}

/* What protects the table. */

static bool is_present(const void *self)
{
    const tumble_drive402_t *drive = self;
    return drive->present || (drive->phase != (uint8_t)PHASE_ABSENT);
}

static bool commands(const tumble_drive402_t *drive, uint16_t id)
{
    bool is_command = false;
    for (uint8_t i = 0; i < drive->profile->receive_count; i++) {
        is_command = is_command || ((drive->profile->receive[i].setup.cob_id & TUMBLE_CAN_MAX_ID) == id);
    }
    return is_command;
}

static bool drive_foreign(void *self, uint16_t id, bool ours)
{
    tumble_drive402_t *drive = self;
    const bool is_foreign = ours || commands(drive, id);
    if (is_foreign && (drive->phase >= (uint8_t)PHASE_POWER)) {
        tumble_drive_lose_position(drive, TUMBLE_STAND_FAULT_FOREIGN, TUMBLE_EMCY_FOREIGN, id);
    }
    return is_foreign;
}

/* What a field that decides what comes out of a run is to the seam; the others are nothing to it. */
#define NUMBER_RESULT(type, member)                                                                                    \
    {(uint8_t)TUMBLE_STAND_NUMBER_##type, (uint8_t)offsetof(tumble_drive_profile_t, member)},
#define NUMBER_NO_RESULT(type, member)
#define NUMBER(type, member, standard, signs, result, part, key, low, high, about) NUMBER_##result(type, member)

const tumble_stand_kind_t tumble_drive402_kind = {
    .bytes = (uint16_t)sizeof(tumble_drive402_t),
    .report_at = (uint16_t)offsetof(tumble_drive402_t, report),
    .numbers = {TUMBLE_DRIVE_FIELDS(NUMBER)},
    TUMBLE_STAND_FUNCTIONS(drive),
    .is_present = is_present,
    .heartbeat = drive_heartbeat,
    .emergency = drive_emergency,
    .pdo_received = drive_pdo_received,
    .foreign = drive_foreign,
};
