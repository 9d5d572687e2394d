#include "scripted_drive.h"

void scripted_drive_stop(scripted_drive_t *d, uint16_t state)
{
    d->moving = false;
    d->homing = false;
    d->state = state;
}

void scripted_drive_power(scripted_drive_t *d, uint16_t before)
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

void scripted_drive_position_mode(scripted_drive_t *d, uint16_t before)
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

void scripted_drive_homing_mode(scripted_drive_t *d, uint16_t before)
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

void scripted_drive_move(scripted_drive_t *d)
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

void scripted_drive_home(scripted_drive_t *d)
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
