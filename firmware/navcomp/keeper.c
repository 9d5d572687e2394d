#include "navcomp/keeper.h"

#include "navcomp/keeper_internal.h"
#include "navcomp/keeper_objects.h"
#include "navcomp/keeper_values.h"
#include "navcomp/navcomp_internal.h"

#include <stddef.h>
#include <string.h>

#define BOOT_CALLS 2048 /* of the memory: more than it takes to look through all that is kept */
#define RETRY_US 1000U  /* to the next call of the memory */

void tumble_keeper_fail(tumble_keeper_t *keeper, tumble_status_t status)
{
    keeper->status = (uint8_t)status;
    tumble_count(&keeper->counters.failures);
}

bool tumble_keeper_is_busy(const tumble_keeper_t *keeper)
{
    return tumble_store_busy(&keeper->store) || tumble_history_busy(&keeper->history) ||
           tumble_checkpoint_busy(&keeper->checkpoint) || tumble_parameters_busy(&keeper->parameters);
}

bool tumble_keeper_has_work(const tumble_keeper_t *keeper)
{
    return tumble_keeper_is_busy(keeper) || keeper->stale || (keeper->task != (uint8_t)TASK_NONE) ||
           (keeper->wants != 0U);
}

/* Jobs of the store. */

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

static void count_job(tumble_keeper_t *keeper, uint8_t job)
{
    tumble_keeper_counters_t *counters = &keeper->counters;
    uint32_t *const counted[JOB_ROLLBACK + 1] = {
        [JOB_COMMIT] = &counters->committed, [JOB_HOLD] = &counters->held,         [JOB_ACCEPT] = &counters->accepted,
        [JOB_DISCARD] = &counters->discarded, [JOB_ROLLBACK] = &counters->rolled_back,
    };
    tumble_count(counted[job]);
}

static void end_job(tumble_keeper_t *keeper)
{
    static const uint8_t verdicts[JOB_ROLLBACK + 1] = {
        [JOB_COMMIT] = TUMBLE_VERDICT_COMMITTED,     [JOB_HOLD] = TUMBLE_VERDICT_HELD,
        [JOB_ACCEPT] = TUMBLE_VERDICT_ACCEPTED,      [JOB_DISCARD] = TUMBLE_VERDICT_DISCARDED,
        [JOB_ROLLBACK] = TUMBLE_VERDICT_ROLLED_BACK,
    };
    const uint8_t job = keeper->job;
    const tumble_status_t outcome = tumble_store_outcome(&keeper->store);
    keeper->job = JOB_NONE;
    keeper->stale = true;
    keeper->history_tries = TUMBLE_KEEPER_TRIES;
    if (job == (uint8_t)JOB_NONE) {
        return; /* it only looked what is there */
    }
    if (outcome != TUMBLE_OK) {
        keeper->verdict = TUMBLE_VERDICT_FAILED;
        tumble_keeper_fail(keeper, outcome);
        return;
    }
    keeper->verdict = verdicts[job];
    count_job(keeper, job);
    if ((job == (uint8_t)JOB_COMMIT) || (job == (uint8_t)JOB_HOLD)) {
        tumble_keeper_end_checkpoint(keeper); /* the run has come to its end */
    }
}

/* Commands about sets wait until the memory is free. */
static void begin_command(tumble_keeper_t *keeper)
{
    if ((keeper->wants & WANT_ACCEPT) != 0U) {
        tumble_keeper_begin_job(keeper, JOB_ACCEPT, tumble_keeper_accept(keeper));
    } else if ((keeper->wants & WANT_DISCARD) != 0U) {
        tumble_keeper_begin_job(keeper, JOB_DISCARD, tumble_store_discard(&keeper->store));
    } else {
        tumble_keeper_begin_job(keeper, JOB_ROLLBACK, tumble_store_rollback(&keeper->store));
    }
    keeper->wants &= (uint8_t)~(unsigned)WANT_COMMANDS;
}

/* The step. */

/* Go on with what the memory is doing: one call. */
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
            tumble_keeper_try_history_again(keeper);
        }
    } else if (tumble_checkpoint_busy(&keeper->checkpoint)) {
        status = tumble_keeper_step_checkpoint(keeper);
    } else {
        tumble_parameters_step(&keeper->parameters);
        tumble_keeper_note_rules(keeper);
    }
    if ((status != TUMBLE_OK) && (status != TUMBLE_E_PORT_BUSY)) {
        tumble_keeper_fail(keeper, status);
    }
}

