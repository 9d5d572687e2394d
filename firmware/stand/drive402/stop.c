/* A stop is over when the axis is seen at rest. Until then the drive is told again, by harsher means: the ladder of
 * drive402.h. A drive that never obeys climbs it all:
 *
 *     s     0      0.2     0.4                1.0           1.5             1.8 + the drive's heartbeat timeout
 *           |       |       |                  |             |               |
 *           told    again   SDO                NMT stop      silence         not confirmed
 *           PDO     PDO     6040h by SDO       leaves        our heartbeat   somebody must look at the table
 *                                              Operational   is withheld
 *
 * A drive that obeys gets time to brake: once it has left Operation enabled, or is halting, all times count from the
 * end of stop_timeout_ms. At any rung a report of rest leaves the ladder.
 *
 * The ladder does not depend on the phase. A stop that begins in STOPPING becomes a FAULT at the NMT rung, which takes
 * the drive out of operation, and goes on there. From that rung on there are no process data that tell of the axis, so
 * only the next bring-up can see it at rest.
 */
#include "stand/drive402/internal.h"

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
        return tumble_drive_stands_still(drive) || !drive->timed;
    }
    /* Under Halt bit 10 may be that of the target before, so the position tells where it is told by a timer. */
    return tumble_drive_stands_still(drive) ||
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
