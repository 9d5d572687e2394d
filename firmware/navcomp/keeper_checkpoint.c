/* The run under way, and its checkpoint. */
#include "navcomp/keeper_internal.h"
#include "navcomp/navcomp_internal.h"

#include <stddef.h>

/* The run under way. */

static bool is_saved(const tumble_keeper_t *keeper, uint8_t index)
{
    return (keeper->saved & (UINT64_C(1) << index)) != 0U;
}

/* A position or a mounting of a run that was DONE is repeated: it is that run still. */
static bool goes_on(const tumble_keeper_t *keeper)
{
    bool measured = false;
    for (uint8_t p = 0; p < tumble_keeper_positions(keeper); p++) {
        measured = measured || tumble_procedure_has_mean(&keeper->navcomp->procedure, p);
    }
    return measured;
}

static void begin_run(tumble_keeper_t *keeper)
{
    keeper->task = (keeper->task == (uint8_t)TASK_RESTORE) ? (uint8_t)TASK_NONE : keeper->task;
    (void)tumble_at_rest_begin(&keeper->at_rest, 0);
    if (!goes_on(keeper)) {
        keeper->run_resumed = false;
        keeper->warmth_half_c = 0;
        keeper->warm_samples = 0;
    }
    keeper->saved = 0;
    keeper->unfit = 0;
    keeper->resumable = 0;
    keeper->wants = (uint8_t)((keeper->wants & ~(unsigned)WANT_CLEAR) | WANT_BEGIN);
}

/* None is to be begun or added to: what is there, of this run or the one before, is no run to go on with. */
static void clear_instead(tumble_keeper_t *keeper)
{
    keeper->wants = (uint8_t)((keeper->wants & ~(unsigned)(WANT_BEGIN | WANT_APPEND)) | WANT_CLEAR);
}

static void end_run(tumble_keeper_t *keeper)
{
    const tumble_state_t state = tumble_run_state(keeper->navcomp);
    tumble_keeper_pause(keeper);
    if (state == TUMBLE_STATE_DONE) {
        tumble_keeper_take_result(keeper);
    } else if (state == TUMBLE_STATE_ABORT) {
        clear_instead(keeper);
    } else {
        keeper->stale = true; /* IDLE: the application was reset, as at power-on */
        if ((keeper->wants & WANT_BEGIN) != 0U) {
            clear_instead(keeper); /* with the means that are gone it would not be what it was wanted for */
        }
    }
}

/* A mean that is gone must not come back with the next power-on: the checkpoint is written anew without it. */
static void look_at_means(tumble_keeper_t *keeper)
{
    for (uint8_t p = 0; p < tumble_keeper_positions(keeper); p++) {
        const bool measured = tumble_procedure_has_mean(&keeper->navcomp->procedure, p);
        if (measured && !is_saved(keeper, p)) {
            keeper->wants |= WANT_APPEND;
        }
        if (!measured && is_saved(keeper, p)) {
            keeper->wants |= WANT_BEGIN;
        }
    }
    if ((keeper->wants & WANT_BEGIN) != 0U) {
        keeper->saved = 0;
    }
}

void tumble_keeper_watch(tumble_keeper_t *keeper)
{
    const bool on = tumble_run_is_on(keeper->navcomp);
    if (on && !keeper->run_was_on) {
        begin_run(keeper);
    }
    if (!on && keeper->run_was_on) {
        end_run(keeper);
    }
    keeper->run_was_on = on;
    if (on) {
        look_at_means(keeper);
    }
}

/* The checkpoint. */

/* There is none, for it could not be written. All that is measured so far counts as saved, so that the next mean is what
 * it is tried again for, and not the next step. */
static void put_off(tumble_keeper_t *keeper)
{
    keeper->has_checkpoint = false;
    keeper->trying = TRYING_NOTHING;
    keeper->lost = 0;
    keeper->saved = 0;
    for (uint8_t p = 0; p < tumble_keeper_positions(keeper); p++) {
        const bool measured = tumble_procedure_has_mean(&keeper->navcomp->procedure, p);
        keeper->saved |= (measured ? UINT64_C(1) : UINT64_C(0)) << p;
    }
}

static void begin_trying(tumble_keeper_t *keeper, uint8_t job)
{
    keeper->tries = (uint8_t)(((keeper->trying == job) ? keeper->tries : 0U) + 1U);
    keeper->trying = job;
}

static tumble_status_t begin(tumble_keeper_t *keeper)
{
    keeper->wants &= (uint8_t)~(unsigned)WANT_BEGIN;
    keeper->saved = 0;
    keeper->lost = 0;
    keeper->has_checkpoint = false;
    begin_trying(keeper, TRYING_TO_BEGIN);
    keeper->fingerprint = tumble_keeper_fingerprint(keeper); /* now: what the run before has left is stored */
    const tumble_status_t status = tumble_checkpoint_begin(&keeper->checkpoint, keeper->fingerprint);
    if (status != TUMBLE_OK) {
        put_off(keeper);
    }
    return status;
}

