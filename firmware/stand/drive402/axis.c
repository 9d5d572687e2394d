/* axis.c - angles and counts, words to and from the drive, which position reports are believed, and the ladder of a
 * stop.
 */
#include "stand/drive402/internal.h"

#include "core/arith.h"
#include "core/one_copy.h"

#define TURN_DEG 360.0
#define MAX_WRAPPING_COUNTS 4503599627370496.0 /* 2^52: exact as a double, and far from the end of an int64 */

bool tumble_drive_counts(const tumble_drive_profile_t *profile, double angle_deg, int64_t *counts)
{
    const double exact = (double)profile->sign * angle_deg * profile->counts_per_revolution / TURN_DEG;
    if (!tumble_within(exact, (profile->wrap_counts == 0U) ? (double)INT32_MAX : MAX_WRAPPING_COUNTS)) {
        return false;
    }
    *counts = tumble_nearest(exact);
    return true;
}

uint32_t tumble_drive_way(const tumble_drive_profile_t *profile, double way_deg)
{
    const double exact = (way_deg * profile->counts_per_revolution / TURN_DEG) + 1.0;
    return tumble_within(exact, (double)UINT32_MAX) ? (uint32_t)tumble_whole(exact) : UINT32_MAX;
}

double tumble_drive_angle_deg(const tumble_drive_profile_t *profile, int64_t counts)
{
    return (double)profile->sign * (double)counts * TURN_DEG / profile->counts_per_revolution;
}

/* What is left of `counts`, with its sign, after whole circles: the longest way of doubled circles first. It saves the
 * library's division of 64 bits. */
TUMBLE_ONE_COPY static int64_t rest_of(int64_t counts, int64_t wrap)
{
    int64_t rest = (counts < 0) ? -counts : counts;
    while (rest >= wrap) {
        int64_t way = wrap;
        while ((2 * way) <= rest) {
            way *= 2;
        }
        rest -= way;
    }
    return (counts < 0) ? -rest : rest;
}

int32_t tumble_drive_wrapped(const tumble_drive_profile_t *profile, int64_t counts)
{
    const int64_t wrap = (int64_t)profile->wrap_counts;
    if (wrap == 0) {
        return (int32_t)counts;
    }
    const int64_t rest = rest_of(counts, wrap);
    return (int32_t)((rest < 0) ? (rest + wrap) : rest);
}

int64_t tumble_drive_unwrapped(const tumble_drive_profile_t *profile, int32_t raw, int64_t before)
{
    const int64_t wrap = (int64_t)profile->wrap_counts;
    if (wrap == 0) {
        return raw;
    }
    int64_t change = rest_of((int64_t)raw - before, wrap);
    if (change > (wrap / 2)) {
        change -= wrap;
    } else if (change < -(wrap / 2)) {
        change += wrap;
    } else {
        /* the shorter way already */
    }
    return before + change;
}

/* Words to and from the drive, and what they tell of the axis. */

/* So many reports without a change are standstill: one or two may come at the same moment, for other reasons. */
#define STILL_REPORTS 3U

bool tumble_drive_has(const tumble_drive402_t *drive, unsigned bits)
{
    return (drive->mirror->statusword & bits) != 0U;
}

uint16_t tumble_drive_power_state(const tumble_drive402_t *drive)
{
    const unsigned word = drive->mirror->statusword;
    switch (word & TUMBLE_402_STATE_MASK_SHORT) {
    case TUMBLE_402_STATE_NOT_READY:
    case TUMBLE_402_STATE_SWITCH_ON_DISABLED:
    case TUMBLE_402_STATE_FAULT_REACTION:
    case TUMBLE_402_STATE_FAULT:
        return (uint16_t)(word & TUMBLE_402_STATE_MASK_SHORT);
    default:
        return (uint16_t)(word & TUMBLE_402_STATE_MASK);
    }
}

bool tumble_drive_is_faulty(const tumble_drive402_t *drive)
{
    const uint16_t state = tumble_drive_power_state(drive);
    return (state == TUMBLE_402_STATE_FAULT) || (state == TUMBLE_402_STATE_FAULT_REACTION);
}

bool tumble_drive_may_turn(const tumble_drive402_t *drive)
{
    const uint16_t state = tumble_drive_power_state(drive);
    return (state == TUMBLE_402_STATE_OPERATION_ENABLED) || (state == TUMBLE_402_STATE_QUICK_STOP_ACTIVE);
}

bool tumble_drive_is_at_rest(const tumble_drive402_t *drive)
{
    return (drive->phase == (uint8_t)PHASE_IDLE) || (drive->phase == (uint8_t)PHASE_STOPPED);
}

