#include "scripted_drive.h"

void scripted_drive_boot(scripted_drive_t *drive, fake_port_t *fake)
{
    const tumble_can_frame_t boot_up = {.id = TUMBLE_HEARTBEAT_ID + SCRIPTED_DRIVE_NODE, .length = 1};
    drive->nmt = TUMBLE_NMT_PRE_OPERATIONAL;
    drive->power = TUMBLE_402_STATE_SWITCH_ON_DISABLED;
    drive->controlword = 0;
    drive->flags = 0;
    drive->mode = 0;
    drive->homing = false;
    drive->arrival_us = UINT64_MAX;
    drive->next_heartbeat_us = fake->now_us + 100000U;
    drive->next_report_us = fake->now_us;
    fake_port_give(fake, &boot_up);
}

void scripted_drive_init(scripted_drive_t *drive, fake_port_t *fake)
{
    *drive = (scripted_drive_t){.position_counts = 12345};
    scripted_drive_boot(drive, fake);
}

bool scripted_drive_moves(const scripted_drive_t *drive)
{
    return drive->arrival_us != UINT64_MAX;
}

double scripted_drive_angle_deg(const scripted_drive_t *drive)
{
    return (double)drive->position_counts * 360.0 / SCRIPTED_COUNTS_PER_REVOLUTION;
}

static void scripted_drive_halt(scripted_drive_t *drive)
{
    drive->arrival_us = UINT64_MAX;
    drive->homing = false;
}

static void scripted_drive_power(scripted_drive_t *drive, uint16_t word, bool reset_edge)
{
    const uint16_t command = word & TUMBLE_402_CONTROL_MASK;
    if (drive->power == TUMBLE_402_STATE_FAULT) {
        drive->power = reset_edge ? TUMBLE_402_STATE_SWITCH_ON_DISABLED : TUMBLE_402_STATE_FAULT;
    } else if ((command & 0x02U) == 0U) {
        drive->power = TUMBLE_402_STATE_SWITCH_ON_DISABLED;
    } else if ((command & 0x04U) == 0U) {
        drive->power = (drive->power == TUMBLE_402_STATE_OPERATION_ENABLED) ? TUMBLE_402_STATE_QUICK_STOP_ACTIVE
                                                                            : TUMBLE_402_STATE_SWITCH_ON_DISABLED;
        drive->flags |= TUMBLE_402_STATUS_TARGET_REACHED;
    } else if (command == TUMBLE_402_CONTROL_SHUTDOWN) {
        drive->power = TUMBLE_402_STATE_READY_TO_SWITCH_ON;
    } else if ((command == TUMBLE_402_CONTROL_SWITCH_ON) && (drive->power != TUMBLE_402_STATE_SWITCH_ON_DISABLED)) {
        drive->power = TUMBLE_402_STATE_SWITCHED_ON;
    } else if ((command == TUMBLE_402_CONTROL_ENABLE) && (drive->power != TUMBLE_402_STATE_SWITCH_ON_DISABLED)) {
        drive->power = TUMBLE_402_STATE_OPERATION_ENABLED;
    } else {
        /* no such transition */
    }
    if (drive->power != TUMBLE_402_STATE_OPERATION_ENABLED) {
        scripted_drive_halt(drive);
    }
}

static void scripted_drive_set_out(scripted_drive_t *drive, const fake_port_t *fake)
{
    drive->homing = (drive->mode == TUMBLE_402_MODE_HOMING);
    drive->start_counts = drive->position_counts;
    drive->goal_counts = drive->homing ? 0 : drive->target_counts;
    drive->arrival_us = drive->jammed ? (UINT64_MAX - 1U) : (fake->now_us + SCRIPTED_MOVE_US);
    drive->flags = drive->homing ? 0U : TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE;
}

