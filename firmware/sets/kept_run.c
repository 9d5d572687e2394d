/* The means of the run under way, and their checkpoint. */
#include "sets/parts.h"

#include "core/one_copy.h"

#include <stddef.h>

/* The run under way. */

void tumble_sets_run_began(tumble_sets_t *sets)
{
    sets->run_was_on = true;
    sets->task = (sets->task == (uint8_t)TASK_RESTORE) ? (uint8_t)TASK_NONE : sets->task;
    if (sets->run->measured == 0U) { /* else a position or a mounting of a run that was done is repeated */
        sets->run_resumed = false;
        sets->warmth_half_c = 0;
        sets->warm_samples = 0;
        tumble_sets_forget_margins(sets);
    }
    sets->saved = 0;
    sets->unfit = 0;
    sets->resumable = 0;
    sets->wants = (uint8_t)((sets->wants & ~(unsigned)WANT_CLEAR) | WANT_BEGIN);
}

/* A mean that was dropped must not come back with the next power-on: write the checkpoint anew without it. */
void tumble_sets_run_measured(tumble_sets_t *sets)
{
    const uint64_t measured = sets->run->measured;
    sets->wants |= ((measured & ~sets->saved) != 0U) ? (unsigned)WANT_APPEND : 0U;
    sets->wants |= ((sets->saved & ~measured) != 0U) ? (unsigned)WANT_BEGIN : 0U;
    if ((sets->wants & WANT_BEGIN) != 0U) {
        sets->saved = 0;
    }
}

/* Clear the checkpoint instead of beginning it or adding to it: neither this run nor the one before shall be
 * resumed. */
static void clear_instead(tumble_sets_t *sets)
{
    sets->wants = (uint8_t)((sets->wants & ~(unsigned)(WANT_BEGIN | WANT_APPEND)) | WANT_CLEAR);
}

void tumble_sets_run_given_up(tumble_sets_t *sets)
{
    sets->run_was_on = false;
    tumble_sets_pause(sets);
    clear_instead(sets);
}

/* As at power-on. */
void tumble_sets_run_forgotten(tumble_sets_t *sets)
{
    sets->run_was_on = false;
    tumble_sets_pause(sets);
    sets->stale = true;
    if ((sets->wants & WANT_BEGIN) != 0U) {
        clear_instead(sets); /* with the means that are gone it would not be what it was wanted for */
    }
}

/* The checkpoint. */

/* The write failed, so there is no checkpoint. Retry after the next position, not at every step: until then all means
 * count as saved. */
TUMBLE_ONE_COPY static void put_off(tumble_sets_t *sets)
{
    sets->has_checkpoint = false;
    sets->trying = TRYING_NOTHING;
    sets->lost = 0;
    sets->saved = sets->run->measured;
}

static void begin_trying(tumble_sets_t *sets, uint8_t job)
{
    sets->tries = (uint8_t)(((sets->trying == job) ? sets->tries : 0U) + 1U);
    sets->trying = job;
}

static void begin(tumble_sets_t *sets)
{
    sets->wants &= (uint8_t)~(unsigned)WANT_BEGIN;
    sets->saved = 0;
    sets->lost = 0;
    sets->has_checkpoint = false;
    begin_trying(sets, TRYING_TO_BEGIN);
    sets->fingerprint = tumble_sets_fingerprint(sets); /* now: what the run before has left is stored */
    (void)tumble_checkpoint_begin(&sets->checkpoint, sets->fingerprint);
}

/* The bit of the mean that is under way; 0: none is. */
static uint64_t tried_mean(const tumble_sets_t *sets)
{
    const bool mean = (sets->trying != (uint8_t)TRYING_NOTHING) && (sets->trying <= (uint8_t)TUMBLE_MAX_POSITIONS);
    return mean ? tumble_sets_bit((uint8_t)(sets->trying - 1U)) : 0U;
}

/* What the memory would not take before it may take now. */
static void end_well(tumble_sets_t *sets)
{
    sets->has_checkpoint = true;
    if (tried_mean(sets) != 0U) {
        tumble_count(&sets->counters.checkpoints);
        sets->saved &= ~sets->lost;
        sets->wants |= (sets->lost != 0U) ? (unsigned)WANT_APPEND : 0U;
        sets->lost = 0;
    }
    sets->trying = TRYING_NOTHING;
}

