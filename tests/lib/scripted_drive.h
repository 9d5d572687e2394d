/* scripted_drive.h - a CiA 402 drive as a script, at the other end of a fake port: the drive of all C tests that need one.
 *
 * It is written from the standard, not from our drive402 nor from the simulated drive: it answers SDO, learns its PDO
 * mappings from what it is told, and keeps a CiA 402 state. Its bad habits are fields; without them it behaves. It
 * lives by the millisecond: `scripted_drive_step` makes up for what has passed, and `scripted_drive_next_us` says when
 * something happens next.
 */
#ifndef TUMBLE_TESTS_SCRIPTED_DRIVE_H
#define TUMBLE_TESTS_SCRIPTED_DRIVE_H

#include "fake_port.h"

#include <stdbool.h>
#include <stdint.h>

#define SCRIPTED_MASTER_NODE 1U
#define SCRIPTED_DRIVE_NODE 2U
#define SCRIPTED_COUNTS_PER_REVOLUTION 360000
#define SCRIPTED_COUNTS_PER_MS 100
#define SCRIPTED_HOMING_MS 30U
#define SCRIPTED_HEARTBEAT_MS 100U
#define SCRIPTED_REPORT_MS 10U
#define SCRIPTED_WRITES 256U
#define SCRIPTED_CONTROLS 2048U

/* The 402 states as their statusword has them. */
enum {
    IS_DISABLED = 0x40, /* switch on disabled */
    IS_READY = 0x21,
    IS_ON = 0x23,
    IS_ENABLED = 0x27,
    IS_QUICK_STOP = 0x07,
    IS_FAULT_REACTION = 0x0F,
    IS_FAULT = 0x08
};

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint32_t value;
} scripted_write_t;

typedef struct {
    uint32_t cob_id;
    uint8_t count;
    uint32_t map[8];
} scripted_pdo_t;

typedef struct {
    uint16_t control;
    int32_t target; /* 607Ah when this controlword came */
} scripted_control_t;

typedef struct {
    fake_port_t *fake; /* where it speaks */
    const char *wrong; /* what its master did against CiA 301 or 402 first; null: nothing */
    uint64_t clock_ms;
    scripted_pdo_t receive[4];
    scripted_pdo_t transmit[4];
    scripted_write_t writes[SCRIPTED_WRITES];
    unsigned write_count;
    scripted_write_t kept[8];                       /* 6081h to 609Ah, as they are now */
    scripted_control_t controls[SCRIPTED_CONTROLS]; /* the last receive PDOs */
    unsigned control_count;
    uint16_t control;
    uint16_t state;
    uint16_t bits; /* of the mode: 10, 12, 13 */
    int8_t mode;
    int8_t mode_display;
    int32_t target;
    int32_t goal;
    int32_t counts_per_ms; /* of this move; 0: the usual */
    int32_t actual;
    bool dead; /* hears and says nothing */
    bool operational;
    bool stopped;         /* in the NMT state of that name */
    int32_t limits[2];    /* 607Dh */
    bool keeps_no_limits; /* takes 607Dh and forgets it */
    bool keeps_nothing;   /* likewise what its motions depend on */
    bool moving;
    bool homing;
    unsigned homing_ms;
    unsigned reports;    /* transmit PDOs since the start of homing */
    unsigned braking_ms; /* left until it stands */
    unsigned nmt_starts; /* commands to it */
    unsigned refusals;   /* of SDO requests */
    bool coasted;        /* it lost its power while it moved */

    /* Habits. */
    unsigned move_ms;      /* homing and any move take so long; 0: they are as fast as usual */
    bool jammed;           /* sets out and never arrives */
    int32_t wrap;          /* positions count modulo this, the shorter way is taken; 0: no */
    uint16_t refuse_index; /* SDO abort 0602 0000h */
    bool sdo_is_deaf;
    bool mute;        /* sends no heartbeat until 1017h is written, */
    bool stays_mute;  /* or not even then */
    unsigned misses;  /* so many of the next process data */
    bool mode_sticks; /* 6061h never follows */
    bool never_acknowledges;
    bool keeps_acknowledging;
    bool never_reaches;
    bool reached_lingers; /* bit 10 stays set while it moves */
    bool stays_in_switched_on;
    bool resets_nothing;
    bool homing_fails;
    bool homing_never_ends;
    bool attained_from_before; /* bits 12 and 10 still tell of the last homing when homing begins */
    unsigned old_reports;      /* they stay in so many transmit PDOs after its start */
    bool quick_stop_stays;     /* in quick stop active, option code 6 */
    unsigned brakes_for_ms;    /* in quick stop active or under Halt */
    bool hides_standstill;     /* no bit 10 after a stop */
    bool ignores_stop;
    bool ignores_nmt;     /* goes on when it is taken out of operation */
    unsigned watches_ms;  /* stops when the master is silent for so long; 0: never */
    uint64_t heard_ms;    /* when it heard the master last */
    uint64_t silent_ms;   /* the longest that the master has been silent */
    unsigned nmt_stops;   /* commands to it */
    int32_t homing_turns; /* counts per ms while it homes */
    int32_t home;         /* where homing ends, 607Ch, */
    bool negates_offset;  /* or minus that */
    bool frozen;          /* its reports show this position, whatever the axis does */
    int32_t shown;
    unsigned report_ms;         /* from one transmit PDO to the next; 0: the usual */
    bool event_only;            /* transmit PDOs on change only */
    unsigned second_ms;         /* the second transmit PDO comes by a timer of its own alone; 0: with the first */
    bool homes_at_once;         /* it stands at its mark: bit 12 is never seen clear */
    bool fixed_pdos;            /* they are what they are, and a write is refused */
    bool acknowledges_enabling; /* bit 12 is set from Operation enabled on, and its first set-point clears it */
    bool unused;                /* there was none yet */
} scripted_drive_t;

/* At rest somewhere; homing and any move take 0.2 s, reports come every 20 ms. */
void scripted_drive_init(scripted_drive_t *d, fake_port_t *fake);
void scripted_drive_boot(scripted_drive_t *d, fake_port_t *fake);
void scripted_drive_hear(scripted_drive_t *d, fake_port_t *fake, const tumble_can_frame_t *frame);
void scripted_drive_step(scripted_drive_t *d, fake_port_t *fake);
uint64_t scripted_drive_next_us(const scripted_drive_t *d);

/* A fault of its own: the axis stops, an emergency message tells the code unless that is 0. */
void scripted_drive_fail(scripted_drive_t *d, fake_port_t *fake, uint16_t code);

static inline bool scripted_drive_moves(const scripted_drive_t *d)
{
    return d->moving || d->homing;
}

static inline double scripted_drive_angle_deg(const scripted_drive_t *d)
{
    return (double)d->actual * 360.0 / SCRIPTED_COUNTS_PER_REVOLUTION;
}

/* Out of turn, where it spoke last. */
void scripted_drive_send(scripted_drive_t *d, uint16_t id, uint8_t length, const uint8_t *data);
void scripted_drive_report(scripted_drive_t *d);
void scripted_drive_beat(scripted_drive_t *d, uint8_t state);
void scripted_drive_emergency(scripted_drive_t *d, uint16_t code);

/* A stranger writes anew what the master has written of its motions, 6081h to 609Ah. */
void scripted_drive_change(scripted_drive_t *d, uint16_t index, uint8_t subindex, uint32_t value);

#endif
