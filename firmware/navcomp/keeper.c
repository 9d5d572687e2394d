/* The life of the sets: what is done when the memory is free, when a run is due, commands, settings, calendar, inhibit. Saved
 * rules count as the board's as soon as they are in force or have been written.
 */
#include "navcomp/keeper_parts.h"

#include "core/arith.h"
#include "core/crc32.h"
#include "core/one_copy.h"

#include <stddef.h>

#define BOOT_CALLS 2048 /* of the memory: more than it takes to look through all that is kept */
#define RETRY_US 1000U  /* to the next step, which may call the memory */
#define MIN_GRAVITY_M_S2 9.7
#define MAX_GRAVITY_M_S2 9.9

/* Settings. */

static bool settings_valid(const tumble_sets_settings_t *settings)
{
    const double gravity = settings->gravity_m_s2;
    const bool somewhere = tumble_is_finite(gravity) && !tumble_exceeds(MIN_GRAVITY_M_S2, gravity) &&
                           !tumble_exceeds(gravity, MAX_GRAVITY_M_S2);
    return tumble_commit_limits_valid(&settings->limits) && (tumble_within(gravity, 0.0) || somewhere) &&
           (settings->pause_s >= TUMBLE_SETS_MIN_PAUSE_S) && (settings->temperature_samples != 0U) &&
           ((settings->flags & ~(unsigned)TUMBLE_SETS_STARTS) == 0U);
}

tumble_status_t tumble_keeper_change(tumble_keeper_t *keeper, const tumble_sets_settings_t *settings)
{
    if ((settings == NULL) || !settings_valid(settings)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_run_is_on(keeper->navcomp)) {
        return TUMBLE_E_STATE;
    }
    keeper->settings = *settings;
    return TUMBLE_OK;
}

tumble_status_t tumble_keeper_configure(tumble_keeper_t *keeper, const tumble_sets_settings_t *settings)
{
    const bool others = tumble_keeper_rules_are_other(keeper);
    const tumble_status_t status = tumble_keeper_change(keeper, settings);
    keeper->rules = others ? keeper->rules : tumble_keeper_rules(keeper);
    return status;
}

/* Rules. */

#define NUMBERS_BYTES (offsetof(tumble_commit_limits_t, flags))

static_assert((offsetof(tumble_commit_limits_t, uncertainty) == 0U) &&
                  (NUMBERS_BYTES == (sizeof(float) * ((3U * TUMBLE_COEFFICIENTS) + 1U))),
              "the numbers of the limits are told by their bytes: nothing may lie between them");

/* Of all that the rules go by. Of this machine alone: it is never kept. */
static uint32_t fingerprint(const tumble_commit_limits_t *limits, const double *gravity_limit_g)
{
    uint32_t crc = tumble_crc32(0, (const uint8_t *)limits, (uint32_t)NUMBERS_BYTES);
    crc = tumble_crc32(crc, &limits->flags, 1U);
    return tumble_crc32(crc, (const uint8_t *)gravity_limit_g, (uint32_t)sizeof *gravity_limit_g);
}

uint32_t tumble_keeper_rules(const tumble_keeper_t *keeper)
{
    return fingerprint(&keeper->settings.limits, &keeper->navcomp->procedure_config.gravity_limit_g);
}

uint32_t tumble_keeper_rules_of_board(const tumble_keeper_t *keeper)
{
    return fingerprint(&keeper->config->sets.settings->limits, &keeper->navcomp->config->procedure->gravity_limit_g);
}

bool tumble_keeper_rules_are_other(const tumble_keeper_t *keeper)
{
    return tumble_keeper_rules(keeper) != keeper->rules;
}

uint16_t tumble_keeper_rules_flag(const tumble_keeper_t *keeper)
{
    const bool other = tumble_keeper_rules_are_other(keeper) || tumble_service_is_open(keeper->navcomp);
    return other ? TUMBLE_SET_OTHER_RULES : 0U;
}

/* The calendar. */

/* Whole seconds. A division of 64 bits would link 700 bytes of library that nothing else here needs, so divide as
 * doubles and correct what they round. */
uint64_t tumble_keeper_whole_s(uint64_t us)
{
    const uint64_t seconds = tumble_whole((double)us / (double)TUMBLE_US_PER_S);
    const uint64_t rest_us = us - (seconds * TUMBLE_US_PER_S); /* wraps where a second was rounded up */
    uint64_t whole_s = seconds;
    if (rest_us >= (2U * TUMBLE_US_PER_S)) {
        whole_s--;
    } else if (rest_us >= TUMBLE_US_PER_S) {
        whole_s++;
    } else {
        /* nothing was rounded */
    }
    return whole_s;
}

uint64_t tumble_keeper_utc_s(const tumble_keeper_t *keeper)
{
    return keeper->has_utc ? tumble_keeper_whole_s(keeper->utc_us + keeper->now_us) : 0U;
}

uint64_t tumble_keeper_age_s(const tumble_keeper_t *keeper)
{
    const uint64_t utc_s = tumble_keeper_utc_s(keeper);
    if ((keeper->active_utc_s != 0U) && (utc_s >= keeper->active_utc_s)) {
        return utc_s - keeper->active_utc_s;
    }
    return tumble_keeper_whole_s(keeper->now_us - keeper->active_us);
}

