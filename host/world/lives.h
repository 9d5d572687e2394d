/* lives.h - the fault campaign (docs/architecture.md): what a plan says happens to a world, and the simulation's truth is held
 * against what must hold.
 *
 * The plan is drawn by who holds the world (tumble/world/lives.py), and its keys are set, the faults of the life among
 * them. The navigation computer with its memory lives through it on the simulated bus, and may lose its power: then its
 * memory alone outlives, what was being erased or programmed is left with any bytes, bits elsewhere may flip, and the
 * firmware begins anew on what is there, while the rest of the world goes on. What must hold is judged by the
 * simulation's truth and not by what the firmware says; docs/architecture.md says of each word what must hold, and of each
 * excuse what it excuses and for how long.
 */
#ifndef TUMBLE_WORLD_LIVES_H
#define TUMBLE_WORLD_LIVES_H

#include "world/border.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Random numbers: of the stream `index` of a seed, SIM_CAUSE_LIFE; every part of a plan has its own, so that one draw
 * more in one shifts nothing in the others. */
typedef struct {
    uint64_t s[4];
} life_stream_t;

void lives_open(life_stream_t *stream, uint64_t seed, uint32_t index);
uint64_t lives_random(life_stream_t *stream);

/* What may happen: faults, commands, power cuts, frames of a stranger. */
typedef enum {
    LIFE_EVENT_FAULT = 0, /* a key of the world */
    LIFE_EVENT_COMMAND,
    LIFE_EVENT_POWER_CUT,
    LIFE_EVENT_SDO_NAVCOMP,
    LIFE_EVENT_SDO_DRIVE,
    LIFE_EVENT_SDO_ANSWER,
    LIFE_EVENT_SET_POINT,
    LIFE_EVENT_SDO_SET_POINT,
    LIFE_EVENT_POSITION,
    LIFE_EVENT_NEAR_POSITION,
    LIFE_EVENT_SAMPLE,
    LIFE_EVENT_SPOILT_SAMPLE,
    LIFE_EVENT_NMT,
    LIFE_EVENT_HEARTBEAT,
    LIFE_EVENT_EMERGENCY,
    LIFE_EVENT_SYNC,
    LIFE_EVENT_LSS,
    LIFE_EVENT_ANY_FRAME
} life_kind_t;

/* Its moment is a time, or the first one from that time on at which the firmware is in one of these states or the
 * memory is at work, and then some more. */
typedef struct {
    life_kind_t kind;
    uint32_t number; /* in the list as drawn: names its stream of random numbers */
    uint64_t at_us;
    uint32_t states; /* bit per tumble_state_t; 0: any */
    bool writing;    /* the memory is erasing or programming */
    uint32_t delay_us;
    uint8_t command; /* tumble_command_t */
    uint8_t argument;
    double angle_deg; /* of a turn; of a set-point: where to; of positions: how far each is off the one before */
    bool relative;    /* of a set-point: so far off the drive's present target */
    bool by_host;     /* the command comes from the board itself, not over CAN */
    uint16_t id;      /* of the frame as it is sent, where neither position, set-point nor sample is forged */
    uint8_t length;
    uint8_t data[8];
    uint32_t count;  /* forged positions; flipped bits */
    int32_t counts;  /* added to a forged sample */
    uint32_t off_us; /* without power */
} life_event_t;

#define LIFE_MOST_EVENTS 300

/* `mount_s` to `errs`: who mounts the block, mends faults and switches the power on again. */
typedef struct {
    double mount_s;
    double mend_s;
    uint32_t mends;        /* faults that he mends; then the run stays where it is */
    bool resumes;          /* after a loss of power, else he starts anew */
    bool errs;             /* mounts the block wrongly, once */
    double velocity_deg_s; /* that the drive is told to turn at; 0: its most */
    uint64_t lasts_us;
    uint32_t erase_us;
    uint32_t program_us;
    uint64_t utc_s; /* told at power-on; 0: not */
    bool has_set;   /* the memory holds an active set from the beginning */
} life_plan_t;

