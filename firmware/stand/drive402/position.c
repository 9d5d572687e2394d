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
#include "stand/drive402/internal.h"

#include "core/one_copy.h"

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
        drive->settled = held && (tumble_drive_stands_still(drive) || for_long);
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
    if (!is_plausible(drive, change)) {
        doubt(drive);
        return;
    }
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
