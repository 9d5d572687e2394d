/* played_drive.h - a CiA 402 drive played frame by frame, at the other end of a fake port.
 *
 * It is written from the standard, not from our drive402 nor from the simulated drive: it answers SDO, learns its PDO
 * mappings from what it is told, and keeps a CiA 402 state. Its bad habits are fields. One a program.
 */
#ifndef TUMBLE_TESTS_UNIT_PLAYED_DRIVE_H
#define TUMBLE_TESTS_UNIT_PLAYED_DRIVE_H

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

extern played_drive_t played;
extern fake_port_t port;
extern unsigned clock_ms;

void played_send(uint16_t id, uint8_t length, const uint8_t *data);
void played_transmit(void);
void played_heartbeat(uint8_t state);
void played_emergency(uint16_t code);
void played_boot(void);
void played_fault(uint16_t code);
void played_receive(const tumble_can_frame_t *frame);
void played_tick(void);

/* Its axis: power state machine, modes, motion (played_axis.c). */
void played_stop(uint16_t state);
void played_power(uint16_t before);
void played_position_mode(uint16_t before);
void played_homing_mode(uint16_t before);
void played_move(void);
void played_home(void);

#endif