static void scripted_drive_control(scripted_drive_t *drive, const fake_port_t *fake, uint16_t word)
{
    const uint16_t before = drive->controlword;
    const uint16_t rising = (uint16_t)(word & ~before);
    drive->controlword = word;
    scripted_drive_power(drive, word, (rising & TUMBLE_402_CONTROL_FAULT_RESET) != 0U);
    if (drive->power != TUMBLE_402_STATE_OPERATION_ENABLED) {
        return;
    }
    if ((rising & TUMBLE_402_CONTROL_NEW_SET_POINT) != 0U) {
        scripted_drive_set_out(drive, fake);
    } else if (((word & TUMBLE_402_CONTROL_NEW_SET_POINT) == 0U) && (drive->mode == TUMBLE_402_MODE_PROFILE_POSITION)) {
        drive->flags &= (uint16_t)~TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE;
    } else {
        /* as before */
    }
}

static void scripted_drive_answer_sdo(scripted_drive_t *drive, fake_port_t *fake, const uint8_t *request)
{
    tumble_can_frame_t answer = {.id = TUMBLE_SDO_RESPONSE_ID + SCRIPTED_DRIVE_NODE, .length = 8};
    const uint16_t index = tumble_get_u16(&request[1]);
    for (int i = 1; i < 4; i++) {
        answer.data[i] = request[i];
    }
    if (request[0] == 0x40U) {
        answer.data[0] = (index == TUMBLE_402_TARGET_POSITION) ? 0x43U : 0x4FU; /* four bytes or one */
        tumble_put_i32(&answer.data[4], (index == TUMBLE_402_TARGET_POSITION) ? drive->target_counts
                                        : (index == TUMBLE_402_MODE_DISPLAY)  ? (uint8_t)drive->mode
                                                                              : 0);
    } else if ((request[0] & 0xE0U) != 0x20U) {
        return; /* an abort, or a kind of transfer that nobody should ask for */
    } else if ((drive->refused_index != 0U) && (index == drive->refused_index)) {
        answer.data[0] = 0x80;
        tumble_put_u32(&answer.data[4], 0x06010002U);
    } else {
        answer.data[0] = 0x60;
        drive->writes++;
        if (index == TUMBLE_402_MODE) {
            drive->mode = tumble_get_i8(&request[4]);
            drive->flags = 0;
        }
    }
    fake_port_give(fake, &answer);
}

void scripted_drive_hear(scripted_drive_t *drive, fake_port_t *fake, const tumble_can_frame_t *frame)
{
    const bool nmt = (frame->id == TUMBLE_NMT_ID) && (frame->length == 2U) &&
                     ((frame->data[1] == 0U) || (frame->data[1] == SCRIPTED_DRIVE_NODE));
    if (drive->dead) {
        return;
    }
    if (nmt && (frame->data[0] == TUMBLE_NMT_START)) {
        drive->nmt = TUMBLE_NMT_OPERATIONAL;
        drive->next_report_us = fake->now_us;
    } else if (frame->id == (TUMBLE_SDO_REQUEST_ID + SCRIPTED_DRIVE_NODE)) {
        scripted_drive_answer_sdo(drive, fake, frame->data);
    } else if ((frame->id == (0x200U + SCRIPTED_DRIVE_NODE)) && (drive->nmt == TUMBLE_NMT_OPERATIONAL)) {
        drive->target_counts = tumble_get_i32(&frame->data[2]);
        scripted_drive_control(drive, fake, tumble_get_u16(frame->data));
    } else {
        /* not for the drive */
    }
}

static uint16_t scripted_drive_statusword(const scripted_drive_t *drive)
{
    const unsigned voltage = TUMBLE_402_STATUS_VOLTAGE | TUMBLE_402_STATUS_REMOTE;
    return (uint16_t)(drive->power | drive->flags | voltage);
}

static void scripted_drive_report(scripted_drive_t *drive, fake_port_t *fake)
{
    tumble_can_frame_t frame = {.id = 0x180U + SCRIPTED_DRIVE_NODE, .length = 6};
    drive->reported = scripted_drive_statusword(drive);
    drive->next_report_us = fake->now_us + SCRIPTED_REPORT_US;
    tumble_put_u16(frame.data, drive->reported);
    tumble_put_i32(&frame.data[2], drive->position_counts);
    fake_port_give(fake, &frame);
}

