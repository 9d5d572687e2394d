#include "scripted_drive.h"

/* Its axis: power state machine, modes, motion. */

static void scripted_drive_stop(scripted_drive_t *d, uint16_t state)
{
    d->moving = false;
    d->homing = false;
    d->state = state;
}

static void scripted_drive_power(scripted_drive_t *d, uint16_t before)
{
    const unsigned command = d->control & 0x8FU;
    const bool reset = ((command & 0x80U) != 0U) && ((before & 0x80U) == 0U);
    if ((d->state == IS_FAULT) || (d->state == IS_FAULT_REACTION)) {
        d->state = (reset && !d->resets_nothing) ? IS_DISABLED : d->state;
    } else if ((command & 0x02U) == 0U) {
        d->coasted = d->coasted || d->moving;
        scripted_drive_stop(d, IS_DISABLED);
    } else if ((command & 0x06U) == 0x02U) {
        if ((d->state == IS_ENABLED) && !d->ignores_stop) {
            const bool brakes = d->moving && (d->brakes_for_ms > 0U);
            scripted_drive_stop(d, d->quick_stop_stays ? IS_QUICK_STOP : IS_DISABLED);
            d->moving = brakes;
            d->braking_ms = d->brakes_for_ms;
            d->bits &= (uint16_t)~0x0400U;
        }
    } else if ((command == 0x06U) && (d->state != IS_QUICK_STOP)) {
        scripted_drive_stop(d, IS_READY);
    } else if ((command == 0x07U) && (d->state != IS_DISABLED)) {
        d->state = IS_ON;
    } else if ((command == 0x0FU) && ((d->state == IS_ON) || (d->state == IS_ENABLED))) {
        d->unused = (d->state == IS_ON) ? d->acknowledges_enabling : d->unused;
        d->bits |= d->unused ? 0x1000U : 0U;
        d->state = d->stays_in_switched_on ? IS_ON : IS_ENABLED;
    }
}

static int32_t scripted_drive_way(const scripted_drive_t *d)
{
    int32_t way = d->goal - d->actual;
    if (d->wrap != 0) {
        way = (way > (d->wrap / 2)) ? (way - d->wrap) : (way < -(d->wrap / 2)) ? (way + d->wrap) : way;
    }
    return way;
}

/* So that any move takes move_ms. */
static int32_t scripted_drive_speed(const scripted_drive_t *d)
{
    const int32_t way = scripted_drive_way(d);
    const int32_t ms = (int32_t)d->move_ms;
    return (ms == 0) ? 0 : ((((way < 0) ? -way : way) / ms) + 1);
}

static void scripted_drive_position_mode(scripted_drive_t *d, uint16_t before)
{
    const bool rises = ((d->control & 0x10U) != 0U) && ((before & 0x10U) == 0U);
    if (rises && (d->unused || ((d->bits & 0x1000U) == 0U)) && !d->never_acknowledges) {
        d->goal = d->target; /* what 607Ah is now */
        d->counts_per_ms = scripted_drive_speed(d);
        d->moving = true;
        d->bits = (uint16_t)(d->unused ? (d->bits & ~0x1000U) : (d->bits | 0x1000U));
        d->unused = false;
        d->bits &= d->reached_lingers ? 0xFFFFU : (uint16_t)~0x0400U;
    } else if (((d->control & 0x10U) == 0U) && !d->keeps_acknowledging && !d->unused) {
        d->bits &= (uint16_t)~0x1000U;
    }
}

static void scripted_drive_home(scripted_drive_t *d)
{
    const unsigned most_ms = (d->move_ms != 0U) ? d->move_ms : SCRIPTED_HOMING_MS;
    d->homing_ms++;
    d->actual += d->homing_turns;
    if (d->homing_never_ends || d->jammed || (d->homing_ms < most_ms)) {
        return;
    }
    d->homing = false;
    d->actual = d->homing_fails ? d->actual : d->home;
    d->bits = d->homing_fails ? 0x2400 : 0x1400;
    scripted_drive_report(d);
}

