/* The life of the sets: what is done when the memory is free, and the commands. */
#include "sets/parts.h"

#include <stddef.h>

/* Jobs of the store. */

static void count_job(tumble_sets_counters_t *counters, uint8_t job)
{
    uint32_t *counter = &counters->rolled_back;
    if (job == (uint8_t)TUMBLE_VERDICT_COMMITTED) {
        counter = &counters->committed;
    } else if (job == (uint8_t)TUMBLE_VERDICT_HELD) {
        counter = &counters->held;
    } else if (job == (uint8_t)TUMBLE_VERDICT_ACCEPTED) {
        counter = &counters->accepted;
    } else if (job == (uint8_t)TUMBLE_VERDICT_DISCARDED) {
        counter = &counters->discarded;
    } else {
        /* rolled back */
    }
    tumble_count(counter);
}

static void end_job(tumble_sets_t *sets)
{
    const uint8_t job = sets->job;
    const tumble_status_t outcome = tumble_store_outcome(&sets->store);
    sets->job = TUMBLE_VERDICT_NONE;
    sets->stale = true;
    sets->history_tries = TUMBLE_SETS_TRIES;
    if (job == (uint8_t)TUMBLE_VERDICT_NONE) {
        return; /* it only looked what is there */
    }
    if (outcome != TUMBLE_OK) {
        sets->verdict = TUMBLE_VERDICT_FAILED;
        tumble_sets_fail(sets, outcome);
        return;
    }
    sets->verdict = job;
    count_job(&sets->counters, job);
    if ((job == (uint8_t)TUMBLE_VERDICT_COMMITTED) || (job == (uint8_t)TUMBLE_VERDICT_HELD)) {
        tumble_sets_end_checkpoint(sets); /* the run has come to its end */
    }
}

/* The proposal that was named, if it is there still. */
static tumble_status_t accept(tumble_sets_t *sets)
{
    return (tumble_store_proposal(&sets->store) == sets->accepted)
               ? tumble_store_accept(&sets->store, tumble_sets_rules_flag(sets))
               : TUMBLE_E_STATE;
}

/* Commands about sets wait until the memory is free. */
static void begin_command(tumble_sets_t *sets)
{
    if ((sets->wants & WANT_ACCEPT) != 0U) {
        tumble_sets_begin_job(sets, TUMBLE_VERDICT_ACCEPTED, accept(sets));
    } else if ((sets->wants & WANT_DISCARD) != 0U) {
        tumble_sets_begin_job(sets, TUMBLE_VERDICT_DISCARDED, tumble_store_discard(&sets->store));
    } else {
        tumble_sets_begin_job(sets, TUMBLE_VERDICT_ROLLED_BACK, tumble_store_rollback(&sets->store));
    }
    sets->wants &= (uint8_t)~(unsigned)WANT_COMMANDS;
}

/* The step. */

void tumble_sets_step_memory(tumble_sets_t *sets)
{
    tumble_status_t status = TUMBLE_OK;
    if (tumble_store_busy(&sets->store)) {
        if (tumble_store_step(&sets->store) != TUMBLE_E_PORT_BUSY) {
            end_job(sets);
        }
    } else if (tumble_history_busy(&sets->history)) {
        status = tumble_history_step(&sets->history);
        if (status == TUMBLE_E_NV) {
            tumble_sets_try_history_again(sets);
        }
    } else if (tumble_checkpoint_busy(&sets->checkpoint)) {
        status = tumble_sets_step_checkpoint(sets);
    } else {
        /* the memory is the owner's, or nobody's */
    }
    if ((status != TUMBLE_OK) && (status != TUMBLE_E_PORT_BUSY)) {
        tumble_sets_fail(sets, status);
    }
}

void tumble_sets_work(tumble_sets_t *sets, tumble_sets_event_t *event)
{
    event->wish = TUMBLE_SETS_NOTHING;
    if (tumble_sets_busy(sets)) {
        tumble_sets_step_memory(sets);
    } else if (sets->stale) {
        tumble_sets_refresh(sets);
    } else if (sets->task == (uint8_t)TASK_RESTORE) {
        tumble_sets_restore(sets, event);
    } else if (sets->task != (uint8_t)TASK_NONE) {
        tumble_sets_judge(sets);
    } else if ((sets->wants & WANT_RECORD_DECAY) != 0U) {
        tumble_sets_record_decay(sets);
    } else if ((sets->wants & WANT_COMMANDS) != 0U) {
        begin_command(sets);
    } else {
        tumble_sets_keep(sets);
    }
}

bool tumble_sets_news(tumble_sets_t *sets)
{
    const uint32_t objections = (sets->objections << 16) | ((sets->objections >> TUMBLE_OBJECTION_MORE) << 12);
    const uint32_t shown = objections | ((uint32_t)sets->verdict << 8) | tumble_sets_due(sets);
    const bool news = (sets->shown != shown);
    sets->shown = shown;
    return news;
}