void scripted_drive_fail(scripted_drive_t *drive, fake_port_t *fake, uint16_t code)
{
    tumble_can_frame_t frame = {.id = TUMBLE_EMCY_ID + SCRIPTED_DRIVE_NODE, .length = 8};
    drive->power = TUMBLE_402_STATE_FAULT;
    scripted_drive_halt(drive);
    tumble_put_u16(frame.data, code);
    frame.data[2] = TUMBLE_ERROR_GENERIC | TUMBLE_ERROR_PROFILE;
    fake_port_give(fake, &frame);
    scripted_drive_report(drive, fake);
}

static void scripted_drive_arrive(scripted_drive_t *drive)
{
    drive->position_counts = drive->goal_counts;
    drive->flags |= TUMBLE_402_STATUS_TARGET_REACHED;
    drive->flags |= drive->homing ? TUMBLE_402_STATUS_HOMING_ATTAINED : 0U;
    scripted_drive_halt(drive);
}

void scripted_drive_step(scripted_drive_t *drive, fake_port_t *fake)
{
    if (drive->dead) {
        return;
    }
    if (fake->now_us >= drive->arrival_us) {
        scripted_drive_arrive(drive);
    }
    if (fake->now_us >= drive->next_heartbeat_us) {
        const tumble_can_frame_t beat = {
            .id = TUMBLE_HEARTBEAT_ID + SCRIPTED_DRIVE_NODE, .length = 1, .data = {drive->nmt}};
        fake_port_give(fake, &beat);
        drive->next_heartbeat_us = fake->now_us + 100000U;
    }
    const bool changed = scripted_drive_statusword(drive) != drive->reported;
    if ((drive->nmt == TUMBLE_NMT_OPERATIONAL) && (changed || (fake->now_us >= drive->next_report_us))) {
        scripted_drive_report(drive, fake);
    }
}

uint64_t scripted_drive_next_us(const scripted_drive_t *drive)
{
    uint64_t next_us = drive->next_heartbeat_us;
    if (drive->dead) {
        return UINT64_MAX;
    }
    if ((drive->nmt == TUMBLE_NMT_OPERATIONAL) && (drive->next_report_us < next_us)) {
        next_us = drive->next_report_us;
    }
    return (drive->arrival_us < next_us) ? drive->arrival_us : next_us;
}

static const tumble_drive_pdo_t scripted_drive_receive[] = {
    {.number = 0,
     .setup = {.cob_id = 0x202, .type = TUMBLE_PDO_EVENT_PROFILE, .count = 2, .map = {0x60400010, 0x607A0020}}},
};
static const tumble_drive_pdo_t scripted_drive_transmit[] = {
    {.number = 0,
     .setup = {.cob_id = 0x182,
               .type = TUMBLE_PDO_EVENT_PROFILE,
               .count = 2,
               .event_ms = 20,
               .map = {0x60410010, 0x60640020}}},
};
const tumble_drive_profile_t scripted_drive_profile = {
    .counts_per_revolution = SCRIPTED_COUNTS_PER_REVOLUTION,
    .velocity_units_per_deg_s = 1000.0,
    .acceleration_units_per_deg_s2 = 1000.0,
    .sign = 1,
    .window_counts = 50,
    .velocity_deg_s = 1000.0, /* any move takes 0.2 s */
    .acceleration_deg_s2 = 180.0,
    .deceleration_deg_s2 = 180.0,
    .quick_stop_deg_s2 = 720.0,
    .homing_fast_deg_s = 20.0,
    .homing_slow_deg_s = 2.0,
    .homing_acceleration_deg_s2 = 90.0,
    .homing_method = 35,
    .stop = TUMBLE_STOP_BY_QUICK_STOP,
    .receive = scripted_drive_receive,
    .transmit = scripted_drive_transmit,
    .receive_count = 1,
    .transmit_count = 1,
    .heartbeat_ms = 100,
    .heartbeat_timeout_ms = 500,
    .start_timeout_ms = 1000,
    .power_timeout_ms = 1000,
    .handshake_timeout_ms = 500,
    .home_timeout_ms = 30000,
    .move_timeout_ms = 15000,
    .stop_timeout_ms = 2000,
};