static void scripted_drive_homing_mode(scripted_drive_t *d, uint16_t before)
{
    if (((d->control & 0x10U) != 0U) && ((before & 0x10U) == 0U)) {
        d->homing = true;
        d->homing_ms = 0;
        d->reports = 0;
        if (d->homes_at_once) {
            d->homing_ms = UINT16_MAX;
            scripted_drive_home(d);
        }
    }
}

static void scripted_drive_move(scripted_drive_t *d)
{
    const int32_t way = scripted_drive_way(d);
    const int32_t speed = (d->counts_per_ms != 0) ? d->counts_per_ms : SCRIPTED_COUNTS_PER_MS;
    const int32_t most = d->jammed ? 0 : speed;
    const int32_t up = (way > most) ? most : way;
    const int32_t step = (up < -most) ? -most : up;
    d->actual += step;
    d->braking_ms -= (d->braking_ms > 0U) ? 1U : 0U;
    if (((d->state == IS_QUICK_STOP) || ((d->control & 0x0100U) != 0U)) && (d->braking_ms == 0U)) {
        d->moving = false;
        d->bits |= d->hides_standstill ? 0U : 0x0400U;
        scripted_drive_report(d);
        return;
    }
    if (d->wrap != 0) {
        d->actual = (d->actual + d->wrap) % d->wrap;
    }
    if ((step == way) && !d->never_reaches) {
        d->moving = false;
        d->bits |= 0x0400U;
        scripted_drive_report(d);
    }
}

/* What it hears and says. */

void scripted_drive_send(scripted_drive_t *d, uint16_t id, uint8_t length, const uint8_t *data)
{
    const tumble_can_frame_t frame = fake_frame(id, length, data);
    fake_port_give(d->fake, &frame);
}

/* The first of what its master does against the standard is kept. */
static void scripted_drive_expect(scripted_drive_t *d, bool right, const char *wrong)
{
    if (!right && (d->wrong == NULL)) {
        d->wrong = wrong;
    }
}

static uint32_t scripted_drive_value(const scripted_drive_t *d, uint32_t object)
{
    switch (object >> 16) {
    case 0x6040:
        return d->control;
    case 0x6041:
        return (uint32_t)d->state | d->bits | 0x0210U;
    case 0x6064:
        return (uint32_t)(d->frozen ? d->shown : d->actual);
    case 0x6061:
        return (uint8_t)d->mode_display;
    case 0x607A:
        return (uint32_t)d->target;
    case 0x607C:
        return (uint32_t)(d->negates_offset ? -d->home : d->home);
    default:
        return 0x5A5A5A5AU;
    }
}

void scripted_drive_report(scripted_drive_t *d)
{
    if (d->homing && (d->reports++ >= d->old_reports)) {
        d->bits &= (uint16_t)~0x3400U;
    }
    for (unsigned n = 0; n < 4U; n++) {
        const scripted_pdo_t *pdo = &d->transmit[n];
        if ((n == 1U) && (d->second_ms != 0U) && ((d->clock_ms % d->second_ms) != 0U)) {
            continue;
        }
        if (((pdo->cob_id & 0x80000000U) != 0U) || (pdo->count == 0U) || !d->operational) {
            continue;
        }
        uint8_t data[8] = {0};
        uint8_t length = 0;
        for (unsigned i = 0; i < pdo->count; i++) {
            const uint32_t value = scripted_drive_value(d, pdo->map[i]);
            for (unsigned byte = 0; byte < ((pdo->map[i] & 0xFFU) / 8U); byte++) {
                data[length++] = (uint8_t)(value >> (8U * byte));
            }
        }
        scripted_drive_send(d, (uint16_t)(pdo->cob_id & 0x7FFU), length, data);
    }
}

void scripted_drive_beat(scripted_drive_t *d, uint8_t state)
{
    scripted_drive_send(d, 0x700U + SCRIPTED_DRIVE_NODE, 1, &state);
}

void scripted_drive_emergency(scripted_drive_t *d, uint16_t code)
{
    const uint8_t data[8] = {(uint8_t)code, (uint8_t)(code >> 8), 0x21};
    scripted_drive_send(d, 0x080U + SCRIPTED_DRIVE_NODE, 8, data);
}