bool tumble_keeper_is_ahead(const tumble_keeper_t *keeper, uint64_t date_utc_s, uint64_t slack_s)
{
    const uint64_t utc_s = tumble_keeper_utc_s(keeper);
    return (utc_s != 0U) && (date_utc_s > (utc_s + slack_s));
}

uint8_t tumble_keeper_due(const tumble_keeper_t *keeper)
{
    const tumble_sets_settings_t *settings = &keeper->settings;
    unsigned due = 0;
    if (!keeper->has_active) {
        due |= TUMBLE_DUE_NO_SET;
    } else if ((settings->interval_s != 0U) && (tumble_keeper_age_s(keeper) >= settings->interval_s)) {
        due |= TUMBLE_DUE_TIME;
    } else {
        /* not by time */
    }
    if ((settings->temperature_half_c != 0U) && (keeper->off_temperature >= settings->temperature_samples)) {
        due |= TUMBLE_DUE_TEMPERATURE;
    }
    due |= (keeper->has_active && tumble_keeper_is_ahead(keeper, keeper->active_utc_s, TUMBLE_SETS_CLOCK_SLACK_S))
               ? (unsigned)TUMBLE_DUE_DATE
               : 0U;
    due |= keeper->decayed ? (unsigned)TUMBLE_DUE_DECAYED : 0U;
    due |= tumble_store_has_newer(&keeper->store) ? (unsigned)TUMBLE_DUE_NEWER : 0U;
    return (uint8_t)due;
}

bool tumble_keeper_is_inhibited(const tumble_keeper_t *keeper)
{
    const tumble_sets_config_t *config = &keeper->config->sets;
    return (keeper->now_us < keeper->inhibit_us) || ((config->inhibited != NULL) && config->inhibited(config->context));
}

/* A run that waits in FAULT keeps what it has measured: the table rests, and RESUME is refused. A run that began
 * between two readings of a bouncing contact is given up as well. */
static void hold_off(tumble_keeper_t *keeper, uint64_t now_us)
{
    tumble_navcomp_t *navcomp = keeper->navcomp;
    keeper->now_us = now_us;
    const bool inhibited = tumble_keeper_is_inhibited(keeper);
    const bool begins = inhibited && !keeper->was_inhibited;
    const bool run = tumble_run_is_on(navcomp) && (tumble_run_state(navcomp) != TUMBLE_STATE_FAULT);
    const tumble_stand_state_t stand = tumble_stand_state(&navcomp->stand);
    const bool turning = (stand == TUMBLE_STAND_MOVING) || (stand == TUMBLE_STAND_HOMING);
    keeper->was_inhibited = inhibited;
    if (!inhibited || (!run && (!begins || !turning))) {
        return;
    }
    tumble_count(&keeper->counters.inhibited);
    if (run) {
        tumble_procedure_give_up(&navcomp->procedure, TUMBLE_REASON_INHIBITED);
    } else {
        tumble_stand_stop(&navcomp->stand);
    }
}

void tumble_keeper_pause(tumble_keeper_t *keeper)
{
    keeper->pause_us = keeper->now_us + ((uint64_t)keeper->settings.pause_s * TUMBLE_US_PER_S);
}

/* Do not start by itself while somebody should look first: at the table, which was not seen to stop or which somebody else
 * turns, at a proposal, at a run that can be resumed. */
TUMBLE_ONE_COPY static bool may_start(tumble_keeper_t *keeper)
{
    const tumble_stand_fault_t fault = tumble_stand_fault(&keeper->navcomp->stand);
    const bool wanted = ((keeper->settings.flags & TUMBLE_SETS_STARTS) != 0U) &&
                        ((tumble_keeper_due(keeper) & ~(unsigned)TUMBLE_DUE_NEWER) != 0U);
    if (!wanted || tumble_run_is_on(keeper->navcomp) || tumble_keeper_is_inhibited(keeper) ||
        (keeper->now_us < keeper->pause_us) || (keeper->resumable != 0U) || (fault == TUMBLE_STAND_FAULT_STOP) ||
        (fault == TUMBLE_STAND_FAULT_FOREIGN) || tumble_store_has(&keeper->store, TUMBLE_SET_PROPOSAL)) {
        return false;
    }
    tumble_keeper_pause(keeper);
    tumble_count(&keeper->counters.self_started);
    return true;
}

static void watch_temperature(tumble_keeper_t *keeper, int8_t half_c)
{
    const int off = (int)half_c - (int)keeper->active_half_c;
    const int limit = (int)keeper->settings.temperature_half_c;
    if (!keeper->has_active_half_c || ((off <= limit) && (off >= -limit))) {
        keeper->off_temperature = 0;
    } else if (keeper->off_temperature < UINT16_MAX) {
        keeper->off_temperature++;
    } else {
        /* long enough */
    }
}