/* One call of the memory, or one job begun. */
static void work(tumble_keeper_t *keeper)
{
    if (tumble_keeper_is_busy(keeper)) {
        step_memory(keeper);
    } else if (keeper->stale) {
        tumble_keeper_refresh(keeper);
    } else if (keeper->task == (uint8_t)TASK_RESTORE) {
        tumble_keeper_restore(keeper);
    } else if (keeper->task != (uint8_t)TASK_NONE) {
        tumble_keeper_judge(keeper);
    } else if ((keeper->wants & WANT_RECORD_DECAY) != 0U) {
        tumble_keeper_record_decay(keeper);
    } else if ((keeper->wants & WANT_COMMANDS) != 0U) {
        begin_command(keeper);
    } else {
        tumble_keeper_keep(keeper);
    }
}

/* The PDO goes when one of these has changed, and by its event timer. */
static void show(tumble_keeper_t *keeper)
{
    const uint32_t shown =
        ((uint32_t)keeper->objections << 16) | ((uint32_t)keeper->verdict << 8) | tumble_keeper_due(keeper);
    if (keeper->shown != shown) {
        keeper->shown = shown;
        tumble_pdo_trigger(&keeper->navcomp->node.pdos, TUMBLE_KEEPER_PDO);
    }
}

static void step(void *context, uint64_t now_us)
{
    tumble_keeper_t *keeper = context;
    keeper->now_us = now_us;
    tumble_keeper_obey_inhibit(keeper);
    tumble_keeper_watch(keeper);
    work(keeper);
    if (!tumble_keeper_has_work(keeper)) {
        tumble_keeper_start_if_due(keeper);
    }
    tumble_keeper_tell_decay(keeper);
    show(keeper);
    keeper->due_us = tumble_keeper_has_work(keeper) ? (now_us + RETRY_US) : UINT64_MAX;
}

static uint64_t next_us(const void *context)
{
    return ((const tumble_keeper_t *)context)->due_us;
}

/* Commands. */

/* A command about sets: allowed while no run is on, nothing is being decided, and there is what it is about. */
static bool is_free_to(const tumble_keeper_t *keeper, tumble_which_set_t which)
{
    return (keeper->task == (uint8_t)TASK_NONE) && ((keeper->wants & WANT_COMMANDS) == 0U) &&
           !tumble_run_is_on(keeper->navcomp) && tumble_store_has(&keeper->store, which);
}

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

/* The proposal that is meant is named by its CRC, once: what was read is what becomes active. */
static tumble_status_t want_accept(tumble_keeper_t *keeper)
{
    const uint32_t named = keeper->navcomp->objects.command_proposal;
    const bool other = (tumble_store_proposal(&keeper->store) != named) || (named == 0U);
    keeper->navcomp->objects.command_proposal = 0;
    if (other && is_free_to(keeper, TUMBLE_SET_PROPOSAL)) {
        tumble_count(&keeper->counters.refused);
        return TUMBLE_E_ARGUMENT;
    }
    keeper->accepted = named;
    return want(keeper, WANT_ACCEPT, TUMBLE_SET_PROPOSAL);
}

/* Does it begin or go on with a run, or turn the table? */
static bool is_inhibitable(tumble_command_t command)
{
    return (command == TUMBLE_COMMAND_START) || (command == TUMBLE_COMMAND_RESUME) ||
           (command == TUMBLE_COMMAND_CONFIRM_MOUNTING) || (command == TUMBLE_COMMAND_REPEAT_POSITION) ||
           (command == TUMBLE_COMMAND_REPEAT_MOUNTING) || (command == TUMBLE_COMMAND_HOME_AXIS) ||
           (command == TUMBLE_COMMAND_TURN_AXIS);
}

static tumble_status_t obey(tumble_keeper_t *keeper, tumble_command_t command, uint8_t argument)
{
    const bool idle = (tumble_run_state(keeper->navcomp) == TUMBLE_STATE_IDLE);
    tumble_status_t status;
    switch (command) {
    case TUMBLE_COMMAND_ACCEPT:
        status = want_accept(keeper);
        break;
    case TUMBLE_COMMAND_DISCARD:
        status = want(keeper, WANT_DISCARD, TUMBLE_SET_PROPOSAL);
        break;
    case TUMBLE_COMMAND_ROLLBACK:
        status = want(keeper, WANT_ROLLBACK, TUMBLE_SET_PREVIOUS);
        break;
    case TUMBLE_COMMAND_RESUME:
        status = idle ? tumble_keeper_resume(keeper) : tumble_navcomp_obey(keeper->navcomp, command, argument);
        break;
    default:
        status = tumble_navcomp_obey(keeper->navcomp, command, argument);
        break;
    }
    return status;
}

