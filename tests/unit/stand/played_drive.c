#include "played_drive.h"

void played_send(uint16_t id, uint8_t length, const uint8_t *data)
{
    const tumble_can_frame_t frame = fake_frame(id, length, data);
    fake_port_give(&port, &frame);
}

static uint32_t played_value(uint32_t object)
{
    const played_drive_t *d = &played;
    switch (object >> 16) {
    case 0x6041:
        return (uint32_t)d->state | d->bits | 0x0210U;
    case 0x6064:
        return (uint32_t)d->actual;
    case 0x6061:
        return (uint8_t)d->mode_display;
    case 0x607A:
        return (uint32_t)d->target;
    default:
        return 0x5A5A5A5AU;
    }
}

void played_transmit(void)
{
    if (played.homing && (played.reports++ >= played.old_reports)) {
        played.bits &= (uint16_t)~0x3400U;
    }
    for (unsigned n = 0; n < 4U; n++) {
        const played_pdo_t *pdo = &played.transmit[n];
        if (((pdo->cob_id & 0x80000000U) != 0U) || (pdo->count == 0U) || !played.operational) {
            continue;
        }
        uint8_t data[8] = {0};
        uint8_t length = 0;
        for (unsigned i = 0; i < pdo->count; i++) {
            const uint32_t value = played_value(pdo->map[i]);
            for (unsigned byte = 0; byte < ((pdo->map[i] & 0xFFU) / 8U); byte++) {
                data[length++] = (uint8_t)(value >> (8U * byte));
            }
        }
        played_send((uint16_t)(pdo->cob_id & 0x7FFU), length, data);
    }
}

void played_heartbeat(uint8_t state)
{
    played_send(0x700U + DRIVE_NODE, 1, &state);
}

void played_emergency(uint16_t code)
{
    const uint8_t data[8] = {(uint8_t)code, (uint8_t)(code >> 8), 0x21};
    played_send(0x080U + DRIVE_NODE, 8, data);
}

void played_boot(void)
{
    played_drive_t *d = &played;
    d->powered_up = true;
    d->operational = false;
    d->stopped = false;
    d->heard_ms = clock_ms;
    d->state = IS_DISABLED;
    d->bits = 0;
    d->mode = 0;
    d->mode_display = 0;
    d->control = 0;
    d->moving = false;
    d->homing = false;
    for (unsigned n = 0; n < 4U; n++) {
        d->receive[n] = (played_pdo_t){.cob_id = 0x80000000U};
        d->transmit[n] = (played_pdo_t){.cob_id = 0x80000000U};
    }
    played_heartbeat(0);
}

void played_fault(uint16_t code)
{
    played.state = IS_FAULT;
    played.moving = false;
    if (code != 0U) {
        played_emergency(code);
    }
    played_transmit();
}

/* A PDO parameter, under the rules of CiA 301: an enabled PDO is not remapped, a mapping in use not changed. */
static bool played_map(uint16_t index, uint8_t subindex, uint32_t value)
{
    played_pdo_t *pdo = (index >= 0x1800U) ? &played.transmit[index & 3U] : &played.receive[index & 3U];
    const bool mapping = ((index & 0x0200U) != 0U);
    const bool disabled = ((pdo->cob_id & 0x80000000U) != 0U);
    if (!mapping) {
        if (subindex == 1U) {
            pdo->cob_id = value;
        }
        return (subindex == 1U) || disabled;
    }
    if (subindex == 0U) {
        pdo->count = (uint8_t)value;
        return disabled;
    }
    pdo->map[subindex - 1U] = value;
    return disabled && (pdo->count == 0U);
}

static void played_write(const sdo_write_t *write)
{
    played_drive_t *d = &played;
    TEST_ASSERT_TRUE_MESSAGE(d->write_count < MAX_WRITES, "too many SDO writes");
    d->writes[d->write_count++] = *write;
    if ((write->index >= 0x1400U) && (write->index < 0x1C00U)) {
        const bool in_order = played_map(write->index, write->subindex, write->value);
        TEST_ASSERT_TRUE_MESSAGE(in_order, "PDO written in a wrong order");
    } else if (write->index == 0x1017U) {
        d->mute = d->mute && d->stays_mute;
    } else if (write->index == 0x6040U) {
        const uint16_t before = d->control;
        d->control = (uint16_t)write->value;
        played_power(before);
        played_transmit();
    } else if (write->index == 0x607DU) {
        d->limits[write->subindex - 1U] = d->keeps_no_limits ? 0 : (int32_t)write->value;
    } else if (write->index == 0x6060U) {
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(0, write->subindex, "6060h has no subindices");
        TEST_ASSERT_FALSE_MESSAGE((d->control & 0x0100U) != 0U, "mode changed while Halt is set");
        d->mode = (int8_t)write->value;
        d->mode_display = d->mode_sticks ? d->mode_display : d->mode;
        d->bits = (d->attained_from_before && (d->mode == 6)) ? 0x1400 : (uint16_t)(d->bits & 0x0400U);
        played_transmit();
    }
}

