/* axis.c - words to and from the drive, and what they tell of the axis. */
#include "stand/drive402/internal.h"

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

bool tumble_drive_stands_still(const tumble_drive402_t *drive)
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
