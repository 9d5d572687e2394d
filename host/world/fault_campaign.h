/* fault_campaign.h - the fault campaign (docs/architecture.md): runs drawn from a seed, with faults, checked against the
 * simulation's truth.
 *
 * The plan of a run is drawn by tumble/world/fault_campaign.py, which also sets the keys of the world, its faults among
 * them. The navigation computer with its memory goes through the plan on the simulated bus, and may lose its power. Only
 * its memory survives that: what was being erased or programmed holds any bytes, bits elsewhere may flip, and the firmware
 * boots from what is there, while the rest of the world goes on. The rules are judged by the simulation's truth and not by
 * what the firmware says; docs/architecture.md has the rule behind each violation, and what each excuse excuses and for
 * how long.
 */
#ifndef TUMBLE_WORLD_FAULT_CAMPAIGN_H
#define TUMBLE_WORLD_FAULT_CAMPAIGN_H

#include "world/border.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Random numbers: of the stream `index` of a seed, SIM_CAUSE_CAMPAIGN; every part of a plan has its own, so that one draw
 * more in one shifts nothing in the others. */
typedef struct {
    uint64_t s[4];
} campaign_stream_t;

void campaign_stream_open(campaign_stream_t *stream, uint64_t seed, uint32_t index);
uint64_t campaign_stream_next(campaign_stream_t *stream);

/* What may happen: faults, commands, power cuts, frames of a stranger. */
typedef enum {
    CAMPAIGN_EVENT_FAULT = 0, /* a key of the world */
    CAMPAIGN_EVENT_COMMAND,
    CAMPAIGN_EVENT_POWER_CUT,
    CAMPAIGN_EVENT_SDO_NAVCOMP,
    CAMPAIGN_EVENT_SDO_DRIVE,
    CAMPAIGN_EVENT_SDO_ANSWER,
    CAMPAIGN_EVENT_SET_POINT,
    CAMPAIGN_EVENT_SDO_SET_POINT,
    CAMPAIGN_EVENT_POSITION,
    CAMPAIGN_EVENT_NEAR_POSITION,
    CAMPAIGN_EVENT_SAMPLE,
    CAMPAIGN_EVENT_SPOILT_SAMPLE,
    CAMPAIGN_EVENT_NMT,
    CAMPAIGN_EVENT_HEARTBEAT,
    CAMPAIGN_EVENT_EMERGENCY,
    CAMPAIGN_EVENT_SYNC,
    CAMPAIGN_EVENT_LSS,
    CAMPAIGN_EVENT_ANY_FRAME
} campaign_event_kind_t;

/* Its moment is a time, or the first one from that time on at which the firmware is in one of these states or the
 * memory is at work, and then some more. */
typedef struct {
    campaign_event_kind_t kind;
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
} campaign_event_t;

#define CAMPAIGN_MOST_EVENTS 300

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
} campaign_plan_t;

typedef enum {
    CAMPAIGN_VIOLATION_NONE = 0,
    CAMPAIGN_VIOLATION_REST,     /* the table still turns 6 s after the end */
    CAMPAIGN_VIOLATION_STAYS,    /* the table at rest moves without a command */
    CAMPAIGN_VIOLATION_CABLE,    /* the table goes beyond the cable's limits */
    CAMPAIGN_VIOLATION_HOMING,   /* homing goes farther than the cable's span and a turn */
    CAMPAIGN_VIOLATION_SPEED,    /* the table turns for 1 s faster than it was told to */
    CAMPAIGN_VIOLATION_FOREIGN,  /* a stranger's motion is not stopped within 1 s */
    CAMPAIGN_VIOLATION_REASON,   /* FAULT or ABORT without a reason */
    CAMPAIGN_VIOLATION_FINITE,   /* a readable object is not a finite number */
    CAMPAIGN_VIOLATION_TRUTH,    /* a set that became active by itself is off by more than 6 u */
    CAMPAIGN_VIOLATION_LOST,     /* the active set is lost */
    CAMPAIGN_VIOLATION_COUNTER,  /* the calibration counter went back, and nothing was told */
    CAMPAIGN_VIOLATION_PROPOSAL, /* a proposal is lost that nobody has decided about */
    CAMPAIGN_VIOLATION_DECAYED,  /* a record or mark with a flipped bit counts as valid */
    CAMPAIGN_VIOLATION_MEAN,     /* a mean is not of its own samples, as many as are configured */
    CAMPAIGN_VIOLATION_LEVEL,    /* the service level is open, or was not asked for, without its key */
    CAMPAIGN_VIOLATION_RUN,      /* the run number does not count the runs */
    CAMPAIGN_VIOLATION_BENCH     /* the bench cannot go on */
} campaign_violation_t;

typedef enum {
    CAMPAIGN_EXCUSE_COMMANDED = 0,
    CAMPAIGN_EXCUSE_REWRITTEN,
    CAMPAIGN_EXCUSE_STEP,    /* fault `step`: a bias changes within a run */
    CAMPAIGN_EXCUSE_SLIP,    /* fault `slip`, below what closure and position tolerance see */
    CAMPAIGN_EXCUSE_SHORT,   /* fault `never_reached`, by less than the position tolerance */
    CAMPAIGN_EXCUSE_CHANNEL, /* faults `swapped`, `inverted`: for a while, where outputs are alike or small */
    CAMPAIGN_EXCUSE_SAMPLE,  /* a forged sample with a good checksum */
    CAMPAIGN_EXCUSE_RULES,   /* an accepted write to 2050h or 2122h to 2126h */
    CAMPAIGN_EXCUSE_FLIPPED
} campaign_excuse_t;

#define CAMPAIGN_FAULTS 33
#define CAMPAIGN_EVENTS 18
#define CAMPAIGN_STATES 15
#define CAMPAIGN_REASONS 36

/* What a run has come to: the first violation, and what is counted for the summary. */
typedef struct {
    campaign_violation_t kind;
    uint64_t at_us;
    double value;  /* degrees, uncertainties, or a number of that kind */
    uint32_t what; /* object, coefficient, state: by kind */

    uint32_t excuses; /* bit per campaign_excuse_t */
    uint32_t faults[CAMPAIGN_FAULTS];
    uint32_t events[CAMPAIGN_EVENTS];
    uint32_t ends[CAMPAIGN_STATES][CAMPAIGN_REASONS]; /* DONE, FAULT and ABORT, by reason */
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
} campaign_found_t;

/* To the end of the plan, or to the first violation. `events`: at most CAMPAIGN_MOST_EVENTS, in the order of their times,
 * without faults. Returns what keeps the world from being powered on, a sentence as those of border.h. */
const char *campaign_execute(world_t *world, uint64_t seed, const campaign_plan_t *plan, const campaign_event_t *events,
                             size_t count, campaign_found_t *found);

/* Names of closed lists, by number; null beyond their ends. */
typedef enum {
    CAMPAIGN_NAMES_OF_FAULTS = 0,
    CAMPAIGN_NAMES_OF_STATES,
    CAMPAIGN_NAMES_OF_REASONS,
    CAMPAIGN_NAMES_OF_COMMANDS
} campaign_names_t;

const char *campaign_name(campaign_names_t of, uint32_t number);

#endif
