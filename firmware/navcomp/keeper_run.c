/* The run under way: what happens to it, its checkpoint, and how it goes on after a loss of power. */
#include "navcomp/keeper_parts.h"

#include "core/one_copy.h"

#include <stddef.h>

static_assert(TUMBLE_MAX_POSITIONS <= 64, "a position is one bit of 64");

/* A shift of 64 bits is six instructions on 32. */
TUMBLE_ONE_COPY static uint64_t bit_of(uint8_t position)
{
    return UINT64_C(1) << position;
}

static uint8_t positions_of(const tumble_keeper_t *keeper)
{
    return tumble_keeper_schedule(keeper)->position_count;
}

TUMBLE_ONE_COPY static uint64_t measured_positions(const tumble_keeper_t *keeper)
{
    uint64_t measured = 0;
    for (uint8_t p = 0; p < positions_of(keeper); p++) {
        measured |= tumble_procedure_has_mean(&keeper->navcomp->procedure, p) ? bit_of(p) : 0U;
    }
    return measured;
}

/* Of all that must not change in it: with the sequence of the active set, so that the checkpoint of a run that ended in a
 * commit is not resumed. */
static uint32_t fingerprint_of(const tumble_keeper_t *keeper)
{
    return tumble_run_fingerprint(keeper->navcomp, keeper->config->sets.serial, tumble_store_sequence(&keeper->store));
}

static void forget_temperatures(tumble_keeper_t *keeper)
{
    keeper->warmth_half_c = 0;
    keeper->warm_samples = 0;
}

/* What happens to it. */

/* Samples received, less so many for each that went wrong. It falls below where it stood as soon as the share of those is
 * too large. The counters stop at their ends after more than a year of samples: then it says nothing any more. */
static uint32_t balance(const tumble_navcomp_t *navcomp)
{
    const tumble_procedure_counters_t *run = &navcomp->procedure.counters;
    const tumble_block_counters_t *block = &navcomp->block.counters;
    const uint32_t wrong = run->corrupted + run->lost + block->repeated + block->reordered +
                           tumble_stand_report(&navcomp->stand)->stop.implausible;
    return run->samples - (TUMBLE_KEEPER_DISTURBED_ONE_IN * wrong);
}

/* A repetition of some positions leaves standing what was found of the others. */
static void begin_part(tumble_keeper_t *keeper, bool is_disturbed)
{
    keeper->disturbed = is_disturbed;
    keeper->undisturbed = balance(keeper->navcomp);
    (void)tumble_at_rest_begin(&keeper->at_rest, 0);
}

static void begin_run(tumble_keeper_t *keeper)
{
    const bool repeats = (measured_positions(keeper) != 0U); /* a part of a run that was done */
    begin_part(keeper, keeper->disturbed && repeats);
    keeper->run_was_on = true;
    keeper->task = (keeper->task == (uint8_t)TASK_RESTORE) ? (uint8_t)TASK_NONE : keeper->task;
    if (!repeats) {
        keeper->run_resumed = false;
        forget_temperatures(keeper);
        keeper->checkpoint.margins = (tumble_margins_t){UINT8_MAX, UINT8_MAX};
    }
    keeper->saved = 0;
    keeper->unfit = 0;
    keeper->resumable = 0;
    keeper->wants = (uint8_t)((keeper->wants & ~(unsigned)WANT_CLEAR) | WANT_BEGIN);
}

/* Clear the checkpoint instead of beginning it or adding to it: neither this run nor the one before shall be
 * resumed. */
static void clear_instead(tumble_keeper_t *keeper)
{
    keeper->wants = (uint8_t)((keeper->wants & ~(unsigned)(WANT_BEGIN | WANT_APPEND)) | WANT_CLEAR);
}

/* It is done; or a reset has made it forgotten, as at power-on; or it was given up. */
static void end_run(tumble_keeper_t *keeper)
{
    tumble_result_t result;
    keeper->run_was_on = false;
    tumble_keeper_pause(keeper);
    if (tumble_navcomp_result(keeper->navcomp, &result) == TUMBLE_OK) {
        keeper->disturbed =
            keeper->disturbed || ((balance(keeper->navcomp) - keeper->undisturbed) > (uint32_t)INT32_MAX);
        tumble_keeper_run_done(keeper, &result);
    } else if (!tumble_keeper_is_idle(keeper)) {
        clear_instead(keeper);
    } else {
        keeper->stale = true;
        if ((keeper->wants & WANT_BEGIN) != 0U) {
            clear_instead(keeper); /* with the means that are gone it would not be what it was wanted for */
        }
    }
}

