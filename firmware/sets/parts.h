/* parts.h - what the files of the life share (private to the room).
 *
 *     life.c         init, the step: what is done when the memory is free, commands
 *     judge.c        from a result to a verdict
 *     kept_run.c     the run under way, and its checkpoint
 *     active.c       what the active set is, and has one decayed?
 *     resume.c       going on after a loss of power
 *     report.c       settings and the readable side
 *     due.c          calendar, inhibit, when a run is due
 *     board_rules.c  are the rules the board's?
 *     work.c         what all of them need
 *
 * A file calls those below it only.
 */
#ifndef TUMBLE_SETS_PARTS_H
#define TUMBLE_SETS_PARTS_H

#include "core/count.h"
#include "tumble/sets.h"

#define TUMBLE_US_PER_S UINT64_C(1000000)

/* tumble_sets_t.task */
enum {
    TASK_NONE = 0,
    TASK_UNCERTAINTY,     /* of the result; `at`: coefficient */
    TASK_NORM,            /* that of |a|: is the limit met at every attitude? */
    TASK_FIT,             /* does the run fit the declared stand, mounting by mounting? */
    TASK_WHOLE_MODEL,     /* and as a whole? */
    TASK_COMPARE_SETS,    /* is the result one of the sets that the store holds? `at`: which */
    TASK_COMPARE_HISTORY, /* or of those it held? `at`: age */
    TASK_DECIDE,
    TASK_RESTORE /* take the means out of the checkpoint; `at`: position */
};

/* tumble_sets_t.trying: what the checkpoint is doing besides keeping a position. */
enum { TRYING_NOTHING = 0, TRYING_TO_BEGIN = UINT8_MAX - 1, TRYING_TO_CLEAR = UINT8_MAX };
static_assert(TUMBLE_MAX_POSITIONS < TRYING_TO_BEGIN, "what is tried is one byte");

/* tumble_sets_t.wants */
enum {
    WANT_ACCEPT = 1,
    WANT_DISCARD = 2,
    WANT_ROLLBACK = 4,
    WANT_COMMANDS = WANT_ACCEPT | WANT_DISCARD | WANT_ROLLBACK,
    WANT_BEGIN = 8,        /* a new checkpoint */
    WANT_CLEAR = 16,       /* none */
    WANT_APPEND = 32,      /* there is a mean that is not in it */
    WANT_RECORD_DECAY = 64 /* in the history */
};

/* Characters of the block's serial number, counted up to one more than it may have. */
static inline uint8_t tumble_serial_length(const tumble_sets_config_t *config)
{
    uint8_t length = 0;
    while ((length <= TUMBLE_SET_SERIAL_BYTES) && (config->serial[length] != '\0')) {
        length++;
    }
    return length;
}

/* active.c */
void tumble_sets_refresh(tumble_sets_t *sets);           /* read the active set; look whether one has decayed */
void tumble_sets_try_history_again(tumble_sets_t *sets); /* its entry was refused */
void tumble_sets_record_decay(tumble_sets_t *sets);      /* in the history: at most two reads, one job */

/* judge.c */
void tumble_sets_judge(tumble_sets_t *sets); /* go on with it: one call of the memory, or a part of a computation */

/* Is a result being judged whose means must stay as they are? For some 100 ms after DONE, and a thousand steps more. */
static inline bool tumble_sets_is_assessing(const tumble_sets_t *sets)
{
    return (sets->task >= (uint8_t)TASK_UNCERTAINTY) && (sets->task <= (uint8_t)TASK_WHOLE_MODEL);
}

/* kept_run.c */
void tumble_sets_keep(tumble_sets_t *sets); /* begin, append or clear: at most one job */
tumble_status_t tumble_sets_step_checkpoint(tumble_sets_t *sets);
void tumble_sets_end_checkpoint(tumble_sets_t *sets); /* its run is stored; unless the next has begun */

/* resume.c */
uint32_t tumble_sets_fingerprint(const tumble_sets_t *sets); /* of all that must not change in a run */
uint8_t tumble_sets_positions(const tumble_sets_t *sets);    /* in its schedule */
void tumble_sets_count_resumable(tumble_sets_t *sets);
void tumble_sets_restore(tumble_sets_t *sets, tumble_sets_event_t *event); /* go on with it: one call of the memory */

/* report.c */
bool tumble_sets_settings_valid(const tumble_sets_settings_t *settings);

/* due.c */
uint64_t tumble_sets_whole_s(uint64_t us);
uint64_t tumble_sets_utc_s(const tumble_sets_t *sets);
uint64_t tumble_sets_age_s(const tumble_sets_t *sets);
bool tumble_sets_is_ahead(const tumble_sets_t *sets, uint64_t date_utc_s, uint64_t slack_s); /* of the present */
uint8_t tumble_sets_due(const tumble_sets_t *sets);
bool tumble_sets_is_inhibited(const tumble_sets_t *sets);

/* board_rules.c */
uint32_t tumble_sets_rules(const tumble_sets_t *sets);          /* fingerprint of those in force */
uint32_t tumble_sets_rules_of_board(const tumble_sets_t *sets); /* of its constants: with nothing saved */
bool tumble_sets_rules_are_other(const tumble_sets_t *sets);    /* than after the next power-on */
uint16_t tumble_sets_rules_flag(const tumble_sets_t *sets);     /* of a set that becomes active now, or is held */

/* work.c */
uint64_t tumble_sets_bit(uint8_t position);           /* of a position, in words that have one bit for each */
void tumble_sets_forget_margins(tumble_sets_t *sets); /* of the run's temperatures: there was none yet */
void tumble_sets_fail(tumble_sets_t *sets, tumble_status_t status); /* count a failure of the memory */
void tumble_sets_begin_job(tumble_sets_t *sets, uint8_t job, tumble_status_t status);

#endif