void scripted_drive_boot(scripted_drive_t *d, fake_port_t *fake)
{
    d->fake = fake;
    d->dead = false;
    d->clock_ms = fake->now_us / 1000U;
    d->operational = false;
    d->stopped = false;
    d->heard_ms = d->clock_ms;
    d->state = IS_DISABLED;
    d->bits = 0;
    d->mode = 0;
    d->mode_display = 0;
    d->control = 0;
    d->moving = false;
    d->homing = false;
    for (unsigned n = 0; (n < 4U) && !d->fixed_pdos; n++) {
        d->receive[n] = (scripted_pdo_t){.cob_id = 0x80000000U};
        d->transmit[n] = (scripted_pdo_t){.cob_id = 0x80000000U};
    }
    scripted_drive_beat(d, 0);
}

void scripted_drive_fail(scripted_drive_t *d, fake_port_t *fake, uint16_t code)
{
    d->fake = fake;
    d->state = IS_FAULT;
    d->moving = false;
    d->homing = false;
    if (code != 0U) {
        scripted_drive_emergency(d, code);
    }
    scripted_drive_report(d);
}

/* A PDO parameter, under the rules of CiA 301: an enabled PDO is not remapped, a mapping in use not changed. */
static bool scripted_drive_map(scripted_drive_t *d, uint16_t index, uint8_t subindex, uint32_t value)
{
    scripted_pdo_t *pdo = (index >= 0x1800U) ? &d->transmit[index & 3U] : &d->receive[index & 3U];
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

static bool is_of_motion(uint16_t index)
{
    return (index >= 0x6081U) && (index <= 0x609AU);
}

/* Where an object of its motions is kept; null: it is none. */
static scripted_write_t *scripted_drive_kept(scripted_drive_t *d, uint16_t index, uint8_t subindex)
{
    unsigned i = 0;
    while ((i < 7U) && (d->kept[i].index != 0U) && ((d->kept[i].index != index) || (d->kept[i].subindex != subindex))) {
        i++;
    }
    return is_of_motion(index) ? &d->kept[i] : NULL;
}

static void scripted_drive_write(scripted_drive_t *d, const scripted_write_t *write)
{
    d->writes[d->write_count % SCRIPTED_WRITES] = *write;
    d->write_count++;
    scripted_write_t *kept = scripted_drive_kept(d, write->index, write->subindex);
    if ((kept != NULL) && !d->keeps_nothing) {
        *kept = *write;
    }
    if ((write->index >= 0x1400U) && (write->index < 0x1C00U)) {
        const bool in_order = scripted_drive_map(d, write->index, write->subindex, write->value);
        scripted_drive_expect(d, in_order, "PDO written in a wrong order");
    } else if (write->index == 0x1017U) {
        d->mute = d->mute && d->stays_mute;
    } else if (write->index == 0x6040U) {
        const uint16_t before = d->control;
        d->control = (uint16_t)write->value;
        scripted_drive_power(d, before);
        scripted_drive_report(d);
    } else if (write->index == 0x607DU) {
        d->limits[write->subindex - 1U] = d->keeps_no_limits ? 0 : (int32_t)write->value;
    } else if (write->index == 0x6060U) {
        scripted_drive_expect(d, write->subindex == 0U, "6060h has no subindices");
        scripted_drive_expect(d, (d->control & 0x0100U) == 0U, "mode changed while Halt is set");
        d->mode = (int8_t)write->value;
        d->mode_display = d->mode_sticks ? d->mode_display : d->mode;
        d->bits = (d->attained_from_before && (d->mode == 6)) ? 0x1400 : (uint16_t)(d->bits & 0x0400U);
        d->bits |= (d->unused && (d->mode == 1)) ? 0x1000U : 0U;
        scripted_drive_report(d);
    }
}

void scripted_drive_change(scripted_drive_t *d, uint16_t index, uint8_t subindex, uint32_t value)
{
    scripted_write_t *kept = scripted_drive_kept(d, index, subindex);
    scripted_drive_expect(d, kept != NULL, "not an object of its motions");
    if (kept != NULL) {
        *kept = (scripted_write_t){index, subindex, 4, value};
    }
}

static bool is_pdo(uint16_t index)
{
    return (index >= 0x1400U) && (index < 0x1C00U);
}

static uint32_t scripted_drive_read(scripted_drive_t *d, uint16_t index, uint8_t subindex)
{
    const scripted_write_t *kept = scripted_drive_kept(d, index, subindex);
    if (kept != NULL) {
        return kept->value;
    }
    if (index == 0x607DU) {
        return (uint32_t)d->limits[subindex - 1U];
    }
    if (!is_pdo(index)) {
        return scripted_drive_value(d, (uint32_t)index << 16);
    }
    const scripted_pdo_t *pdo = (index >= 0x1800U) ? &d->transmit[index & 3U] : &d->receive[index & 3U];
    const uint32_t mapped = (subindex == 0U) ? pdo->count : pdo->map[(subindex - 1U) & 7U];
    return ((index & 0x0200U) != 0U) ? mapped : pdo->cob_id;
}

static unsigned scripted_drive_size(uint16_t index, uint8_t subindex)
{
    const bool is_long = ((index >= 0x607AU) && (index <= 0x607DU)) || (index == 0x6064U) || is_of_motion(index);
    const bool is_word = (index == 0x6040U) || (index == 0x6041U);
    return (is_long || (is_pdo(index) && (subindex != 0U))) ? 4U : (is_word ? 2U : 1U);
}

static void scripted_drive_sdo(scripted_drive_t *d, const tumble_can_frame_t *frame)
{
    const uint8_t *r = frame->data;
    const uint16_t index = (uint16_t)(r[1] | (r[2] << 8));
    uint8_t answer[8] = {0x60, r[1], r[2], r[3]};
    if (d->sdo_is_deaf || (r[0] == 0x80U)) {
        return;
    }
    const bool fixed = d->fixed_pdos && is_pdo(index) && ((r[0] & 0xE0U) == 0x20U);
    if ((index == d->refuse_index) || fixed) {
        d->refusals++;
        const uint8_t abort[8] = {0x80, r[1], r[2], r[3], 0x00, 0x00, 0x02, 0x06};
        scripted_drive_send(d, 0x580U + SCRIPTED_DRIVE_NODE, 8, abort);
        return;
    }
    if ((r[0] & 0xE0U) == 0x20U) {
        const uint32_t value = (uint32_t)r[4] | ((uint32_t)r[5] << 8) | ((uint32_t)r[6] << 16) | ((uint32_t)r[7] << 24);
        const scripted_write_t write = {index, r[3], (uint8_t)(4U - ((r[0] >> 2) & 3U)), value};
        scripted_drive_send(d, 0x580U + SCRIPTED_DRIVE_NODE, 8, answer);
        scripted_drive_write(d, &write);
    } else {
        const bool has_subindices = (index == 0x607DU) || (index == 0x6099U) || is_pdo(index);
        scripted_drive_expect(d, (r[3] == 0U) || has_subindices, "what is read has no subindices");
        const uint32_t value = scripted_drive_read(d, index, r[3]);
        const unsigned size = scripted_drive_size(index, r[3]);
        answer[0] = (uint8_t)(0x43U | ((4U - size) << 2U));
        for (unsigned byte = 0; byte < size; byte++) {
            answer[4U + byte] = (uint8_t)(value >> (8U * byte));
        }
        scripted_drive_send(d, 0x580U + SCRIPTED_DRIVE_NODE, 8, answer);
    }
}

/* Told again it goes on braking. */
static void scripted_drive_halt(scripted_drive_t *d, uint16_t before)
{
    d->braking_ms = ((before & 0x0100U) == 0U) ? d->brakes_for_ms : d->braking_ms;
    if (!d->ignores_stop && (d->brakes_for_ms == 0U)) {
        d->moving = false;
        d->bits |= 0x0400U;
    }
}

static void scripted_drive_control(scripted_drive_t *d, const tumble_can_frame_t *frame, const scripted_pdo_t *pdo)
{
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
    d->controls[d->control_count % SCRIPTED_CONTROLS] = (scripted_control_t){d->control, d->target};
    d->control_count++;
    scripted_drive_power(d, before);
    if (d->state == IS_ENABLED) {
        if ((d->control & 0x0100U) != 0U) {
            scripted_drive_halt(d, before);
        } else if (d->mode == 1) {
            scripted_drive_position_mode(d, before);
        } else if (d->mode == 6) {
            scripted_drive_homing_mode(d, before);
        }
    }
    scripted_drive_report(d);
}

static uint8_t scripted_drive_nmt_state(const scripted_drive_t *d)
{
    return d->operational ? 5U : (d->stopped ? 4U : 127U);
}

void scripted_drive_hear(scripted_drive_t *d, fake_port_t *fake, const tumble_can_frame_t *frame)
{
    d->fake = fake;
    if (d->dead) {
        return;
    }
    if (frame->id == (0x700U + SCRIPTED_MASTER_NODE)) {
        d->heard_ms = d->clock_ms;
    }
    if (frame->id == 0U) {
        if ((frame->data[1] == SCRIPTED_DRIVE_NODE) || (frame->data[1] == 0U)) {
            d->operational = (frame->data[0] == 1U);
            d->stopped = (frame->data[0] == 2U);
            d->nmt_starts += d->operational ? 1U : 0U;
            d->nmt_stops += d->stopped ? 1U : 0U;
            if (!d->operational && !d->ignores_nmt) {
                scripted_drive_stop(d, IS_FAULT);
            }
            scripted_drive_beat(d, scripted_drive_nmt_state(d));
            scripted_drive_report(d);
        }
    } else if (frame->id == (0x600U + SCRIPTED_DRIVE_NODE)) {
        if (!d->stopped) {
            scripted_drive_sdo(d, frame);
        }
    } else {
        for (unsigned n = 0; n < 4U; n++) {
            if (d->operational && (d->receive[n].cob_id == frame->id)) {
                scripted_drive_control(d, frame, &d->receive[n]);
            }
        }
    }
}

static uint64_t scripted_drive_period_ms(const scripted_drive_t *d)
{
    return (d->report_ms != 0U) ? d->report_ms : SCRIPTED_REPORT_MS;
}

static void scripted_drive_tick(scripted_drive_t *d)
{
    d->clock_ms++;
    if (!d->mute && ((d->clock_ms % SCRIPTED_HEARTBEAT_MS) == 0U)) {
        scripted_drive_beat(d, scripted_drive_nmt_state(d));
    }
    const uint64_t silent_ms = d->clock_ms - d->heard_ms;
    d->silent_ms = (silent_ms > d->silent_ms) ? silent_ms : d->silent_ms;
    if ((d->watches_ms != 0U) && (silent_ms > d->watches_ms)) {
        scripted_drive_stop(d, IS_FAULT);
    }
    if (d->moving) {
        scripted_drive_move(d);
    }
    if (d->homing) {
        scripted_drive_home(d);
    }
    const bool second = (d->second_ms != 0U) && ((d->clock_ms % d->second_ms) == 0U);
    if (second || (!d->event_only && ((d->clock_ms % scripted_drive_period_ms(d)) == 0U))) {
        scripted_drive_report(d);
    }
}

void scripted_drive_step(scripted_drive_t *d, fake_port_t *fake)
{
    const uint64_t now_ms = fake->now_us / 1000U;
    d->fake = fake;
    d->clock_ms = d->dead ? now_ms : d->clock_ms;
    while (d->clock_ms < now_ms) {
        scripted_drive_tick(d);
    }
}

uint64_t scripted_drive_next_us(const scripted_drive_t *d)
{
    const bool turns = scripted_drive_moves(d) && !d->jammed;
    const bool reports = d->operational && !d->event_only;
    const uint64_t period_ms = turns ? 1U : (reports ? scripted_drive_period_ms(d) : SCRIPTED_HEARTBEAT_MS);
    return d->dead ? UINT64_MAX : ((d->clock_ms / period_ms + 1U) * period_ms * 1000U);
}

void scripted_drive_init(scripted_drive_t *d, fake_port_t *fake)
{
    *d = (scripted_drive_t){.actual = 12345, .move_ms = 200, .report_ms = 20};
    scripted_drive_boot(d, fake);
}
