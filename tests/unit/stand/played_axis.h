/* played_axis.h - the axis of the played drive: power state machine, modes, motion. */
#ifndef TUMBLE_TESTS_UNIT_PLAYED_AXIS_H
#define TUMBLE_TESTS_UNIT_PLAYED_AXIS_H

#include "fake_port.h"
#include "support.h"

#define MASTER_NODE 1U
#define DRIVE_NODE 2U
#define MAX_WRITES 96
#define MAX_CONTROLS 2048
#define SPEED_COUNTS_PER_MS 100

/* The 402 states as their statusword has them. */
enum {
    IS_DISABLED = 0x40, /* switch on disabled */
    IS_READY = 0x21, IS_ON = 0x23, IS_ENABLED = 0x27, IS_QUICK_STOP = 0x07, IS_FAULT_REACTION = 0x0F, IS_FAULT = 0x08
};

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint32_t value;
} sdo_write_t;

typedef struct {
    uint32_t cob_id;
    uint8_t count;
    uint32_t map[8];
} played_pdo_t;

typedef struct {
    uint16_t control;
    int32_t target; /* 607Ah when this controlword came */
} control_t;

typedef struct {
    played_pdo_t receive[4];
    played_pdo_t transmit[4];
    sdo_write_t writes[MAX_WRITES];
    unsigned write_count;
    control_t controls[MAX_CONTROLS]; /* every receive PDO that changed something */
    unsigned control_count;
    uint16_t control;
    uint16_t state;
    uint16_t bits; /* of the mode: 10, 12, 13 */
    int8_t mode;
    int8_t mode_display;
    int32_t target;
    int32_t goal;
    int32_t actual;
    bool powered_up;  /* sends heartbeats, answers */
    bool operational;
    bool stopped;     /* in the NMT state of that name */
    int32_t limits[2]; /* 607Dh */
    bool keeps_no_limits;       /* takes 607Dh and forgets it */
    bool moving;
    bool homing;
    unsigned homing_ms;
    unsigned reports;     /* transmit PDOs since the start of homing */
    unsigned braking_ms;  /* left until it stands */
    unsigned nmt_starts;  /* commands to it */
    unsigned refusals;    /* of SDO requests */
    bool coasted;         /* it lost its power while it moved */

    /* Habits. */
    int32_t wrap;               /* positions count modulo this, the shorter way is taken; 0: no */
    uint16_t refuse_index;      /* SDO abort 0602 0000h */
    bool sdo_is_deaf;
    bool mute;        /* sends no heartbeat until 1017h is written, */
    bool stays_mute;  /* or not even then */
    unsigned misses; /* so many of the next process data */
    bool mode_sticks;           /* 6061h never follows */
    bool never_acknowledges;
    bool keeps_acknowledging;
    bool never_reaches;
    bool reached_lingers;       /* bit 10 stays set while it moves */
    bool stays_in_switched_on;
    bool resets_nothing;
    bool homing_fails;
    bool homing_never_ends;
    bool attained_from_before;  /* bits 12 and 10 still tell of the last homing when homing begins */
    unsigned old_reports;       /* they stay in so many transmit PDOs after its start */
    bool quick_stop_stays;      /* in quick stop active, option code 6 */
    unsigned brakes_for_ms;     /* in quick stop active or under Halt */
    bool hides_standstill;      /* no bit 10 after a stop */
    bool ignores_stop;
    bool ignores_nmt;           /* goes on when it is taken out of operation */
    unsigned watches_ms;        /* stops when the master is silent for so long; 0: never */
    unsigned heard_ms;          /* when it heard the master last */
    unsigned silent_ms;         /* the longest that the master has been silent */
    unsigned nmt_stops;         /* commands to it */
    int32_t homing_turns;       /* counts per ms while it homes */
    int32_t home;               /* where homing ends */
    bool event_only;            /* transmit PDOs on change only */
} played_drive_t;

static played_drive_t played;
static fake_port_t port;
static unsigned clock_ms;

static inline void played_transmit(void);

static inline void played_stop(uint16_t state)
{
    played.moving = false;
    played.homing = false;
    played.state = state;
}

static inline void played_power(uint16_t before)
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

static inline void played_position_mode(uint16_t before)
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

static inline void played_homing_mode(uint16_t before)
{
    played_drive_t *d = &played;
    if (((d->control & 0x10U) != 0U) && ((before & 0x10U) == 0U)) {
        d->homing = true;
        d->homing_ms = 0;
        d->reports = 0;
    }
}

static inline int32_t played_way(void)
{
    const played_drive_t *d = &played;
    int32_t way = d->goal - d->actual;
    if (d->wrap != 0) {
        way = (way > (d->wrap / 2)) ? (way - d->wrap) : (way < -(d->wrap / 2)) ? (way + d->wrap) : way;
    }
    return way;
}

static inline void played_move(void)
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

static inline void played_home(void)
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

#endif
