/* keeper_internal.h - what the files of the keeper share (private to it).
 *
 *     keeper.c             init, the step: what is done when the memory is free, commands
 *     keeper_active.c      what the active set is, and what is told when it decays
 *     keeper_judge.c       from a result to a verdict
 *     keeper_rules.c       are the rules the board's?
 *     keeper_checkpoint.c  the run under way, and its checkpoint
 *     keeper_resume.c      fingerprints, going on after a loss of power
 *     keeper_due.c         calendar, inhibit, when a run is due
 *     keeper_report.c      settings and the readable side
 */
#ifndef TUMBLE_NAVCOMP_KEEPER_INTERNAL_H
#define TUMBLE_NAVCOMP_KEEPER_INTERNAL_H

#include "navcomp/keeper.h"

#define TUMBLE_US_PER_S UINT64_C(1000000)

/* tumble_keeper_t.task */
enum {
    TASK_NONE = 0,
    TASK_UNCERTAINTY,     /* of the result; `at`: coefficient */
    TASK_FIT,             /* does the run fit the declared stand? */
    TASK_COMPARE_SETS,    /* is the result one of the sets that the store holds? `at`: which */
    TASK_COMPARE_HISTORY, /* or of those it held? `at`: age */
    TASK_DECIDE,
    TASK_RESTORE          /* take the means out of the checkpoint; `at`: position */
};

/* tumble_keeper_t.job, and what becomes of it in `tumble_verdict_t` when it is done. */
enum {
    JOB_NONE = 0,
    JOB_COMMIT,
    JOB_HOLD,
    JOB_ACCEPT,
    JOB_DISCARD,
    JOB_ROLLBACK
};

/* tumble_keeper_t.trying: what the checkpoint is doing besides keeping a position. */
enum {
    TRYING_NOTHING = 0,
    TRYING_TO_BEGIN = UINT8_MAX - 1,
    TRYING_TO_CLEAR = UINT8_MAX
};
static_assert(TUMBLE_MAX_POSITIONS < TRYING_TO_BEGIN, "what is tried is one byte");

/* tumble_keeper_t.wants */
enum {
    WANT_ACCEPT = 1,
    WANT_DISCARD = 2,
    WANT_ROLLBACK = 4,
    WANT_COMMANDS = WANT_ACCEPT | WANT_DISCARD | WANT_ROLLBACK,
    WANT_BEGIN = 8, /* a new checkpoint */
    WANT_CLEAR = 16, /* none */
    WANT_APPEND = 32, /* there is a mean that is not in it */
    WANT_RECORD_DECAY = 64 /* in the history */
};

/* Characters of the block's serial number, counted up to one more than it may have. */
static inline uint8_t tumble_serial_length(const tumble_keeper_config_t *config)
{
    uint8_t length = 0;
    while ((length <= TUMBLE_SET_SERIAL_BYTES) && (config->serial[length] != '\0')) {
        length++;
    }
    return length;
}

/* keeper.c */
void tumble_keeper_fail(tumble_keeper_t *keeper, tumble_status_t status); /* count a failure of the memory */
bool tumble_keeper_is_busy(const tumble_keeper_t *keeper);                /* store, history or checkpoint */
bool tumble_keeper_has_work(const tumble_keeper_t *keeper);               /* or there is something for them to do */
void tumble_keeper_begin_job(tumble_keeper_t *keeper, uint8_t job, tumble_status_t status);

/* keeper_active.c */
void tumble_keeper_refresh(tumble_keeper_t *keeper);           /* read the active set; look whether one has decayed */
void tumble_keeper_try_history_again(tumble_keeper_t *keeper); /* its entry was refused */
void tumble_keeper_tell_decay(tumble_keeper_t *keeper);        /* by an emergency message */
void tumble_keeper_record_decay(tumble_keeper_t *keeper);      /* in the history: at most two reads, one job */

/* keeper_judge.c */
void tumble_keeper_take_result(tumble_keeper_t *keeper);
void tumble_keeper_judge(tumble_keeper_t *keeper); /* go on with it: one call of the memory, or a part of a computation */

/* Is a result being looked at whose means must stay as they are? Some 100 ms after DONE. */
static inline bool tumble_keeper_is_assessing(const tumble_keeper_t *keeper)
{
    return (keeper->task == (uint8_t)TASK_UNCERTAINTY) || (keeper->task == (uint8_t)TASK_FIT);
}

/* keeper_rules.c */
uint32_t tumble_keeper_rules(const tumble_keeper_t *keeper);          /* fingerprint of those in force */
uint32_t tumble_keeper_rules_of_board(const tumble_keeper_t *keeper); /* of its constants: with nothing saved */
bool tumble_keeper_rules_are_other(const tumble_keeper_t *keeper);    /* than after the next power-on */
void tumble_keeper_note_rules(tumble_keeper_t *keeper);               /* after a step of the parameters */
uint16_t tumble_keeper_rules_flag(const tumble_keeper_t *keeper);     /* of a set that becomes active now, or is held */
tumble_status_t tumble_keeper_accept(tumble_keeper_t *keeper);        /* begin the store's job */

/* keeper_checkpoint.c */
void tumble_keeper_watch(tumble_keeper_t *keeper); /* has a run begun, ended, or lost a position? */
void tumble_keeper_keep(tumble_keeper_t *keeper);  /* begin, append or clear: at most one job */
tumble_status_t tumble_keeper_step_checkpoint(tumble_keeper_t *keeper);
void tumble_keeper_end_checkpoint(tumble_keeper_t *keeper); /* its run is stored; unless the next has begun */

/* keeper_resume.c */
uint32_t tumble_keeper_schedule_crc(const tumble_keeper_t *keeper);
uint32_t tumble_keeper_stand_crc(const tumble_keeper_t *keeper);
uint32_t tumble_keeper_fingerprint(const tumble_keeper_t *keeper); /* of all that must not change in a run */
uint8_t tumble_keeper_positions(const tumble_keeper_t *keeper);    /* in its schedule */
void tumble_keeper_count_resumable(tumble_keeper_t *keeper);
tumble_status_t tumble_keeper_resume(tumble_keeper_t *keeper);
void tumble_keeper_restore(tumble_keeper_t *keeper); /* go on with it: one call of the memory */

/* keeper_due.c */
uint64_t tumble_keeper_utc_s(const tumble_keeper_t *keeper);
uint64_t tumble_keeper_age_s(const tumble_keeper_t *keeper);
bool tumble_keeper_is_ahead(const tumble_keeper_t *keeper, uint64_t date_utc_s, uint64_t slack_s); /* of the present */
uint8_t tumble_keeper_due(const tumble_keeper_t *keeper);
bool tumble_keeper_is_inhibited(const tumble_keeper_t *keeper);
void tumble_keeper_obey_inhibit(tumble_keeper_t *keeper);
void tumble_keeper_pause(tumble_keeper_t *keeper); /* no start by itself for some time from now */
void tumble_keeper_start_if_due(tumble_keeper_t *keeper);
void tumble_keeper_sample(void *keeper, const tumble_block_sample_t *sample, bool averaged);

/* keeper_report.c */
bool tumble_keeper_settings_valid(const tumble_keeper_settings_t *settings);
tumble_status_t tumble_keeper_change(tumble_keeper_t *keeper, const tumble_keeper_settings_t *settings); /* from outside */

#endif
