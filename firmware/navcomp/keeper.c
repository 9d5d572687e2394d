#include "navcomp/keeper_parts.h"

#include "core/arith.h"
#include "core/one_copy.h"

#include <stddef.h>

#define BOOT_CALLS 2048 /* of the memory: more than it takes to look through all that is kept */
#define RETRY_US 1000U  /* to the next step, which may call the memory */

bool tumble_keeper_busy(const tumble_keeper_t *keeper)
{
    return tumble_store_busy(&keeper->store) || tumble_history_busy(&keeper->history) ||
           tumble_checkpoint_busy(&keeper->checkpoint) || tumble_parameters_busy(&keeper->parameters);
}

bool tumble_keeper_has_work(const tumble_keeper_t *keeper)
{
    return tumble_keeper_busy(keeper) || keeper->stale || (keeper->task != (uint8_t)TASK_NONE) || (keeper->wants != 0U);
}

void tumble_keeper_fail(tumble_keeper_t *keeper, tumble_status_t status)
{
    keeper->status = (uint8_t)status;
    tumble_count(&keeper->counters.failures);
}

void tumble_keeper_begin_job(tumble_keeper_t *keeper, uint8_t job, tumble_status_t status)
{
    if (status == TUMBLE_OK) {
        keeper->job = job;
        keeper->verdict = TUMBLE_VERDICT_WORKING;
    } else {
        keeper->verdict = TUMBLE_VERDICT_FAILED;
        tumble_keeper_fail(keeper, status);
    }
}

/* What the active set is. */

static void note_active(tumble_keeper_t *keeper, const tumble_set_t *set)
{
    const bool known = (set->flags & TUMBLE_SET_HAS_TEMPERATURE) != 0U;
    const double half_c = 2.0 * set->temperature_c;
    keeper->has_active_half_c = known && tumble_within(half_c + 0.5, (double)INT8_MAX + 0.5); /* from INT8_MIN on */
    const int size = keeper->has_active_half_c ? (int)tumble_whole(tumble_abs(half_c)) : 0;
    keeper->active_half_c = (int16_t)(tumble_is_positive(half_c) ? size : -size);
    keeper->active_utc_s = set->date_utc_s;
}

static void try_history_again(tumble_keeper_t *keeper)
{
    keeper->stale = keeper->stale || (keeper->history_tries != 0U);
}

/* Append the history entry of a commit that a loss of power or a failing memory has prevented. */
static void write_history(tumble_keeper_t *keeper, const tumble_set_t *set)
{
    tumble_history_entry_t entry;
    if (set->sequence <= tumble_history_sequence(&keeper->history)) {
        return;
    }
    tumble_status_t status = tumble_history_from_set(set, &entry);
    if (status == TUMBLE_OK) {
        const bool other_block = (set->reasons & TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_BLOCK)) != 0U;
        entry.flags |= other_block ? TUMBLE_HISTORY_OTHER_BLOCK : 0U;
        keeper->history_tries = (uint8_t)(keeper->history_tries - ((keeper->history_tries != 0U) ? 1U : 0U));
        status = tumble_history_append(&keeper->history, &entry);
    }
    if (status != TUMBLE_OK) {
        tumble_keeper_fail(keeper, status);
    }
    if (status == TUMBLE_E_NV) {
        try_history_again(keeper);
    }
}

static void note_change(tumble_keeper_t *keeper)
{
    const uint32_t sequence = tumble_store_sequence(&keeper->store);
    if (keeper->sequence != sequence) {
        keeper->sequence = sequence;
        keeper->active_us = keeper->now_us;
        keeper->shown = UINT32_MAX;
    }
}

/* Decay: the history knows of a set that the store no longer has. */