static tumble_status_t command(void *context, tumble_command_t wanted, uint8_t argument)
{
    tumble_keeper_t *keeper = context;
    tumble_keeper_watch(keeper); /* what ended before must be seen before anything begins anew */
    const bool begins = (wanted == TUMBLE_COMMAND_START) || (wanted == TUMBLE_COMMAND_REPEAT_POSITION) ||
                        (wanted == TUMBLE_COMMAND_REPEAT_MOUNTING);
    /* A run that began now would go by the board's values, or take the means away from the judge. */
    if (((wanted == TUMBLE_COMMAND_START) && tumble_parameters_reading(&keeper->parameters)) ||
        (begins && tumble_keeper_is_assessing(keeper))) {
        tumble_count(&keeper->counters.refused);
        return TUMBLE_E_STATE;
    }
    if (is_inhibitable(wanted)) {
        if (tumble_keeper_is_inhibited(keeper)) {
            tumble_count(&keeper->counters.inhibited);
            return TUMBLE_E_STATE;
        }
        keeper->was_inhibited = false; /* whatever the last step saw: the next one is to see when it begins again */
    }
    const tumble_status_t status = obey(keeper, wanted, argument);
    tumble_keeper_watch(keeper);
    if ((wanted == TUMBLE_COMMAND_HOME_AXIS) || (wanted == TUMBLE_COMMAND_TURN_AXIS)) {
        tumble_keeper_pause(keeper); /* somebody is at work there */
    }
    return status;
}

/* Getting ready. */

static bool is_usable(const tumble_keeper_config_t *config)
{
    if ((config == NULL) || (config->serial == NULL) || (config->settings == NULL)) {
        return false;
    }
    const uint8_t length = tumble_serial_length(config);
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

/* As after power-on: the board's settings, then what was saved. The sets stay what they are. */
static void reset(void *context)
{
    tumble_keeper_t *keeper = context;
    keeper->settings = *keeper->config->settings;
    keeper->rules = tumble_keeper_rules_of_board(keeper);
    if (tumble_keeper_is_assessing(keeper)) {
        keeper->verdict = TUMBLE_VERDICT_NONE; /* the means are gone; the checkpoint has them */
        keeper->task = TASK_NONE;
    }
    keeper->task = (keeper->task == (uint8_t)TASK_RESTORE) ? (uint8_t)TASK_NONE : keeper->task;
    (void)tumble_at_rest_begin(&keeper->at_rest, 0);
    keeper->stale = true; /* a run that is kept may fit again what the node goes by */
    tumble_parameters_restore(&keeper->parameters);
}

static tumble_status_t init(void *context, tumble_navcomp_t *navcomp)
{
    tumble_keeper_t *keeper = context;
    const tumble_port_t *port = navcomp->config->port;
    if ((keeper == NULL) || !is_usable(keeper->config)) {
        return TUMBLE_E_ARGUMENT;
    }
    *keeper = (tumble_keeper_t){.config = keeper->config,
                                .navcomp = navcomp,
                                .settings = *keeper->config->settings,
                                .history_tries = TUMBLE_KEEPER_TRIES};
    keeper->rules = tumble_keeper_rules_of_board(keeper);
    const tumble_status_t status = open_memory(keeper, port->nv);
    tumble_parameters_init(&keeper->parameters, port->nv, &navcomp->node);
    keeper->now_us = port->now_us(port->context);
    for (int calls = 0; (calls < BOOT_CALLS) && tumble_keeper_is_busy(keeper); calls++) {
        step_memory(keeper);
    }
    if ((status == TUMBLE_OK) && !tumble_keeper_is_busy(keeper)) {
        tumble_keeper_refresh(keeper);
    }
    keeper->active_us = keeper->now_us;
    keeper->stale = keeper->stale || tumble_keeper_is_busy(keeper);
    return status;
}

const tumble_keeping_t tumble_keeper_calls = {
    .init = init,
    .step = step,
    .next_us = next_us,
    .sample = tumble_keeper_sample,
    .command = command,
    .reset = reset,
    .objects = &tumble_keeper_extension,
};