/* A mean that was dropped must not come back with the next power-on: write the checkpoint anew without it. */
static void look_at_means(tumble_keeper_t *keeper)
{
    const uint64_t measured = measured_positions(keeper);
    keeper->wants |= ((measured & ~keeper->saved) != 0U) ? (unsigned)WANT_APPEND : 0U;
    keeper->wants |= ((keeper->saved & ~measured) != 0U) ? (unsigned)WANT_BEGIN : 0U;
    if ((keeper->wants & WANT_BEGIN) != 0U) {
        keeper->saved = 0;
    }
}

void tumble_keeper_look_at_run(tumble_keeper_t *keeper)
{
    const bool on = tumble_run_is_on(keeper->navcomp);
    if (on && !keeper->run_was_on) {
        begin_run(keeper);
    }
    if (!on && keeper->run_was_on) {
        end_run(keeper);
    }
    if (on) {
        look_at_means(keeper);
    }
}

/* The checkpoint. */

/* The write failed, so there is no checkpoint. Retry after the next position, not at every step: until then all means
 * count as saved. */
TUMBLE_ONE_COPY static void put_off(tumble_keeper_t *keeper)
{
    keeper->has_checkpoint = false;
    keeper->trying = TRYING_NOTHING;
    keeper->lost = 0;
    keeper->saved = measured_positions(keeper);
}

static void begin_trying(tumble_keeper_t *keeper, uint8_t job)
{
    keeper->tries = (uint8_t)(((keeper->trying == job) ? keeper->tries : 0U) + 1U);
    keeper->trying = job;
}

static void begin(tumble_keeper_t *keeper)
{
    keeper->wants &= (uint8_t)~(unsigned)WANT_BEGIN;
    keeper->saved = 0;
    keeper->lost = 0;
    keeper->has_checkpoint = false;
    begin_trying(keeper, TRYING_TO_BEGIN);
    keeper->fingerprint = fingerprint_of(keeper); /* now: what the run before has left is stored */
    (void)tumble_checkpoint_begin(&keeper->checkpoint, keeper->fingerprint);
}