bool tumble_drive_is_sent(const tumble_drive402_t *drive)
{
    bool sent = true;
    for (unsigned i = 0; i < drive->profile->receive_count; i++) {
        sent = sent && !drive->node->pdos.transmit[i].pdo.due;
    }
    return sent;
}

void tumble_drive_control(tumble_drive402_t *drive, unsigned word)
{
    drive->mirror->controlword = (uint16_t)word;
    for (uint8_t i = 0; i < drive->profile->receive_count; i++) {
        tumble_pdo_trigger(&drive->node->pdos, i);
    }
}

/* Must the process data still go before there is anything to look at? */
bool tumble_drive_is_blocked(tumble_drive402_t *drive)
{
    drive->blocked = !tumble_drive_is_sent(drive);
    return drive->blocked;
}

void tumble_drive_leave_sdo(tumble_drive402_t *drive)
{
    if ((drive->asked == ASKED_WRITE) || (drive->asked == ASKED_READ)) {
        tumble_sdo_client_cancel(&drive->node->client);
    }
    drive->asked = ASKED_NOTHING;
}

/* Has the same position been reported again and again? */
static bool stands_still(const tumble_drive402_t *drive)
{
    return drive->still >= STILL_REPORTS;
}

bool tumble_drive_is_stopping(const tumble_drive402_t *drive)
{
    return (drive->rung != (uint8_t)TUMBLE_RUNG_NONE) && (drive->rung < (uint8_t)TUMBLE_RUNG_UNCONFIRMED);
}

/* A stop within a stop goes on where the first one is. */
void tumble_drive_watch_stop(tumble_drive402_t *drive)
{
    if (tumble_drive_is_stopping(drive)) {
        return;
    }
    drive->rung = (uint8_t)TUMBLE_RUNG_TOLD;
    drive->begun = false;
    drive->still = 0;
    drive->told_us = drive->node->now_us;
}

/* Where the axis is: which reports are believed, how far homing has turned, whether the axis strays at rest.
 *
 * A drive that wraps reports its position within one circle; the turns are counted here. A turn too many would be a
 * turn of the cable:
 *
 *     reported    350    10     20       small steps: the axis has turned on, to 370 and 380
 *     reported    350           170      half a circle unseen: 170 or 530?
 *
 * So a change counts only if the axis can have made it since the report before. What a report leaves of its way, the
 * next ones may use, but not for more than 1 s / REPORTS_PER_S in all:
 *
 *     |change| <= way = spare + 2 velocity (time since the last report)
 *     spare     = min(way - |change|, 2 velocity / REPORTS_PER_S)
 *
 * The spare way is for reports that waited for each other: all that a step finds have the same time. It grows with time
 * and not with reports, so that no number of forged ones turns the count by more than that.
 */

#define REPORTS_PER_S 4U
#define SETTLED_US UINT64_C(2000000)
#define DOUBTS 2U
#define QUARTER_DEG 90.0
#define BLIND_US UINT64_C(1200000) /* longer than a heartbeat may be away: a silent drive is told as what it is */

TUMBLE_ONE_COPY static uint32_t saturated(uint64_t counts)
{
    return (counts < UINT32_MAX) ? (uint32_t)counts : UINT32_MAX;
}

static uint32_t size_of(int64_t counts)
{
    return saturated((uint64_t)((counts < 0) ? -counts : counts));
}

/* The way at profile velocity since the last report, by 2^20 us for a second: 5 % short, which the factor 2 forgives. */
static uint32_t way_counts(const tumble_drive402_t *drive)
{
    return saturated(((uint64_t)drive->counts_per_s * saturated(drive->node->now_us - drive->reported_us)) >> 20U);
}

/* Can the axis have come so far? Uses up its way. */
static bool is_in_reach(tumble_drive402_t *drive, uint32_t size)
{
    const uint32_t most = drive->counts_per_s / (REPORTS_PER_S / 2U);
    const uint64_t way = (uint64_t)drive->spare_counts + (2U * (uint64_t)way_counts(drive));
    if (size > way) {
        return false;
    }
    drive->spare_counts = ((way - size) < most) ? (uint32_t)(way - size) : most;
    return true;
}

/* A drive that wraps and was not heard for half a circle: nobody knows which one it is in. */
static bool is_guess(const tumble_drive402_t *drive)
{
    const uint32_t half_circle = drive->profile->wrap_counts / 2U;
    return (half_circle != 0U) && (way_counts(drive) >= half_circle);
}

static bool is_homing(const tumble_drive402_t *drive)
{
    return (drive->phase >= (uint8_t)PHASE_HOME_MODE) && (drive->phase <= (uint8_t)PHASE_MOVE_MODE);
}