static void note_temperature(tumble_keeper_t *keeper, int8_t temperature_half_c, bool averaged)
{
    watch_temperature(keeper, temperature_half_c);
    if (averaged) {
        const int above_coldest = (int)temperature_half_c - (int)INT8_MIN;
        const int below_warmest = (int)INT8_MAX - (int)temperature_half_c;
        const tumble_margins_t seen = {(uint8_t)above_coldest, (uint8_t)below_warmest};
        tumble_checkpoint_narrow(&keeper->checkpoint, seen);
        keeper->warmth_half_c += temperature_half_c;
        keeper->warm_samples++;
    }
}

/* What the host tells. */

static uint64_t clock_us(const tumble_keeper_t *keeper)
{
    const tumble_port_t *port = keeper->navcomp->config->port;
    return port->now_us(port->context);
}

tumble_status_t tumble_keeper_set_utc(tumble_keeper_t *keeper, uint64_t utc_s)
{
    if (utc_s > TUMBLE_SETS_MAX_UTC_S) {
        return TUMBLE_E_ARGUMENT;
    }
    keeper->has_utc = (utc_s != 0U);
    keeper->utc_us = (utc_s * TUMBLE_US_PER_S) - clock_us(keeper); /* modulo 2^64, as is adding the clock again */
    return TUMBLE_OK;
}

void tumble_keeper_inhibit(tumble_keeper_t *keeper, uint16_t seconds)
{
    keeper->inhibit_us = (seconds != 0U) ? (clock_us(keeper) + ((uint64_t)seconds * TUMBLE_US_PER_S)) : 0U;
    keeper->navcomp->due_us = 0; /* what it ends waits for a step */
}

/* The memory. */

bool tumble_keeper_busy(const tumble_keeper_t *keeper)
{
    return tumble_store_busy(&keeper->store) || tumble_history_busy(&keeper->history) ||
           tumble_checkpoint_busy(&keeper->checkpoint) || tumble_parameters_busy(&keeper->parameters);
}

bool tumble_keeper_has_work(const tumble_keeper_t *keeper)
{
    return tumble_keeper_busy(keeper) || keeper->stale || (keeper->task != (uint8_t)TASK_NONE) || (keeper->wants != 0U);
}

TUMBLE_ONE_COPY void tumble_keeper_fail(tumble_keeper_t *keeper, tumble_status_t status)
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
static void report_decay(tumble_keeper_t *keeper)
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
static void report_state(tumble_keeper_t *keeper)
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
    if (!tumble_keeper_has_work(keeper) && may_start(keeper)) {
        (void)tumble_navcomp_obey(keeper->navcomp, TUMBLE_COMMAND_START, 0);
        tumble_keeper_follow_run(keeper);
    }
}

/* A step of the whole-model test, which needs no memory, is followed by the next at once. */
static uint64_t step(void *context, uint64_t now_us)
{
    tumble_keeper_t *keeper = context;
    hold_off(keeper, now_us);
    tumble_keeper_follow_run(keeper);
    work(keeper);
    start_if_due(keeper);
    report_decay(keeper);
    report_state(keeper);
    const bool computes = (keeper->task == (uint8_t)TASK_WHOLE_MODEL) && !tumble_keeper_busy(keeper);
    return tumble_keeper_has_work(keeper) ? (now_us + (computes ? 0U : RETRY_US)) : UINT64_MAX;
}

static void see_sample(void *context, const tumble_block_sample_t *sample, bool averaged)
{
    tumble_keeper_t *keeper = context;
    const tumble_block_counters_t *block = &keeper->navcomp->block.counters;
    note_temperature(keeper, sample->temperature_half_c, averaged);
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
    switch (command) {
    case TUMBLE_COMMAND_ACCEPT:
        return want_accepted(keeper);
    case TUMBLE_COMMAND_DISCARD:
        return want(keeper, WANT_DISCARD, TUMBLE_SET_PROPOSAL);
    case TUMBLE_COMMAND_ROLLBACK:
        return want(keeper, WANT_ROLLBACK, TUMBLE_SET_PREVIOUS);
    case TUMBLE_COMMAND_RESUME:
        return tumble_keeper_is_idle(keeper) ? tumble_keeper_resume(keeper)
                                             : tumble_navcomp_obey(keeper->navcomp, command, argument);
    default:
        return tumble_navcomp_obey(keeper->navcomp, command, argument);
    }
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
    tumble_keeper_follow_run(keeper); /* what ended before must be seen before anything begins anew */
    if (!is_allowed(keeper, wanted)) {
        return TUMBLE_E_STATE;
    }
    const tumble_status_t status = obey(keeper, wanted, argument);
    tumble_keeper_follow_run(keeper);
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
    return (length != 0U) && (length <= TUMBLE_SET_SERIAL_BYTES) && settings_valid(config->settings);
}

static tumble_status_t open_memory(tumble_keeper_t *keeper, const tumble_nv_t *nv)
{
    tumble_status_t status = tumble_store_init(&keeper->store, nv);
    if (status == TUMBLE_OK) {
        status = tumble_history_init(&keeper->history, nv);
    }
    const tumble_thermal_sets_t *thermal = keeper->config->sets.thermal;
    if (thermal != NULL) {
        keeper->store.read_set = thermal->read_set;
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