/* The bit of the mean that is under way; 0: none is. */
static uint64_t tried_mean(const tumble_keeper_t *keeper)
{
    const bool mean = (keeper->trying != (uint8_t)TRYING_NOTHING) && (keeper->trying <= (uint8_t)TUMBLE_MAX_POSITIONS);
    return mean ? bit_of((uint8_t)(keeper->trying - 1U)) : 0U;
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

/* Should the failed job of the checkpoint be retried? A mean, only while there is a checkpoint: the failure may have
 * cost all of it. A clear, in any case: what is left of the run before must not be resumed, and a record that cannot be
 * read now may be readable at the next power-on. */
static bool is_to_be_tried(const tumble_keeper_t *keeper)
{
    bool to_be_tried = keeper->checkpoint.kept && keeper->has_checkpoint;
    if (keeper->trying == (uint8_t)TRYING_TO_CLEAR) {
        to_be_tried = true;
    } else if (keeper->trying == (uint8_t)TRYING_TO_BEGIN) {
        to_be_tried = keeper->run_was_on && (keeper->tries < TUMBLE_SETS_TRIES);
    } else {
        /* a mean */
    }
    return to_be_tried;
}

static void try_again(tumble_keeper_t *keeper)
{
    const bool again = keeper->tries < TUMBLE_SETS_TRIES;
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
    const uint64_t missing = measured_positions(keeper) & ~keeper->saved;
    uint8_t p = 0;
    while ((p < positions_of(keeper)) && ((missing & bit_of(p)) == 0U)) {
        p++;
    }
    if (p == positions_of(keeper)) {
        keeper->wants &= (uint8_t)~(unsigned)WANT_APPEND;
        return;
    }
    if (!keeper->has_checkpoint) {
        keeper->wants |= WANT_BEGIN;
        return;
    }
    const tumble_status_t status = tumble_checkpoint_append(&keeper->checkpoint, p, &tumble_keeper_averages(keeper)[p]);
    if (status == TUMBLE_E_FULL) {
        keeper->wants |= WANT_BEGIN; /* of what was measured again only the last remains */
        return;
    }
    keeper->saved |= bit_of(p);
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

/* Called while the memory is at rest: a job is always taken then, and its steps tell how it ends. */
void tumble_keeper_keep_run(tumble_keeper_t *keeper)
{
    if ((keeper->wants & WANT_BEGIN) != 0U) {
        begin(keeper);
    } else if ((keeper->wants & WANT_CLEAR) != 0U) {
        keeper->wants &= (uint8_t)~(unsigned)(WANT_CLEAR | WANT_APPEND);
        keeper->resumable = 0;
        begin_trying(keeper, TRYING_TO_CLEAR);
        (void)tumble_checkpoint_clear(&keeper->checkpoint);
    } else if ((keeper->wants & WANT_APPEND) != 0U) {
        append(keeper);
    } else {
        /* nothing to do */
    }
}

/* After a loss of power. */

static bool is_fit(const tumble_keeper_t *keeper, uint8_t index)
{
    return tumble_checkpoint_has(&keeper->checkpoint, index) && ((keeper->unfit & bit_of(index)) == 0U);
}

/* One that is about to be cleared holds none. */
void tumble_keeper_count_resumable(tumble_keeper_t *keeper)
{
    const bool idle = tumble_keeper_is_idle(keeper) && ((keeper->wants & WANT_CLEAR) == 0U);
    keeper->resumable = 0;
    if (idle && tumble_checkpoint_matches(&keeper->checkpoint, fingerprint_of(keeper))) {
        for (uint8_t p = 0; p < positions_of(keeper); p++) {
            keeper->resumable = (uint8_t)(keeper->resumable + (is_fit(keeper, p) ? 1U : 0U));
        }
    }
}

static tumble_status_t refuse(tumble_keeper_t *keeper)
{
    tumble_count(&keeper->counters.not_resumed);
    return TUMBLE_E_STATE;
}

tumble_status_t tumble_keeper_resume(tumble_keeper_t *keeper)
{
    if ((keeper->task != (uint8_t)TASK_NONE) || keeper->stale || tumble_keeper_busy(keeper)) {
        return refuse(keeper);
    }
    keeper->unfit = 0; /* a command tries all of them again */
    tumble_keeper_count_resumable(keeper);
    if (keeper->resumable == 0U) {
        return refuse(keeper);
    }
    keeper->fingerprint = fingerprint_of(keeper);
    keeper->saved = 0;
    keeper->lost = 0;
    keeper->checkpoint.margins = (tumble_margins_t){UINT8_MAX, UINT8_MAX}; /* each mean brings its own along */
    keeper->task = TASK_RESTORE;
    keeper->at = 0;
    return TUMBLE_OK;
}

/* All kept means have been put back. Only the configuration can have changed since the command: check it again. */
static void go_on(tumble_keeper_t *keeper)
{
    keeper->task = TASK_NONE;
    if ((keeper->fingerprint != fingerprint_of(keeper)) || tumble_keeper_is_inhibited(keeper) ||
        (tumble_navcomp_obey(keeper->navcomp, TUMBLE_COMMAND_RESUME, 0) != TUMBLE_OK)) {
        (void)refuse(keeper);
        tumble_keeper_count_resumable(keeper); /* for what cannot be put back nothing waits */
        return;
    }
    begin_part(keeper, false); /* a reset may have taken the counters away */
    tumble_count(&keeper->counters.resumed);
    keeper->has_checkpoint = true;
    keeper->run_was_on = true;
    keeper->run_resumed = true;
    forget_temperatures(keeper);
    keeper->resumable = 0;
}

void tumble_keeper_restore(tumble_keeper_t *keeper)
{
    tumble_average_t mean;
    while ((keeper->at < positions_of(keeper)) && !tumble_checkpoint_has(&keeper->checkpoint, keeper->at)) {
        keeper->at++;
    }
    if (keeper->at == positions_of(keeper)) {
        go_on(keeper);
        return;
    }
    tumble_status_t status = tumble_checkpoint_read(&keeper->checkpoint, keeper->at, &mean);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status == TUMBLE_OK) {
        status = tumble_procedure_restore(&keeper->navcomp->procedure, keeper->at, &mean);
    }
    uint64_t *const means = (status == TUMBLE_OK) ? &keeper->saved : &keeper->unfit;
    *means |= bit_of(keeper->at);
    keeper->at++;
}