typedef enum {
    LIFE_BROKEN_NONE = 0,
    LIFE_BROKEN_REST,     /* the table still turns 6 s after the end */
    LIFE_BROKEN_STAYS,    /* the table at rest moves without a command */
    LIFE_BROKEN_CABLE,    /* the table goes beyond the cable's limits */
    LIFE_BROKEN_HOMING,   /* homing goes farther than the cable's span and a turn */
    LIFE_BROKEN_SPEED,    /* the table turns for 1 s faster than it was told to */
    LIFE_BROKEN_FOREIGN,  /* a stranger's motion is not stopped within 1 s */
    LIFE_BROKEN_REASON,   /* FAULT or ABORT without a reason */
    LIFE_BROKEN_FINITE,   /* a readable object is not a finite number */
    LIFE_BROKEN_TRUTH,    /* a set that became active by itself is off by more than 6 u */
    LIFE_BROKEN_LOST,     /* the active set is lost */
    LIFE_BROKEN_COUNTER,  /* the calibration counter went back, and nothing was told */
    LIFE_BROKEN_PROPOSAL, /* a proposal is lost that nobody has decided about */
    LIFE_BROKEN_DECAYED,  /* a record or mark with a flipped bit counts as valid */
    LIFE_BROKEN_MEAN,     /* a mean is not of its own samples, as many as are configured */
    LIFE_BROKEN_LEVEL,    /* the service level is open, or was not asked for, without its key */
    LIFE_BROKEN_RUN,      /* the run number does not count the runs */
    LIFE_BROKEN_BENCH     /* the bench cannot go on */
} life_broken_t;

typedef enum {
    LIFE_EXCUSE_COMMANDED = 0,
    LIFE_EXCUSE_REWRITTEN,
    LIFE_EXCUSE_STEP,    /* fault `step`: a bias changes within a run */
    LIFE_EXCUSE_SLIP,    /* fault `slip`, below what closure and position tolerance see */
    LIFE_EXCUSE_SHORT,   /* fault `never_reached`, by less than the position tolerance */
    LIFE_EXCUSE_CHANNEL, /* faults `swapped`, `inverted`: for a while, where outputs are alike or small */
    LIFE_EXCUSE_SAMPLE,  /* a forged sample with a good checksum */
    LIFE_EXCUSE_RULES,   /* an accepted write to 2050h or 2122h to 2126h */
    LIFE_EXCUSE_FLIPPED
} life_excuse_t;

#define LIFE_FAULTS 33
#define LIFE_EVENTS 18
#define LIFE_STATES 15
#define LIFE_REASONS 36

/* What a life has come to: the first violation, and what is counted for the summary. */
typedef struct {
    life_broken_t kind;
    uint64_t at_us;
    double value;  /* degrees, uncertainties, or a number of that kind */
    uint32_t what; /* object, coefficient, state: by kind */

    uint32_t excuses; /* bit per life_excuse_t */
    uint32_t faults[LIFE_FAULTS];
    uint32_t events[LIFE_EVENTS];
    uint32_t ends[LIFE_STATES][LIFE_REASONS]; /* DONE, FAULT and ABORT, by reason */
    uint32_t flipped_bits;
    uint32_t committed; /* sets that became active by themselves */
    uint32_t judged;    /* of those, without a cause that excuses them */
    uint32_t held;      /* results that became the proposal */
    uint32_t homings;

    uint64_t virtual_us;
    uint64_t frames;
    uint64_t steps; /* of the firmware */
    bool at_rest;   /* the true table */
    double lowest_deg;
    double highest_deg;
} life_found_t;

/* To the end of the plan, or to the first violation. `events`: at most LIFE_MOST_EVENTS, in the order of their times,
 * without faults. Returns what keeps the world from being powered on, a sentence as those of border.h. */
const char *lives_live(world_t *world, uint64_t seed, const life_plan_t *plan, const life_event_t *events, size_t count,
                       life_found_t *found);

/* Names of closed lists, by number; null beyond their ends. */
typedef enum {
    LIFE_NAMES_OF_FAULTS = 0,
    LIFE_NAMES_OF_STATES,
    LIFE_NAMES_OF_REASONS,
    LIFE_NAMES_OF_COMMANDS
} life_names_t;

const char *lives_name(life_names_t of, uint32_t number);

#endif
