#include "stand/drive402/internal.h"

/* CONFIGURE and the changes of mode: one SDO after the other. */

static void ask_write(tumble_drive402_t *drive, const tumble_object_write_t *write)
{
    const tumble_status_t status = tumble_sdo_client_write(&drive->node->client, drive->drive_node, write->index,
                                                           write->subindex, write->value, write->size);
    drive->asked = (status == TUMBLE_OK) ? ASKED_WRITE : ASKED_NOTHING;
}

void tumble_drive_refused(tumble_drive402_t *drive, uint16_t index, uint8_t subindex, uint32_t abort)
{
    drive->report.refusal = (tumble_stand_refusal_t){index, subindex, drive->phase, abort};
    tumble_drive_fail(drive, TUMBLE_STAND_FAULT_PROTOCOL);
}

bool tumble_drive_is_answered(tumble_drive402_t *drive)
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
void tumble_drive_look_absent(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    const tumble_sdo_client_t *client = &drive->node->client;
    if ((tumble_sdo_client_result(client) == TUMBLE_E_SDO_BUSY) || (drive->profile->heartbeat_ms == 0U) ||
        (tumble_node_state(drive->node) == TUMBLE_NMT_INITIALISING)) {
        return;
    }
    const bool silent = client->abort == (uint32_t)TUMBLE_ABORT_TIMEOUT;
    if ((drive->asked == ASKED_NOTHING) || ((drive->asked == ASKED_WRITE) && silent)) {
        const tumble_object_write_t write = {TUMBLE_DRIVE_HEARTBEAT, 0, 2, drive->profile->heartbeat_ms};
        ask_write(drive, &write);
    } else if (tumble_drive_is_answered(drive)) {
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
void tumble_drive_enter_configure(tumble_drive402_t *drive)
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
            tumble_drive_ask(drive, step->index, step->subindex);
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

void tumble_drive_look_configure(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    tumble_object_write_t step = {0, 0, 0, 0};
    if (!tumble_drive_is_answered(drive)) {
        return;
    }
    for (; tumble_drive_configuration(drive, drive->write, &step); drive->write++) {
        if (drive->asked != ASKED_NOTHING) {
            if (goes_on(drive, &step)) {
                return;
            }
            drive->asked = ASKED_NOTHING;
        } else if (step.size == TUMBLE_DRIVE_READS) {
            tumble_drive_ask(drive, step.index, step.subindex);
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

void tumble_drive_ask(tumble_drive402_t *drive, uint16_t index, uint8_t subindex)
{
    drive->asked = ASKED_READ;
    (void)tumble_sdo_client_read(&drive->node->client, drive->drive_node, index, subindex);
}

/* VERIFY. Somebody else on the bus may have changed what was written at configuration. It is read back before every
 * motion; what differs is written again until the drive keeps it, or the handshake's time is over. A drive may round its
 * quantities; limits it must keep as they are. */

void tumble_drive_enter_verify(tumble_drive402_t *drive)
{
    drive->write = tumble_drive_first_of_motion(drive);
}

static bool keeps(const tumble_sdo_client_t *client, const tumble_object_write_t *wanted)
{
    const uint32_t value = tumble_sdo_client_u32(client);
    const uint32_t off = (value > wanted->value) ? (value - wanted->value) : (wanted->value - value);
    return off <= ((wanted->index == TUMBLE_402_SOFTWARE_LIMIT) ? 0U : (1U + (wanted->value / 64U)));
}

void tumble_drive_look_verify(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
    tumble_object_write_t wanted = {0, 0, 0, 0};
    if (!tumble_drive_is_answered(drive)) {
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
        tumble_drive_ask(drive, wanted.index, wanted.subindex);
    } else {
        drive->report.refusal = (tumble_stand_refusal_t){0, 0, 0, TUMBLE_ABORT_NONE};
        tumble_drive_go(drive, (tumble_drive_phase_t)drive->wanted);
    }
}

/* Write the mode, then read its display until it shows it. */
bool tumble_drive_shows_mode(tumble_drive402_t *drive, int8_t mode)
{
    if (!tumble_drive_is_answered(drive)) {
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
    tumble_drive_ask(drive, TUMBLE_402_MODE_DISPLAY, 0);
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
void tumble_drive_look_start(tumble_drive402_t *drive, bool fresh)
{
    if (drive->asked != ASKED_START) {
        const bool taken = tumble_nmt_command(&drive->node->nmt, drive->drive_node, TUMBLE_NMT_START) == TUMBLE_OK;
        drive->asked = taken ? ASKED_START : ASKED_NOTHING;
    } else if (fresh) {
        drive->asked = ASKED_NOTHING;
        tumble_drive_go(drive, tumble_drive_may_turn(drive) ? PHASE_STOPPING : PHASE_POWER);
    } else {
        /* its first process data are on their way */
    }
}

/* Begin at the bottom of the ramp while the axis is at rest, so that no old set-point and no old Halt survives. */
void tumble_drive_enter_power(tumble_drive402_t *drive)
{
    tumble_drive_control(drive, TUMBLE_402_CONTROL_DISABLE_VOLTAGE);
}

/* The reset acts on the rising edge of bit 7, which must have been seen low before. */
static void look_power_fault(tumble_drive402_t *drive)
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

void tumble_drive_look_power(tumble_drive402_t *drive, bool fresh)
{
    (void)fresh;
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
        look_power_fault(drive);
        break;
    default:
        break; /* on its way */
    }
}