/* A decay goes into the history once, however often power comes back: is the newest entry about it already? */
TUMBLE_ONE_COPY static void record_decay(tumble_keeper_t *keeper)
{
    tumble_history_entry_t entry;
    tumble_set_t active = {.sequence = 0};
    tumble_status_t status = tumble_history_read(&keeper->history, 0, &entry);
    if (status == TUMBLE_OK) {
        const bool there = (entry.origin == (uint8_t)TUMBLE_ORIGIN_DECAYED);
        status = there ? TUMBLE_E_STATE : tumble_store_read(&keeper->store, TUMBLE_SET_ACTIVE, &active);
        status = (!there && (status == TUMBLE_E_STATE)) ? TUMBLE_OK : status; /* no set is left: zeros */
    }
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    keeper->wants &= (uint8_t)~(unsigned)WANT_RECORD_DECAY;
    if ((status == TUMBLE_OK) && (tumble_history_from_set(&active, &entry) == TUMBLE_OK)) {
        entry.sequence = tumble_history_sequence(&keeper->history);
        entry.origin = (uint8_t)TUMBLE_ORIGIN_DECAYED;
        entry.date_utc_s = tumble_keeper_utc_s(keeper);
        (void)tumble_history_append(&keeper->history, &entry); /* refused: the next power-on tries again */
    }
}

static void note_decay(tumble_keeper_t *keeper)
{
    const uint32_t known = tumble_history_sequence(&keeper->history);
    const bool gone = (known > keeper->sequence) && (known < TUMBLE_MAX_SEQUENCE);
    const bool decayed = gone && !tumble_store_has_newer(&keeper->store);
    if (decayed && !keeper->decayed) {
        keeper->wants |= WANT_RECORD_DECAY;
    }
    keeper->decayed = decayed;
}

TUMBLE_ONE_COPY static void refresh(tumble_keeper_t *keeper)
{
    tumble_set_t active;
    const tumble_status_t status = tumble_store_read(&keeper->store, TUMBLE_SET_ACTIVE, &active);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    tumble_store_number_above(&keeper->store, tumble_history_sequence(&keeper->history));
    keeper->stale = false;
    keeper->has_active = (status == TUMBLE_OK);
    keeper->off_temperature = 0;
    note_change(keeper);
    note_decay(keeper);
    if (keeper->has_active) {
        note_active(keeper, &active);
        write_history(keeper, &active);
    } else {
        keeper->has_active_half_c = false;
        keeper->active_utc_s = 0;
        if (status != TUMBLE_E_STATE) {
            tumble_keeper_fail(keeper, status);
        }
    }
    tumble_keeper_count_resumable(keeper);
}

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

static void end_job(tumble_keeper_t *keeper)
{
    const uint8_t job = keeper->job;
    const tumble_status_t outcome = tumble_store_outcome(&keeper->store);
    keeper->job = TUMBLE_VERDICT_NONE;
    keeper->stale = true;
    keeper->history_tries = TUMBLE_SETS_TRIES;
    if (job == (uint8_t)TUMBLE_VERDICT_NONE) {
        return; /* it only looked what is there */
    }
    if (outcome != TUMBLE_OK) {
        keeper->verdict = TUMBLE_VERDICT_FAILED;
        tumble_keeper_fail(keeper, outcome);
        return;
    }
    keeper->verdict = job;
    count_job(&keeper->counters, job);
    if ((job == (uint8_t)TUMBLE_VERDICT_COMMITTED) || (job == (uint8_t)TUMBLE_VERDICT_HELD)) {
        tumble_keeper_end_checkpoint(keeper); /* the run has come to its end */
    }
}

/* The proposal that was named, if it is there still. */
static tumble_status_t accept(tumble_keeper_t *keeper)
{
    return (tumble_store_proposal(&keeper->store) == keeper->accepted)
               ? tumble_store_accept(&keeper->store, tumble_keeper_rules_flag(keeper))
               : TUMBLE_E_STATE;
}

/* Commands about sets wait until the memory is free. */
static void begin_command(tumble_keeper_t *keeper)
{
    if ((keeper->wants & WANT_ACCEPT) != 0U) {
        tumble_keeper_begin_job(keeper, TUMBLE_VERDICT_ACCEPTED, accept(keeper));
    } else if ((keeper->wants & WANT_DISCARD) != 0U) {
        tumble_keeper_begin_job(keeper, TUMBLE_VERDICT_DISCARDED, tumble_store_discard(&keeper->store));
    } else {
        tumble_keeper_begin_job(keeper, TUMBLE_VERDICT_ROLLED_BACK, tumble_store_rollback(&keeper->store));
    }
    keeper->wants &= (uint8_t)~(unsigned)WANT_COMMANDS;
}

/* The step. */

