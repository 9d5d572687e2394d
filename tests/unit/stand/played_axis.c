#include "played_drive.h"

played_drive_t played;
fake_port_t port;
unsigned clock_ms;

void played_stop(uint16_t state)
{
    played.moving = false;
    played.homing = false;
    played.state = state;
}

void played_power(uint16_t before)
{
    played_drive_t *d = &played;
    const unsigned command = d->control & 0x8FU;
    const bool reset = ((command & 0x80U) != 0U) && ((before & 0x80U) == 0U);
    if ((d->state == IS_FAULT) || (d->state == IS_FAULT_REACTION)) {
        d->state = (reset && !d->resets_nothing) ? IS_DISABLED : d->state;
    } else if ((command & 0x02U) == 0U) {
        d->coasted = d->coasted || d->moving;
        played_stop(IS_DISABLED);
    } else if ((command & 0x06U) == 0x02U) {
        if ((d->state == IS_ENABLED) && !d->ignores_stop) {
            const bool brakes = d->moving && (d->brakes_for_ms > 0U);
            played_stop(d->quick_stop_stays ? IS_QUICK_STOP : IS_DISABLED);
            d->moving = brakes;
            d->braking_ms = d->brakes_for_ms;
            d->bits &= (uint16_t)~0x0400U;
        }
    } else if ((command == 0x06U) && (d->state != IS_QUICK_STOP)) {
        played_stop(IS_READY);
    } else if ((command == 0x07U) && (d->state != IS_DISABLED)) {
        d->state = IS_ON;
    } else if ((command == 0x0FU) && ((d->state == IS_ON) || (d->state == IS_ENABLED))) {
        d->state = d->stays_in_switched_on ? IS_ON : IS_ENABLED;
    }
}

void played_position_mode(uint16_t before)
{
    played_drive_t *d = &played;
    const bool rises = ((d->control & 0x10U) != 0U) && ((before & 0x10U) == 0U);
    if (rises && ((d->bits & 0x1000U) == 0U) && !d->never_acknowledges) {
        d->goal = d->target; /* what 607Ah is now */
        d->moving = true;
        d->bits |= 0x1000U;
        d->bits &= d->reached_lingers ? 0xFFFFU : (uint16_t)~0x0400U;
    } else if (((d->control & 0x10U) == 0U) && !d->keeps_acknowledging) {
        d->bits &= (uint16_t)~0x1000U;
    }
}

void played_homing_mode(uint16_t before)
{
    played_drive_t *d = &played;
    if (((d->control & 0x10U) != 0U) && ((before & 0x10U) == 0U)) {
        d->homing = true;
        d->homing_ms = 0;
        d->reports = 0;
    }
}

static int32_t played_way(void)
{
    const played_drive_t *d = &played;
    int32_t way = d->goal - d->actual;
    if (d->wrap != 0) {
        way = (way > (d->wrap / 2)) ? (way - d->wrap) : (way < -(d->wrap / 2)) ? (way + d->wrap) : way;
    }
    return way;
}

void played_move(void)
{
    played_drive_t *d = &played;
    const int32_t way = played_way();
    const int32_t up = (way > SPEED_COUNTS_PER_MS) ? SPEED_COUNTS_PER_MS : way;
    const int32_t step = (up < -SPEED_COUNTS_PER_MS) ? -SPEED_COUNTS_PER_MS : up;
    d->actual += step;
    d->braking_ms -= (d->braking_ms > 0U) ? 1U : 0U;
    if (((d->state == IS_QUICK_STOP) || ((d->control & 0x0100U) != 0U)) && (d->braking_ms == 0U)) {
        d->moving = false;
        d->bits |= d->hides_standstill ? 0U : 0x0400U;
        played_transmit();
        return;
    }
    if (d->wrap != 0) {
        d->actual = (d->actual + d->wrap) % d->wrap;
    }
    if ((step == way) && !d->never_reaches) {
        d->moving = false;
        d->bits |= 0x0400U;
        played_transmit();
    }
}

void played_home(void)
{
    played_drive_t *d = &played;
    d->homing_ms++;
    d->actual += d->homing_turns;
    if (d->homing_never_ends || (d->homing_ms < 30U)) {
        return;
    }
    d->homing = false;
    d->actual = d->homing_fails ? d->actual : d->home;
    d->bits = d->homing_fails ? 0x2400 : 0x1400;
    played_transmit();
}
