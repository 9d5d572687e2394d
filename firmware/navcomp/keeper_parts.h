/* keeper_parts.h - what the files of the keeper share (private to navcomp).
 *
 *     keeper.c          init, the step, commands, settings, calendar, inhibit; when a run is due; are the rules the board's?
 *     keeper_values.c   the readable side, and the objects
 *     keeper_run.c      the run under way, the verdict on its result, its checkpoint
 *
 * A file calls those below it, and keeper.c to count a failure or to begin a job of the store.
 */
#ifndef TUMBLE_NAVCOMP_KEEPER_PARTS_H
#define TUMBLE_NAVCOMP_KEEPER_PARTS_H

#include "navcomp/keeper.h"
#include "navcomp/navcomp_internal.h"

#define TUMBLE_US_PER_S UINT64_C(1000000)

/* tumble_keeper_t.task */
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

/* tumble_keeper_t.trying: what the checkpoint is doing besides keeping a position. */
enum { TRYING_NOTHING = 0, TRYING_TO_BEGIN = UINT8_MAX - 1, TRYING_TO_CLEAR = UINT8_MAX };
static_assert(TUMBLE_MAX_POSITIONS < TRYING_TO_BEGIN, "what is tried is one byte");

/* tumble_keeper_t.wants */
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

static inline const tumble_schedule_t *tumble_keeper_schedule(const tumble_keeper_t *keeper)
{
    return keeper->navcomp->procedure_config.schedule;
}

static inline const tumble_average_t *tumble_keeper_averages(const tumble_keeper_t *keeper)
{
    return tumble_procedure_averages(&keeper->navcomp->procedure)->averages;
}

static inline bool tumble_keeper_is_idle(const tumble_keeper_t *keeper)
{
    return tumble_run_state(keeper->navcomp) == TUMBLE_STATE_IDLE;
}

/* keeper.c */
void tumble_keeper_fail(tumble_keeper_t *keeper, tumble_status_t status); /* count a failure of the memory */
void tumble_keeper_begin_job(tumble_keeper_t *keeper, uint8_t job, tumble_status_t status);

/* keeper_run.c */
void tumble_keeper_judge(
    tumble_keeper_t *keeper); /* go on with it: one call of the memory, or a part of a computation */

/* Is a result being judged whose means must stay as they are? For some 100 ms after DONE, and a thousand steps more. */
static inline bool tumble_keeper_is_assessing(const tumble_keeper_t *keeper)
{
    return (keeper->task >= (uint8_t)TASK_UNCERTAINTY) && (keeper->task <= (uint8_t)TASK_WHOLE_MODEL);
}

void tumble_keeper_follow_run(tumble_keeper_t *keeper); /* what has happened to it since it was looked at before? */
void tumble_keeper_keep_run(tumble_keeper_t *keeper);   /* begin, append or clear the checkpoint: at most one job */
tumble_status_t tumble_keeper_step_checkpoint(tumble_keeper_t *keeper);
void tumble_keeper_end_checkpoint(tumble_keeper_t *keeper); /* its run is stored; unless the next has begun */
void tumble_keeper_count_resumable(tumble_keeper_t *keeper);
tumble_status_t tumble_keeper_resume(tumble_keeper_t *keeper);
void tumble_keeper_restore(tumble_keeper_t *keeper); /* go on with it: one call of the memory */

/* keeper.c: when a run is due */
uint64_t tumble_keeper_whole_s(uint64_t us);
uint64_t tumble_keeper_utc_s(const tumble_keeper_t *keeper);
uint64_t tumble_keeper_age_s(const tumble_keeper_t *keeper);
bool tumble_keeper_is_ahead(const tumble_keeper_t *keeper, uint64_t date_utc_s, uint64_t slack_s); /* of the present */
uint8_t tumble_keeper_due(const tumble_keeper_t *keeper);
bool tumble_keeper_is_inhibited(const tumble_keeper_t *keeper);
void tumble_keeper_pause(tumble_keeper_t *keeper); /* no start by itself: somebody is at work at the table */

/* Fingerprints of the rules in force, and of those of the board's constants: with nothing saved. */
uint32_t tumble_keeper_rules(const tumble_keeper_t *keeper);
uint32_t tumble_keeper_rules_of_board(const tumble_keeper_t *keeper);
bool tumble_keeper_rules_are_other(const tumble_keeper_t *keeper); /* than after the next power-on */
uint16_t tumble_keeper_rules_flag(const tumble_keeper_t *keeper);  /* of a set that becomes active now, or is held */

/* fingerprint.c: of the stand, what is declared of it, and how it is turned; and of a run, all that must not change in it. */
uint32_t tumble_stand_fingerprint(const tumble_navcomp_t *navcomp);
uint32_t tumble_run_fingerprint(const tumble_navcomp_t *navcomp, const char *serial, uint32_t sequence);

/* Characters of the block's serial number, counted up to one more than it may have. */
uint32_t tumble_serial_length(const char *serial);

#endif