/* Commands. */

static bool is_free_to(const tumble_sets_t *sets, tumble_which_set_t which)
{
    return (sets->task == (uint8_t)TASK_NONE) && ((sets->wants & WANT_COMMANDS) == 0U) && !sets->run->on &&
           tumble_store_has(&sets->store, which);
}

static tumble_status_t want(tumble_sets_t *sets, unsigned wanted, tumble_which_set_t which)
{
    const bool held = tumble_store_has(&sets->store, TUMBLE_SET_PROPOSAL);
    if (!is_free_to(sets, which) || ((wanted == (unsigned)WANT_ROLLBACK) && held)) {
        tumble_count(&sets->counters.refused);
        return TUMBLE_E_STATE;
    }
    sets->wants |= (uint8_t)wanted;
    sets->verdict = TUMBLE_VERDICT_WORKING;
    return TUMBLE_OK;
}

/* The caller names the proposal by its CRC, so that the set that was read is the one that becomes active. */
tumble_status_t tumble_sets_accept(tumble_sets_t *sets, uint32_t named)
{
    const bool other = (tumble_store_proposal(&sets->store) != named) || (named == 0U);
    if (other && is_free_to(sets, TUMBLE_SET_PROPOSAL)) {
        tumble_count(&sets->counters.refused);
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = want(sets, WANT_ACCEPT, TUMBLE_SET_PROPOSAL);
    sets->accepted = (status == TUMBLE_OK) ? named : sets->accepted; /* of the command that waits */
    return status;
}

tumble_status_t tumble_sets_discard(tumble_sets_t *sets)
{
    return want(sets, WANT_DISCARD, TUMBLE_SET_PROPOSAL);
}

tumble_status_t tumble_sets_rollback(tumble_sets_t *sets)
{
    return want(sets, WANT_ROLLBACK, TUMBLE_SET_PREVIOUS);
}

bool tumble_sets_allow(tumble_sets_t *sets, bool begins, bool too_early, bool moves)
{
    const bool inhibited = moves && tumble_sets_is_inhibited(sets);
    const bool refused = too_early || (begins && tumble_sets_is_assessing(sets));
    if (refused) {
        tumble_count(&sets->counters.refused);
    } else if (inhibited) {
        tumble_count(&sets->counters.inhibited);
    } else if (moves) {
        sets->was_inhibited = false; /* whatever the last step saw: the next one is to see when it begins again */
    } else {
        /* any other command is allowed */
    }
    return !refused && !inhibited;
}

/* Getting ready. */

static bool is_usable(const tumble_sets_config_t *config)
{
    if ((config->serial == NULL) || (config->settings == NULL)) {
        return false;
    }
    const uint8_t length = tumble_serial_length(config);
    return (length != 0U) && (length <= TUMBLE_SET_SERIAL_BYTES) && tumble_sets_settings_valid(config->settings);
}

void tumble_sets_reset(tumble_sets_t *sets)
{
    sets->settings = *sets->config->settings;
    sets->rules = tumble_sets_rules_of_board(sets);
    if (tumble_sets_is_assessing(sets)) {
        sets->verdict = TUMBLE_VERDICT_NONE; /* the means are gone; the checkpoint has them */
        sets->task = TASK_NONE;
    }
    sets->task = (sets->task == (uint8_t)TASK_RESTORE) ? (uint8_t)TASK_NONE : sets->task;
    sets->stale = true; /* a run that is kept may fit again what the node goes by */
}

static tumble_status_t open_memory(tumble_sets_t *sets, const tumble_nv_t *nv)
{
    tumble_status_t status = tumble_store_init(&sets->store, nv);
    if (status == TUMBLE_OK) {
        status = tumble_history_init(&sets->history, nv);
    }
    return (status == TUMBLE_OK) ? tumble_checkpoint_init(&sets->checkpoint, nv) : status;
}

tumble_status_t tumble_sets_init(tumble_sets_t *sets, const tumble_sets_config_t *config,
                                 const tumble_sets_owner_t *owner)
{
    if (!is_usable(config)) {
        return TUMBLE_E_ARGUMENT;
    }
    *sets = (tumble_sets_t){
        .config = config,
        .owner = owner,
        .run = owner->run,
        .settings = *config->settings,
        .history_tries = TUMBLE_SETS_TRIES,
    };
    sets->rules = tumble_sets_rules_of_board(sets);
    sets->now_us = owner->port->now_us(owner->port->context);
    sets->active_us = sets->now_us;
    return open_memory(sets, owner->port->nv);
}

void tumble_sets_booted(tumble_sets_t *sets, tumble_status_t opened)
{
    if ((opened == TUMBLE_OK) && !tumble_sets_busy(sets)) {
        tumble_sets_refresh(sets);
    }
    sets->stale = sets->stale || tumble_sets_busy(sets);
}