/* Must the axis stay where it is? Without power and not homed it may be turned by hand. */
static bool is_held(const tumble_drive402_t *drive)
{
    return tumble_drive_is_at_rest(drive) && (drive->homed || tumble_drive_may_turn(drive));
}

/* An axis that stands, or was told to rest long ago, is measured from where it is. */
static void settle(tumble_drive402_t *drive)
{
    const bool held = is_held(drive) && drive->tracked;
    const bool for_long = (drive->node->now_us - drive->entered_us) >= SETTLED_US;
    if (!held || !drive->settled) {
        drive->settled = held && (stands_still(drive) || for_long);
        drive->strayed = 0;
    }
}

/* Before homing any position is plausible, because homing sets another zero. But an axis that was told to rest must
 * rest. */
static bool is_plausible(tumble_drive402_t *drive, int64_t change)
{
    if (drive->settled) {
        return size_of((int64_t)drive->strayed + change) <= drive->rest_counts;
    }
    return !drive->homed || !drive->tracked || (is_in_reach(drive, size_of(change)) && !is_guess(drive));
}

/* One report may be garbled: it is dropped. */
static void doubt(tumble_drive402_t *drive)
{
    tumble_count(&drive->report.stop.implausible);
    drive->doubtful++;
    if (drive->doubtful >= DOUBTS) {
        drive->doubtful = 0;
        tumble_drive_lose_position(drive, TUMBLE_STAND_FAULT_POSITION, TUMBLE_EMCY_POSITION, 0);
    }
}

/* The zero that homing sets is no movement: whatever its size, it counts as a quarter of a turn at most. */
static void follow_homing(tumble_drive402_t *drive, uint32_t size)
{
    const uint32_t quarter = tumble_drive_way(drive->profile, QUARTER_DEG);
    drive->travel += (size < quarter) ? size : quarter;
    if ((drive->homing_counts != 0U) && (drive->travel > drive->homing_counts)) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_HOMING);
    }
}

void tumble_drive_take_position(tumble_drive402_t *drive)
{
    const int32_t raw = drive->mirror->actual_position;
    const int64_t before = drive->actual_counts;
    const int64_t change = tumble_drive_unwrapped(drive->profile, raw, before) - before;
    settle(drive);
    drive->placed = false;
    if (!is_plausible(drive, change)) {
        doubt(drive);
        return;
    }
    drive->placed = tumble_drive_has(drive, TUMBLE_402_STATUS_TARGET_REACHED);
    if (drive->settled) {
        drive->strayed += (int32_t)change;
    }
    if (is_homing(drive)) {
        follow_homing(drive, size_of(change));
    }
    drive->doubtful = 0;
    drive->tracked = true;
    if (way_counts(drive) != 0U) { /* else the time since then goes on: reports may be closer than a count */
        drive->reported_us = drive->node->now_us;
    }
    drive->actual_counts = drive->homed ? (before + change) : raw;
    if (drive->actual_counts != before) {
        drive->still = 0;
    } else if (drive->still < UINT8_MAX) {
        drive->still++;
    } else {
        /* at rest for long */
    }
}

/* Before POWER we have not led the axis, and in FAULT it is being stopped already: only in between this is a new
 * fault. */
void tumble_drive_lose_position(tumble_drive402_t *drive, tumble_stand_fault_t fault, uint16_t code, uint16_t detail)
{
    const bool told = !drive->homed && (drive->fault == (uint8_t)fault);
    drive->homed = false;
    drive->tracked = false;
    if (!told) {
        tumble_emcy_tell(&drive->node->emcy, code, TUMBLE_ERROR_PROFILE, detail);
    }
    if ((drive->phase >= (uint8_t)PHASE_POWER) && (drive->phase != (uint8_t)PHASE_FAULT)) {
        tumble_drive_fail(drive, fault);
    }
}

/* If the reports have a timer, they must keep coming while the axis turns: an axis that is not seen cannot be stopped
 * in time. */
uint64_t tumble_drive_blind_us(const tumble_drive402_t *drive)
{
    const bool turns = (drive->phase == (uint8_t)PHASE_HOMING) || (drive->phase == (uint8_t)PHASE_MOVING);
    return (turns && drive->timed) ? (drive->reported_us + BLIND_US) : TUMBLE_NEVER;
}

/* A stop is over when the axis is seen at rest. Until then the drive is told again, by harsher means: the ladder of
 * drive402.h.
 *
 * A drive that obeys gets time to brake: once it has left Operation enabled, or is halting, all times count from the
 * end of stop_timeout_ms. At any rung a report of rest leaves the ladder.
 *
 * The ladder does not depend on the phase. A stop that begins in STOPPING becomes a FAULT at the NMT rung, which takes
 * the drive out of operation, and goes on there. From that rung on there are no process data that tell of the axis, so
 * only the next bring-up can see it at rest.
 */