/* What is saved is the board's own. */
static void note_parameters(tumble_keeper_t *keeper)
{
    const uint8_t event = keeper->parameters.event;
    keeper->parameters.event = TUMBLE_PARAMETERS_NOTHING;
    if (event == (uint8_t)TUMBLE_PARAMETERS_APPLIED) {
        keeper->rules = tumble_keeper_rules(keeper);
    } else if (event == (uint8_t)TUMBLE_PARAMETERS_WRITTEN) {
        keeper->rules = keeper->rules_written;
    } else {
        /* nothing has changed */
    }
}

static void step_memory(tumble_keeper_t *keeper)
{
    tumble_status_t status = TUMBLE_OK;
    if (tumble_store_busy(&keeper->store)) {
        if (tumble_store_step(&keeper->store) != TUMBLE_E_PORT_BUSY) {
            end_job(keeper);
        }
    } else if (tumble_history_busy(&keeper->history)) {
        status = tumble_history_step(&keeper->history);
        if (status == TUMBLE_E_NV) {
            try_history_again(keeper);
        }
    } else if (tumble_checkpoint_busy(&keeper->checkpoint)) {
        status = tumble_keeper_step_checkpoint(keeper);
    } else {
        tumble_parameters_step(&keeper->parameters);
        note_parameters(keeper);
    }
    if ((status != TUMBLE_OK) && (status != TUMBLE_E_PORT_BUSY)) {
        tumble_keeper_fail(keeper, status);
    }
}

static void work(tumble_keeper_t *keeper)
{
    if (tumble_keeper_busy(keeper)) {
        step_memory(keeper);
    } else if (keeper->stale) {
        refresh(keeper);
    } else if (keeper->task == (uint8_t)TASK_RESTORE) {
        tumble_keeper_restore(keeper);
    } else if (keeper->task != (uint8_t)TASK_NONE) {
        tumble_keeper_judge(keeper);
    } else if ((keeper->wants & WANT_RECORD_DECAY) != 0U) {
        record_decay(keeper);
    } else if ((keeper->wants & WANT_COMMANDS) != 0U) {
        begin_command(keeper);
    } else {
        tumble_keeper_keep_run(keeper);
    }
}

/* The error register has one bit for all errors of the maker, and a reset of the communication clears it. So the message
 * is sent again as long as the bit is not set. */
static void tell_decay(tumble_keeper_t *keeper)
{
    tumble_emcy_t *emcy = &keeper->navcomp->node.emcy;
    const bool told = (emcy->error_register & TUMBLE_ERROR_MANUFACTURER) != 0U;
    if (keeper->decayed && !told) {
        tumble_emcy_tell(emcy, TUMBLE_KEEPER_EMCY_DECAYED, TUMBLE_ERROR_MANUFACTURER, keeper->sequence);
        keeper->decay_told = true;
    } else if (!keeper->decayed && keeper->decay_told) {
        tumble_emcy_clear(emcy, TUMBLE_ERROR_MANUFACTURER);
        keeper->decay_told = false;
    } else {
        /* nothing has changed */
    }
}

/* The state message goes when counter, verdict, objections or what is due have changed. */
static void tell_state(tumble_keeper_t *keeper)
{
    const uint32_t objections = (keeper->objections << 16) | ((keeper->objections >> TUMBLE_OBJECTION_MORE) << 12);
    const uint32_t shown = objections | ((uint32_t)keeper->verdict << 8) | tumble_keeper_due(keeper);
    if (keeper->shown != shown) {
        keeper->shown = shown;
        tumble_pdo_trigger(&keeper->navcomp->node.pdos, TUMBLE_KEEPER_PDO);
    }
}

static void start_if_due(tumble_keeper_t *keeper)
{
    if (!tumble_keeper_has_work(keeper) && tumble_keeper_may_start(keeper)) {
        (void)tumble_navcomp_obey(keeper->navcomp, TUMBLE_COMMAND_START, 0);
        tumble_keeper_look_at_run(keeper);
    }
}

/* A step of the whole-model test, which needs no memory, is followed by the next at once. */
static uint64_t step(void *context, uint64_t now_us)
{
    tumble_keeper_t *keeper = context;
    tumble_keeper_hold_off(keeper, now_us);
    tumble_keeper_look_at_run(keeper);
    work(keeper);
    start_if_due(keeper);
    tell_decay(keeper);
    tell_state(keeper);
    const bool computes = (keeper->task == (uint8_t)TASK_WHOLE_MODEL) && !tumble_keeper_busy(keeper);
    return tumble_keeper_has_work(keeper) ? (now_us + (computes ? 0U : RETRY_US)) : UINT64_MAX;
}