/* Should the failed job of the checkpoint be retried? A mean, only while there is a checkpoint: the failure may have
 * cost all of it. A clear, in any case: what is left of the run before must not be resumed, and a record that cannot be
 * read now may be readable at the next power-on. */
static bool is_to_be_tried(const tumble_sets_t *sets)
{
    bool to_be_tried = sets->checkpoint.kept && sets->has_checkpoint;
    if (sets->trying == (uint8_t)TRYING_TO_CLEAR) {
        to_be_tried = true;
    } else if (sets->trying == (uint8_t)TRYING_TO_BEGIN) {
        to_be_tried = sets->run_was_on && (sets->tries < TUMBLE_SETS_TRIES);
    } else {
        /* a mean */
    }
    return to_be_tried;
}

static void try_again(tumble_sets_t *sets)
{
    const bool again = sets->tries < TUMBLE_SETS_TRIES;
    const uint64_t mean = tried_mean(sets);
    if (!again) {
        sets->lost |= mean;
        sets->trying = TRYING_NOTHING;
    } else if (mean != 0U) {
        sets->saved &= ~mean;
        sets->wants |= WANT_APPEND;
    } else if (sets->trying == (uint8_t)TRYING_TO_CLEAR) {
        tumble_sets_end_checkpoint(sets);
    } else if (sets->trying == (uint8_t)TRYING_TO_BEGIN) {
        sets->wants |= WANT_BEGIN;
    } else {
        /* it looked what is there */
    }
}

tumble_status_t tumble_sets_step_checkpoint(tumble_sets_t *sets)
{
    const tumble_status_t status = tumble_checkpoint_step(&sets->checkpoint);
    if (status == TUMBLE_OK) {
        end_well(sets);
    } else if (status == TUMBLE_E_PORT_BUSY) {
        /* it goes on */
    } else if (is_to_be_tried(sets)) {
        try_again(sets);
    } else {
        put_off(sets);
    }
    return status;
}

static void append(tumble_sets_t *sets)
{
    const uint64_t missing = sets->run->measured & ~sets->saved;
    uint8_t p = 0;
    while ((p < tumble_sets_positions(sets)) && ((missing & tumble_sets_bit(p)) == 0U)) {
        p++;
    }
    if (p == tumble_sets_positions(sets)) {
        sets->wants &= (uint8_t)~(unsigned)WANT_APPEND;
        return;
    }
    if (!sets->has_checkpoint) {
        sets->wants |= WANT_BEGIN;
        return;
    }
    const tumble_status_t status = tumble_checkpoint_append(&sets->checkpoint, p, &sets->run->averaging->averages[p]);
    if (status == TUMBLE_E_FULL) {
        sets->wants |= WANT_BEGIN; /* of what was measured again only the last remains */
        return;
    }
    sets->saved |= tumble_sets_bit(p);
    if (status == TUMBLE_OK) {
        begin_trying(sets, (uint8_t)(p + 1U));
    } else {
        tumble_sets_fail(sets, status);
    }
}

void tumble_sets_end_checkpoint(tumble_sets_t *sets)
{
    sets->wants |= sets->run_was_on ? 0U : (unsigned)WANT_CLEAR;
}

/* Called while the memory is at rest: a job is always taken then, and its steps tell how it ends. */
void tumble_sets_keep(tumble_sets_t *sets)
{
    if ((sets->wants & WANT_BEGIN) != 0U) {
        begin(sets);
    } else if ((sets->wants & WANT_CLEAR) != 0U) {
        sets->wants &= (uint8_t)~(unsigned)(WANT_CLEAR | WANT_APPEND);
        sets->resumable = 0;
        begin_trying(sets, TRYING_TO_CLEAR);
        (void)tumble_checkpoint_clear(&sets->checkpoint);
    } else if ((sets->wants & WANT_APPEND) != 0U) {
        append(sets);
    } else {
        /* nothing to do */
    }
}