#define US_PER_MS UINT64_C(1000)

static uint64_t since_us(const tumble_drive402_t *drive, unsigned rung)
{
    static const uint16_t after_ms[TUMBLE_RUNG_UNCONFIRMED + 1] = {
        [TUMBLE_RUNG_AGAIN] = 200,    [TUMBLE_RUNG_SDO] = 400,          [TUMBLE_RUNG_NMT] = 1000,
        [TUMBLE_RUNG_SILENCE] = 1500, [TUMBLE_RUNG_UNCONFIRMED] = 1800, /* and the time of the drive's consumer */
    };
    const bool last = (rung == (unsigned)TUMBLE_RUNG_UNCONFIRMED);
    const uint32_t more_ms = (drive->begun ? drive->profile->stop_timeout_ms : 0U) +
                             (last ? (uint32_t)drive->profile->heartbeat_timeout_ms : 0U);
    return drive->told_us + (((uint64_t)after_ms[rung] + more_ms) * US_PER_MS);
}

uint64_t tumble_drive_next_rung_us(const tumble_drive402_t *drive)
{
    return tumble_drive_is_stopping(drive) ? since_us(drive, drive->rung + 1U) : TUMBLE_NEVER;
}

void tumble_drive_end_stop(tumble_drive402_t *drive)
{
    const bool is_lost = (drive->fault == (uint8_t)TUMBLE_STAND_FAULT_POSITION) ||
                         (drive->fault == (uint8_t)TUMBLE_STAND_FAULT_FOREIGN); /* that is still to be told */
    if ((drive->rung > (uint8_t)TUMBLE_RUNG_TOLD) && !is_lost) {
        tumble_emcy_clear(&drive->node->emcy, TUMBLE_ERROR_PROFILE);
    }
    drive->rung = (uint8_t)TUMBLE_RUNG_NONE;
}

bool tumble_drive_rests(tumble_drive402_t *drive)
{
    const uint16_t state = tumble_drive_power_state(drive);
    const bool halting = (drive->mirror->controlword & TUMBLE_402_CONTROL_HALT) != 0U;
    const bool obeys = (state != TUMBLE_402_STATE_OPERATION_ENABLED) || halting;
    drive->begun = drive->begun || obeys;
    if (!obeys) {
        drive->still = 0;
        return false;
    }
    if (!tumble_drive_may_turn(drive)) { /* it has let go, and may coast or brake by itself */
        return stands_still(drive) || !drive->timed;
    }
    /* Under Halt bit 10 may be that of the target before, so the position tells where it is told by a timer. */
    return stands_still(drive) ||
           (tumble_drive_has(drive, TUMBLE_402_STATUS_TARGET_REACHED) && !(halting && drive->timed));
}

/* The rungs. */

void tumble_drive_tell_by_sdo(tumble_drive402_t *drive)
{
    tumble_drive_leave_sdo(drive);
    (void)tumble_sdo_client_write(&drive->node->client, drive->drive_node, TUMBLE_402_CONTROLWORD, 0,
                                  drive->mirror->controlword, (uint8_t)sizeof drive->mirror->controlword);
}

static void take_out_of_operation(tumble_drive402_t *drive)
{
    (void)tumble_nmt_command(&drive->node->nmt, drive->drive_node, TUMBLE_NMT_STOP);
    if (drive->phase != (uint8_t)PHASE_FAULT) {
        tumble_drive_fail(drive, TUMBLE_STAND_FAULT_STOP);
    }
}

static void fall_silent(tumble_drive402_t *drive)
{
    tumble_nmt_withhold(&drive->node->nmt, since_us(drive, TUMBLE_RUNG_UNCONFIRMED));
}

static void act(tumble_drive402_t *drive)
{
    switch (drive->rung) {
    case TUMBLE_RUNG_AGAIN:
        tumble_drive_control(drive, drive->mirror->controlword);
        break;
    case TUMBLE_RUNG_SDO:
        tumble_drive_tell_by_sdo(drive);
        break;
    case TUMBLE_RUNG_NMT:
        take_out_of_operation(drive);
        break;
    case TUMBLE_RUNG_SILENCE:
        fall_silent(drive);
        break;
    default:
        break; /* nothing is left */
    }
}

void tumble_drive_climb(tumble_drive402_t *drive, uint64_t now_us)
{
    while (now_us >= tumble_drive_next_rung_us(drive)) {
        drive->rung++;
        tumble_count(&drive->report.stop.rungs[drive->rung - (uint8_t)TUMBLE_RUNG_AGAIN]);
        tumble_emcy_tell(&drive->node->emcy, TUMBLE_EMCY_STOP, TUMBLE_ERROR_PROFILE, drive->rung);
        act(drive);
    }
}