static void see_sample(void *context, const tumble_block_sample_t *sample, bool averaged)
{
    tumble_keeper_t *keeper = context;
    const tumble_block_counters_t *block = &keeper->navcomp->block.counters;
    tumble_keeper_note_temperature(keeper, sample->temperature_half_c, averaged);
    tumble_at_rest_take(&keeper->at_rest, keeper->navcomp->procedure_config.averaging, sample,
                        block->repeated + block->reordered);
}

/* Commands. */

static bool is_free_to(const tumble_keeper_t *keeper, tumble_which_set_t which)
{
    return (keeper->task == (uint8_t)TASK_NONE) && ((keeper->wants & WANT_COMMANDS) == 0U) &&
           !tumble_run_is_on(keeper->navcomp) && tumble_store_has(&keeper->store, which);
}

/* Done when the memory is free. */
static tumble_status_t want(tumble_keeper_t *keeper, unsigned wanted, tumble_which_set_t which)
{
    const bool held = tumble_store_has(&keeper->store, TUMBLE_SET_PROPOSAL);
    if (!is_free_to(keeper, which) || ((wanted == (unsigned)WANT_ROLLBACK) && held)) {
        tumble_count(&keeper->counters.refused);
        return TUMBLE_E_STATE;
    }
    keeper->wants |= (uint8_t)wanted;
    keeper->verdict = TUMBLE_VERDICT_WORKING;
    return TUMBLE_OK;
}