/* The bit of the mean that is under way; 0: none is. */
static uint64_t tried_mean(const tumble_keeper_t *keeper)
{
    const bool mean = (keeper->trying != (uint8_t)TRYING_NOTHING) && (keeper->trying <= (uint8_t)TUMBLE_MAX_POSITIONS);
    return mean ? (UINT64_C(1) << (keeper->trying - 1U)) : 0U;
}

/* What the memory would not take before it may take now. */
static void end_well(tumble_keeper_t *keeper)
{
    keeper->has_checkpoint = true;
    if (tried_mean(keeper) != 0U) {
        tumble_count(&keeper->counters.checkpoints);
        keeper->saved &= ~keeper->lost;
        keeper->wants |= (keeper->lost != 0U) ? (unsigned)WANT_APPEND : 0U;
        keeper->lost = 0;
    }
    keeper->trying = TRYING_NOTHING;
}

/* Is there anything to be tried? A failure may cost all of it, and what is left of the run before must go: it is no run
 * to go on with, and one that cannot be read now may be there at the next power-on. */
static bool is_to_be_tried(const tumble_keeper_t *keeper)
{
    bool to_be_tried = keeper->checkpoint.kept && keeper->has_checkpoint;
    if (keeper->trying == (uint8_t)TRYING_TO_CLEAR) {
        to_be_tried = true;
    } else if (keeper->trying == (uint8_t)TRYING_TO_BEGIN) {
        to_be_tried = keeper->run_was_on && (keeper->tries < TUMBLE_KEEPER_TRIES);
    } else {
        /* a mean */
    }
    return to_be_tried;
}

static void try_again(tumble_keeper_t *keeper)
{
    const bool again = keeper->tries < TUMBLE_KEEPER_TRIES;
    const uint64_t mean = tried_mean(keeper);
    if (!again) {
        keeper->lost |= mean;
        keeper->trying = TRYING_NOTHING;
    } else if (mean != 0U) {
        keeper->saved &= ~mean;
        keeper->wants |= WANT_APPEND;
    } else if (keeper->trying == (uint8_t)TRYING_TO_CLEAR) {
        tumble_keeper_end_checkpoint(keeper);
    } else if (keeper->trying == (uint8_t)TRYING_TO_BEGIN) {
        keeper->wants |= WANT_BEGIN;
    } else {
        /* it looked what is there */
    }
}

tumble_status_t tumble_keeper_step_checkpoint(tumble_keeper_t *keeper)
{
    const tumble_status_t status = tumble_checkpoint_step(&keeper->checkpoint);
    if (status == TUMBLE_OK) {
        end_well(keeper);
    } else if (status == TUMBLE_E_PORT_BUSY) {
        /* it goes on */
    } else if (is_to_be_tried(keeper)) {
        try_again(keeper);
    } else {
        put_off(keeper);
    }
    return status;
}

static void append(tumble_keeper_t *keeper)
{
    const tumble_averaging_t *averages = tumble_procedure_averages(&keeper->navcomp->procedure);
    uint8_t p = 0;
    while ((p < tumble_keeper_positions(keeper)) &&
           (is_saved(keeper, p) || !tumble_procedure_has_mean(&keeper->navcomp->procedure, p))) {
        p++;
    }
    if (p == tumble_keeper_positions(keeper)) {
        keeper->wants &= (uint8_t)~(unsigned)WANT_APPEND;
        return;
    }
    if (!keeper->has_checkpoint) {
        keeper->wants |= WANT_BEGIN;
        return;
    }
    const tumble_status_t status = tumble_checkpoint_append(&keeper->checkpoint, p, &averages->averages[p]);
    if (status == TUMBLE_E_FULL) {
        keeper->wants |= WANT_BEGIN; /* of what was measured again only the last remains */
        return;
    }
    keeper->saved |= UINT64_C(1) << p;
    if (status == TUMBLE_OK) {
        begin_trying(keeper, (uint8_t)(p + 1U));
    } else {
        tumble_keeper_fail(keeper, status);
    }
}

void tumble_keeper_end_checkpoint(tumble_keeper_t *keeper)
{
    keeper->wants |= keeper->run_was_on ? 0U : (unsigned)WANT_CLEAR;
}

void tumble_keeper_keep(tumble_keeper_t *keeper)
{
    tumble_status_t status = TUMBLE_OK;
    if ((keeper->wants & WANT_BEGIN) != 0U) {
        status = begin(keeper);
    } else if ((keeper->wants & WANT_CLEAR) != 0U) {
        keeper->wants &= (uint8_t)~(unsigned)(WANT_CLEAR | WANT_APPEND);
        keeper->resumable = 0;
        begin_trying(keeper, TRYING_TO_CLEAR);
        status = tumble_checkpoint_clear(&keeper->checkpoint);
    } else if ((keeper->wants & WANT_APPEND) != 0U) {
        append(keeper);
    } else {
        /* nothing to do */
    }
    if (status != TUMBLE_OK) {
        tumble_keeper_fail(keeper, status);
    }
}
