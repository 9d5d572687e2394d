/* procedure_internal.h - what the files of the procedure share (private to it).
 *
 *     procedure.c          time, samples and commands; the engine that follows the table of states
 *     procedure_states.c   the states: what each does, the table, what goes wrong
 *     procedure_checks.c   is the configuration usable, is the block mounted as it should be, did it slip
 *     procedure_report.c   the readable side, and what a run that lost power had measured
 */
#ifndef TUMBLE_PROCEDURE_PROCEDURE_INTERNAL_H
#define TUMBLE_PROCEDURE_PROCEDURE_INTERNAL_H

#include "core/count.h"
#include "procedure/procedure.h"
#include "stand/bounds.h"

#define TUMBLE_NOT_MOUNTED UINT8_MAX

/* What a state has come to. */
typedef enum {
    OUTCOME_STAY = 0,
    OUTCOME_DONE,  /* on to the row's `done` */
    OUTCOME_OTHER, /* on to the row's `other` */
    OUTCOME_FAULT  /* on to FAULT; the reason is noted */
} outcome_t;

/* tumble_row_t.watch: what makes a fault while the state lasts. */
enum {
    WATCH_BUS = 1,
    WATCH_STAND = 2,
    WATCH_BLOCK = 4,     /* its heartbeat */
    WATCH_SAMPLES = 8,   /* and its samples keep coming */
    WATCH_ANGLE = 16,    /* the table stands where the position is measured */
    WATCH_POSITION = 32, /* the stand stays in position, and few frames are corrupted: else the position is refused */
    WATCH_ALL = 63
};

/* tumble_row_t.commands */
enum { COMMAND_START = 1, COMMAND_ABORT = 2, COMMAND_CONFIRM = 4, COMMAND_RESUME = 8, COMMAND_REPEAT = 16 };

typedef outcome_t (*tumble_action_t)(tumble_procedure_t *procedure);
typedef outcome_t (*tumble_sample_action_t)(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
                                            tumble_taken_t *taken);

typedef struct {
    tumble_action_t enter;         /* once, on the way in; may lead on at once */
    tumble_action_t poll;          /* whenever time or a sample comes */
    tumble_sample_action_t sample; /* for every sample */
    tumble_action_t late;          /* at the timeout, when one reason for all is not enough; else null */
    uint8_t timeout;               /* where its timeout stands in the configuration; 0: waits for nothing */
    uint8_t late_reason;
    uint8_t done;
    uint8_t other;
    uint8_t watch;
    uint8_t commands;
    bool pauses; /* its work waits for the next step, so that no step does two such works */
} tumble_row_t;

extern const tumble_row_t tumble_procedure_rows[TUMBLE_STATE_COUNT];

/* Note why, and OUTCOME_FAULT. */
outcome_t tumble_fail(tumble_procedure_t *procedure, tumble_reason_t reason);

/* The reason behind the stand's fault. */
tumble_reason_t tumble_stand_reason(const tumble_procedure_t *procedure);

/* Before the first position of a run: nothing is measured. Returns as tumble_averaging_init. */
tumble_status_t tumble_begin_averaging(tumble_procedure_t *procedure);

/* Has the position a mean? */
bool tumble_is_measured(const tumble_procedure_t *procedure, uint8_t index);

/* Index of the mounting that the position at `index` belongs to. */
uint8_t tumble_mounting_index(const tumble_schedule_t *schedule, uint8_t index);

/* First position of a mounting (TUMBLE_NOT_MOUNTED: of any) without a mean; position_count if there is none. */
uint8_t tumble_first_unmeasured(const tumble_procedure_t *procedure, uint8_t mounting_index);

/* Drop the mean of a position, and with it what was concluded from it. */
void tumble_forget_position(tumble_procedure_t *procedure, uint8_t index);

/* The position is refused with this status: another attempt (OUTCOME_OTHER) if that may help and one is left. */
outcome_t tumble_refuse_position(tumble_procedure_t *procedure, tumble_status_t status);

/* The mean of a position over the nominal scale of each channel: specific force plus bias, in g. */
void tumble_seen_g(const tumble_procedure_t *procedure, uint8_t index, double seen[TUMBLE_CHANNELS]);

/* Does gravity in the mean of the position point where it should?
 * Returns TUMBLE_REASON_NONE, TUMBLE_REASON_WRONG_MOUNTING, TUMBLE_REASON_SWAPPED_CHANNELS or TUMBLE_REASON_SLIP. */
tumble_reason_t tumble_check_direction(const tumble_procedure_t *procedure, uint8_t index);

/* Does the mounting of the position close, if it is complete?
 * Returns TUMBLE_REASON_NONE, or TUMBLE_REASON_SLIP when the closure is too large. */
tumble_reason_t tumble_check_closure(const tumble_procedure_t *procedure, uint8_t index);

/* The table angle for a scheduled one: itself, or a whole number of turns off so that it and the way up to it lie
 * within the cable's limits. False: there is none. */
bool tumble_choose_turn(const tumble_procedure_config_t *config, double scheduled_deg, double *angle_deg);

#endif