static void played_sdo(const tumble_can_frame_t *frame)
{
    const uint8_t *r = frame->data;
    const uint16_t index = (uint16_t)(r[1] | (r[2] << 8));
    uint8_t answer[8] = {0x60, r[1], r[2], r[3]};
    if (played.sdo_is_deaf || (r[0] == 0x80U)) {
        return;
    }
    if (index == played.refuse_index) {
        played.refusals++;
        const uint8_t abort[8] = {0x80, r[1], r[2], r[3], 0x00, 0x00, 0x02, 0x06};
        played_send(0x580U + DRIVE_NODE, 8, abort);
        return;
    }
    if ((r[0] & 0xE0U) == 0x20U) {
        const uint32_t value =
            (uint32_t)r[4] | ((uint32_t)r[5] << 8) | ((uint32_t)r[6] << 16) | ((uint32_t)r[7] << 24);
        const sdo_write_t write = {index, r[3], (uint8_t)(4U - ((r[0] >> 2) & 3U)), value};
        played_send(0x580U + DRIVE_NODE, 8, answer);
        played_write(&write);
    } else {
        TEST_ASSERT_TRUE_MESSAGE((r[3] == 0U) || (index == 0x607DU), "what is read has no subindices");
        const uint32_t value = (index == 0x607DU) ? (uint32_t)played.limits[r[3] - 1U] : played_value((uint32_t)index << 16);
        const unsigned size = ((index == 0x607AU) || (index == 0x607DU)) ? 4U : 1U;
        answer[0] = (uint8_t)(0x43U | ((4U - size) << 2U));
        for (unsigned byte = 0; byte < size; byte++) {
            answer[4U + byte] = (uint8_t)(value >> (8U * byte));
        }
        played_send(0x580U + DRIVE_NODE, 8, answer);
    }
}

/* Told again it goes on braking. */
static void played_halt(uint16_t before)
{
    played_drive_t *d = &played;
    d->braking_ms = ((before & 0x0100U) == 0U) ? d->brakes_for_ms : d->braking_ms;
    if (!d->ignores_stop && (d->brakes_for_ms == 0U)) {
        d->moving = false;
        d->bits |= 0x0400U;
    }
}

static void played_control(const tumble_can_frame_t *frame, const played_pdo_t *pdo)
{
    played_drive_t *d = &played;
    const uint16_t before = d->control;
    const int32_t target = d->target;
    unsigned at = 0;
    for (unsigned i = 0; i < pdo->count; i++) {
        uint32_t value = 0;
        const unsigned bytes = (pdo->map[i] & 0xFFU) / 8U;
        for (unsigned byte = 0; byte < bytes; byte++) {
            value |= (uint32_t)frame->data[at++] << (8U * byte);
        }
        d->control = ((pdo->map[i] >> 16) == 0x6040U) ? (uint16_t)value : d->control;
        d->target = ((pdo->map[i] >> 16) == 0x607AU) ? (int32_t)value : d->target;
        d->mode = ((pdo->map[i] >> 16) == 0x6060U) ? (int8_t)value : d->mode;
    }
    if (d->misses > 0U) {
        d->misses--;
        d->control = before;
        d->target = target;
        return;
    }
    TEST_ASSERT_TRUE_MESSAGE(d->control_count < MAX_CONTROLS, "too many controlwords");
    d->controls[d->control_count++] = (control_t){d->control, d->target};
    played_power(before);
    if (d->state == IS_ENABLED) {
        if ((d->control & 0x0100U) != 0U) {
            played_halt(before);
        } else if (d->mode == 1) {
            played_position_mode(before);
        } else if (d->mode == 6) {
            played_homing_mode(before);
        }
    }
    played_transmit();
}

static uint8_t played_nmt_state(void)
{
    return played.operational ? 5U : (played.stopped ? 4U : 127U);
}

void played_receive(const tumble_can_frame_t *frame)
{
    played_drive_t *d = &played;
    if (!d->powered_up) {
        return;
    }
    if (frame->id == (0x700U + MASTER_NODE)) {
        d->heard_ms = clock_ms;
    }
    if (frame->id == 0U) {
        if ((frame->data[1] == DRIVE_NODE) || (frame->data[1] == 0U)) {
            d->operational = (frame->data[0] == 1U);
            d->stopped = (frame->data[0] == 2U);
            d->nmt_starts += d->operational ? 1U : 0U;
            d->nmt_stops += d->stopped ? 1U : 0U;
            if (!d->operational && !d->ignores_nmt) {
                played_stop(IS_FAULT);
            }
            played_heartbeat(played_nmt_state());
            played_transmit();
        }
    } else if (frame->id == (0x600U + DRIVE_NODE)) {
        if (!d->stopped) {
            played_sdo(frame);
        }
    } else {
        for (unsigned n = 0; n < 4U; n++) {
            if (d->operational && (d->receive[n].cob_id == frame->id)) {
                played_control(frame, &d->receive[n]);
            }
        }
    }
}

void played_tick(void)
{
    played_drive_t *d = &played;
    if (!d->powered_up) {
        return;
    }
    if (!d->mute && ((clock_ms % 100U) == 0U)) {
        played_heartbeat(played_nmt_state());
    }
    const unsigned silent_ms = clock_ms - d->heard_ms;
    d->silent_ms = (silent_ms > d->silent_ms) ? silent_ms : d->silent_ms;
    if ((d->watches_ms != 0U) && (silent_ms > d->watches_ms)) {
        played_stop(IS_FAULT);
    }
    if (d->moving) {
        played_move();
    }
    if (d->homing) {
        played_home();
    }
    if (!d->event_only && ((clock_ms % 10U) == 0U)) {
        played_transmit();
    }
}