/* The caller names the proposal by its CRC, once, so that the set that was read is the one that becomes active. */
static tumble_status_t want_accepted(tumble_keeper_t *keeper)
{
    tumble_navcomp_objects_t *staged = tumble_staged(keeper->navcomp);
    const uint32_t named = staged->command_proposal;
    const bool other = (tumble_store_proposal(&keeper->store) != named) || (named == 0U);
    staged->command_proposal = 0;
    if (other && is_free_to(keeper, TUMBLE_SET_PROPOSAL)) {
        tumble_count(&keeper->counters.refused);
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = want(keeper, WANT_ACCEPT, TUMBLE_SET_PROPOSAL);
    keeper->accepted = (status == TUMBLE_OK) ? named : keeper->accepted; /* of the command that waits */
    return status;
}

static tumble_status_t obey(tumble_keeper_t *keeper, tumble_command_t command, uint8_t argument)
{
    tumble_status_t status;
    switch (command) {
    case TUMBLE_COMMAND_ACCEPT:
        status = want_accepted(keeper);
        break;
    case TUMBLE_COMMAND_DISCARD:
        status = want(keeper, WANT_DISCARD, TUMBLE_SET_PROPOSAL);
        break;
    case TUMBLE_COMMAND_ROLLBACK:
        status = want(keeper, WANT_ROLLBACK, TUMBLE_SET_PREVIOUS);
        break;
    case TUMBLE_COMMAND_RESUME:
        status = tumble_keeper_is_idle(keeper) ? tumble_keeper_resume(keeper)
                                               : tumble_navcomp_obey(keeper->navcomp, command, argument);
        break;
    default:
        status = tumble_navcomp_obey(keeper->navcomp, command, argument);
        break;
    }
    return status;
}

/* A command that begins a run or measures anew is refused while a result is judged; one that begins a run, until the saved
 * parameters are in force; and one that moves the table or goes on with a run, while inhibited. */
static bool is_allowed(tumble_keeper_t *keeper, tumble_command_t command)
{
    const bool starts = (command == TUMBLE_COMMAND_START);
    const bool begins =
        starts || (command == TUMBLE_COMMAND_REPEAT_POSITION) || (command == TUMBLE_COMMAND_REPEAT_MOUNTING);
    const bool moves = begins || (command == TUMBLE_COMMAND_RESUME) || (command == TUMBLE_COMMAND_CONFIRM_MOUNTING) ||
                       (command == TUMBLE_COMMAND_HOME_AXIS) || (command == TUMBLE_COMMAND_TURN_AXIS);
    const bool inhibited = moves && tumble_keeper_is_inhibited(keeper);
    const bool refused =
        (starts && tumble_parameters_reading(&keeper->parameters)) || (begins && tumble_keeper_is_assessing(keeper));
    if (refused) {
        tumble_count(&keeper->counters.refused);
    } else if (inhibited) {
        tumble_count(&keeper->counters.inhibited);
    } else if (moves) {
        keeper->was_inhibited = false; /* whatever the last step saw: the next one is to see when it begins again */
    } else {
        /* any other command is allowed */
    }
    return !refused && !inhibited;
}

static tumble_status_t command(void *context, tumble_command_t wanted, uint8_t argument)
{
    tumble_keeper_t *keeper = context;
    tumble_keeper_look_at_run(keeper); /* what ended before must be seen before anything begins anew */
    if (!is_allowed(keeper, wanted)) {
        return TUMBLE_E_STATE;
    }
    const tumble_status_t status = obey(keeper, wanted, argument);
    tumble_keeper_look_at_run(keeper);
    if ((wanted == TUMBLE_COMMAND_HOME_AXIS) || (wanted == TUMBLE_COMMAND_TURN_AXIS)) {
        tumble_keeper_pause(keeper); /* somebody is at work there */
    }
    return status;
}

/* Getting ready. */

static void reset(void *context)
{
    tumble_keeper_t *keeper = context;
    keeper->settings = *keeper->config->sets.settings;
    keeper->rules = tumble_keeper_rules_of_board(keeper);
    if (tumble_keeper_is_assessing(keeper)) {
        keeper->verdict = TUMBLE_VERDICT_NONE; /* the means are gone; the checkpoint has them */
        keeper->task = TASK_NONE;
    }
    keeper->task = (keeper->task == (uint8_t)TASK_RESTORE) ? (uint8_t)TASK_NONE : keeper->task;
    keeper->stale = true; /* a run that is kept may fit again what the node goes by */
    (void)tumble_at_rest_begin(&keeper->at_rest, 0);
    tumble_parameters_restore(&keeper->parameters);
}

static bool is_usable(const tumble_sets_config_t *config)
{
    if ((config->serial == NULL) || (config->settings == NULL)) {
        return false;
    }
    const uint32_t length = tumble_serial_length(config->serial);
    return (length != 0U) && (length <= TUMBLE_SET_SERIAL_BYTES) && tumble_keeper_settings_valid(config->settings);
}

static tumble_status_t open_memory(tumble_keeper_t *keeper, const tumble_nv_t *nv)
{
    tumble_status_t status = tumble_store_init(&keeper->store, nv);
    if (status == TUMBLE_OK) {
        status = tumble_history_init(&keeper->history, nv);
    }
    return (status == TUMBLE_OK) ? tumble_checkpoint_init(&keeper->checkpoint, nv) : status;
}

static tumble_status_t init(void *context, tumble_navcomp_t *navcomp)
{
    tumble_keeper_t *keeper = context;
    const tumble_port_t *port = navcomp->config->port;
    if ((keeper == NULL) || (keeper->config == NULL) || !is_usable(&keeper->config->sets)) {
        return TUMBLE_E_ARGUMENT;
    }
    *keeper = (tumble_keeper_t){
        .config = keeper->config,
        .navcomp = navcomp,
        .settings = *keeper->config->sets.settings,
        .history_tries = TUMBLE_SETS_TRIES,
    };
    keeper->rules = tumble_keeper_rules_of_board(keeper);
    keeper->now_us = port->now_us(port->context);
    keeper->active_us = keeper->now_us;
    const tumble_status_t status = open_memory(keeper, port->nv);
    if (status == TUMBLE_E_ARGUMENT) {
        return status;
    }
    tumble_parameters_init(&keeper->parameters, port->nv, &navcomp->node, &keeper->store);
    for (int calls = 0; (calls < BOOT_CALLS) && tumble_keeper_busy(keeper); calls++) {
        step_memory(keeper);
    }
    if ((status == TUMBLE_OK) && !tumble_keeper_busy(keeper)) {
        refresh(keeper);
    }
    keeper->stale = keeper->stale || tumble_keeper_busy(keeper);
    return status;
}

const tumble_keeping_t tumble_keeper_calls = {
    .init = init,
    .step = step,
    .sample = see_sample,
    .command = command,
    .reset = reset,
    .objects = &tumble_keeper_extension,
};
