#include "navcomp/keeper.h"

#include "core/arith.h"
#include "navcomp/fingerprint.h"
#include "navcomp/keeper_objects.h"
#include "navcomp/keeper_values.h"
#include "navcomp/navcomp_internal.h"
#include "navcomp/uncertainty.h"

#include <stddef.h>

#define BOOT_CALLS 2048 /* of the memory: more than it takes to look through all that is kept */
#define RETRY_US 1000U  /* to the next step of the sets, which may call the memory */

static_assert(TUMBLE_MAX_POSITIONS <= 64, "a position is one bit of 64");

/* What the sets know of the run and the stand. */

static uint64_t measured_positions(const tumble_navcomp_t *navcomp)
{
    uint64_t measured = 0;
    for (uint8_t p = 0; p < navcomp->procedure_config.schedule->position_count; p++) {
        if (tumble_procedure_has_mean(&navcomp->procedure, p)) {
            measured |= UINT64_C(1) << p;
        }
    }
    return measured;
}

void tumble_keeper_look(tumble_keeper_t *keeper)
{
    const tumble_navcomp_t *navcomp = keeper->navcomp;
    const tumble_stand_state_t stand = tumble_stand_state(&navcomp->stand);
    const tumble_stand_fault_t fault = tumble_stand_fault(&navcomp->stand);
    const tumble_state_t state = tumble_run_state(navcomp);
    tumble_sets_run_t *run = &keeper->run;
    run->measured = measured_positions(navcomp);
    run->gravity_limit_g = navcomp->procedure_config.gravity_limit_g;
    run->estimator = (uint8_t)navcomp->procedure_config.estimate;
    run->on = tumble_run_is_on(navcomp);
    run->idle = (state == TUMBLE_STATE_IDLE);
    run->waits = (state == TUMBLE_STATE_FAULT);
    run->turning = (stand == TUMBLE_STAND_MOVING) || (stand == TUMBLE_STAND_HOMING);
    /* It was not seen to stop, or somebody else turns it. */
    run->to_be_looked_at = (fault == TUMBLE_STAND_FAULT_STOP) || (fault == TUMBLE_STAND_FAULT_FOREIGN);
    run->serviced = tumble_service_is_open(navcomp);
    run->memory_taken = tumble_parameters_busy(&keeper->parameters);
}

/* What stays as long as there is power. */
static void describe(tumble_keeper_t *keeper)
{
    const tumble_navcomp_t *navcomp = keeper->navcomp;
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    tumble_sets_run_t *run = &keeper->run;
    run->schedule = config->schedule;
    run->averaging = tumble_procedure_averages(&navcomp->procedure);
    run->stand = (navcomp->config->declared != NULL) ? navcomp->config->declared->stand : NULL;
    run->v_per_count = config->v_per_count;
    run->board_gravity_limit_g = navcomp->config->procedure->gravity_limit_g;
    tumble_keeper_look(keeper);
}

static uint32_t ask_fingerprint(const void *self, uint32_t sequence)
{
    const tumble_keeper_t *keeper = self;
    return tumble_run_fingerprint(keeper->navcomp, keeper->config->sets.serial, sequence);
}

static tumble_status_t ask_uncertainty(const void *self, uint16_t coefficients, tumble_uncertainty_t *uncertainty)
{
    const tumble_keeper_t *keeper = self;
    return keeper->config->uncertainty(keeper->navcomp, coefficients, uncertainty);
}

static tumble_status_t ask_norm(const void *self, const double attitude[3], double *norm_g)
{
    const tumble_keeper_t *keeper = self;
    return keeper->config->norm(keeper->navcomp, attitude, norm_g);
}

/* What happens to the run. */

static double closure_v(const tumble_navcomp_t *navcomp)
{
    double largest_g = 0.0;
    for (uint8_t m = 0; m < navcomp->procedure_config.schedule->mounting_count; m++) {
        const double closure_g = tumble_procedure_closure_g(&navcomp->procedure, m);
        largest_g = tumble_exceeds(closure_g, largest_g) ? closure_g : largest_g;
    }
    return largest_g * tumble_abs(navcomp->procedure_config.nominal_scale_v_per_g);
}

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

static void end_run(tumble_keeper_t *keeper)
{
    const tumble_navcomp_t *navcomp = keeper->navcomp;
    tumble_result_t result;
    if (tumble_navcomp_result(navcomp, &result) == TUMBLE_OK) {
        keeper->disturbed = keeper->disturbed || ((balance(navcomp) - keeper->undisturbed) > (uint32_t)INT32_MAX);
        const tumble_finished_run_t run = {.coefficients = result.coefficients,
                                           .check = result.check,
                                           .closure_v = closure_v(navcomp),
                                           .stand_crc = tumble_stand_fingerprint(navcomp),
                                           .disturbed = keeper->disturbed};
        tumble_sets_run_done(&keeper->sets, &run);
    } else if (keeper->run.idle) {
        tumble_sets_run_forgotten(&keeper->sets);
    } else {
        tumble_sets_run_given_up(&keeper->sets);
    }
}

/* Tell what has happened since the look before. */
static void tell(tumble_keeper_t *keeper)
{
    const bool was_on = keeper->sets.run_was_on;
    if (keeper->run.on && !was_on) {
        begin_part(keeper, keeper->disturbed && (keeper->run.measured != 0U));
        tumble_sets_run_began(&keeper->sets);
    }
    if (!keeper->run.on && was_on) {
        end_run(keeper);
    }
    if (keeper->run.on) {
        tumble_sets_run_measured(&keeper->sets);
    }
}

/* The step. */

static void hold_off(tumble_keeper_t *keeper, uint64_t now_us)
{
    tumble_navcomp_t *navcomp = keeper->navcomp;
    const tumble_sets_wish_t wish = tumble_sets_hold_off(&keeper->sets, now_us);
    if (wish == TUMBLE_SETS_GIVE_UP) {
        tumble_procedure_give_up(&navcomp->procedure, TUMBLE_REASON_INHIBITED);
        tumble_keeper_look(keeper);
    } else if (wish == TUMBLE_SETS_STOP) {
        tumble_stand_stop(&navcomp->stand);
    } else {
        /* nobody holds it off */
    }
}

static void resume(tumble_keeper_t *keeper)
{
    const bool done = (tumble_navcomp_obey(keeper->navcomp, TUMBLE_COMMAND_RESUME, 0) == TUMBLE_OK);
    tumble_keeper_look(keeper);
    if (done) {
        begin_part(keeper, false); /* a reset may have taken the counters away */
    }
    tumble_sets_run_goes_on(&keeper->sets, done);
}

static void work(tumble_keeper_t *keeper)
{
    tumble_procedure_t *procedure = &keeper->navcomp->procedure;
    tumble_sets_event_t event;
    tumble_sets_work(&keeper->sets, &event);
    if (event.wish == TUMBLE_SETS_RESTORE) {
        const bool done = (tumble_procedure_restore(procedure, event.index, &event.mean) == TUMBLE_OK);
        tumble_sets_restored(&keeper->sets, event.index, done);
    } else if (event.wish == TUMBLE_SETS_RESUME) {
        resume(keeper);
    } else {
        /* all is done */
    }
}

/* What is saved is the board's own. */
static void step_parameters(tumble_keeper_t *keeper)
{
    tumble_parameters_step(&keeper->parameters);
    const uint8_t event = keeper->parameters.event;
    keeper->parameters.event = TUMBLE_PARAMETERS_NOTHING;
    tumble_keeper_look(keeper);
    if (event == (uint8_t)TUMBLE_PARAMETERS_APPLIED) {
        tumble_sets_rules_applied(&keeper->sets);
    } else if (event == (uint8_t)TUMBLE_PARAMETERS_WRITTEN) {
        tumble_sets_rules_saved(&keeper->sets);
    } else {
        /* nothing has changed */
    }
}

/* The error register has one bit for all errors of the maker, and a reset of the communication clears it. So the message
 * is sent again as long as the bit is not set. */
static void tell_decay(tumble_keeper_t *keeper)
{
    tumble_emcy_t *emcy = &keeper->navcomp->node.emcy;
    const tumble_sets_t *sets = &keeper->sets;
    const bool told = (emcy->error_register & TUMBLE_ERROR_MANUFACTURER) != 0U;
    if (sets->decayed && !told) {
        tumble_emcy_tell(emcy, TUMBLE_KEEPER_EMCY_DECAYED, TUMBLE_ERROR_MANUFACTURER, tumble_sets_counter(sets));
        keeper->decay_told = true;
    } else if (!sets->decayed && keeper->decay_told) {
        tumble_emcy_clear(emcy, TUMBLE_ERROR_MANUFACTURER);
        keeper->decay_told = false;
    } else {
        /* nothing has changed */
    }
}

static void start_if_due(tumble_keeper_t *keeper)
{
    if (!tumble_sets_has_work(&keeper->sets) && tumble_sets_start(&keeper->sets)) {
        (void)tumble_navcomp_obey(keeper->navcomp, TUMBLE_COMMAND_START, 0);
        tumble_keeper_look(keeper);
        tell(keeper);
    }
}

static void step(void *context, uint64_t now_us)
{
    tumble_keeper_t *keeper = context;
    tumble_keeper_look(keeper);
    hold_off(keeper, now_us);
    tell(keeper);
    if (keeper->run.memory_taken && !tumble_sets_memory_busy(&keeper->sets)) {
        step_parameters(keeper);
    } else {
        work(keeper);
    }
    start_if_due(keeper);
    tell_decay(keeper);
    if (tumble_sets_news(&keeper->sets)) {
        tumble_pdo_trigger(&keeper->navcomp->node.pdos, TUMBLE_KEEPER_PDO);
    }
    const uint64_t pause_us = tumble_sets_computes(&keeper->sets) ? 0U : RETRY_US;
    keeper->due_us = tumble_sets_has_work(&keeper->sets) ? (now_us + pause_us) : UINT64_MAX;
}

static uint64_t next_us(const void *context)
{
    return ((const tumble_keeper_t *)context)->due_us;
}

static void see_sample(void *context, const tumble_block_sample_t *sample, bool averaged)
{
    tumble_keeper_t *keeper = context;
    const tumble_block_counters_t *block = &keeper->navcomp->block.counters;
    tumble_sets_sample(&keeper->sets, sample->temperature_half_c, averaged);
    tumble_at_rest_take(&keeper->at_rest, keeper->navcomp->procedure_config.averaging, sample,
                        block->repeated + block->reordered);
}

/* Commands. */

/* Does it begin or go on with a run, or turn the table? */
static bool is_inhibitable(tumble_command_t command)
{
    return (command == TUMBLE_COMMAND_START) || (command == TUMBLE_COMMAND_RESUME) ||
           (command == TUMBLE_COMMAND_CONFIRM_MOUNTING) || (command == TUMBLE_COMMAND_REPEAT_POSITION) ||
           (command == TUMBLE_COMMAND_REPEAT_MOUNTING) || (command == TUMBLE_COMMAND_HOME_AXIS) ||
           (command == TUMBLE_COMMAND_TURN_AXIS);
}

/* A proposal is named once: what was read is what becomes active. */
static tumble_status_t accept(tumble_keeper_t *keeper)
{
    tumble_navcomp_objects_t *staged = tumble_staged(keeper->navcomp);
    const uint32_t named = staged->command_proposal;
    staged->command_proposal = 0;
    return tumble_sets_accept(&keeper->sets, named);
}

static tumble_status_t obey(tumble_keeper_t *keeper, tumble_command_t command, uint8_t argument)
{
    tumble_status_t status;
    switch (command) {
    case TUMBLE_COMMAND_ACCEPT:
        status = accept(keeper);
        break;
    case TUMBLE_COMMAND_DISCARD:
        status = tumble_sets_discard(&keeper->sets);
        break;
    case TUMBLE_COMMAND_ROLLBACK:
        status = tumble_sets_rollback(&keeper->sets);
        break;
    case TUMBLE_COMMAND_RESUME:
        status = keeper->run.idle ? tumble_sets_resume(&keeper->sets)
                                  : tumble_navcomp_obey(keeper->navcomp, command, argument);
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
    tumble_keeper_look(keeper);
    tell(keeper); /* what ended before must be seen before anything begins anew */
    const bool starts = (wanted == TUMBLE_COMMAND_START);
    const bool begins =
        starts || (wanted == TUMBLE_COMMAND_REPEAT_POSITION) || (wanted == TUMBLE_COMMAND_REPEAT_MOUNTING);
    const bool too_early = starts && tumble_parameters_reading(&keeper->parameters); /* by the board's values */
    if (!tumble_sets_allow(&keeper->sets, begins, too_early, is_inhibitable(wanted))) {
        return TUMBLE_E_STATE;
    }
    const tumble_status_t status = obey(keeper, wanted, argument);
    tumble_keeper_look(keeper);
    tell(keeper);
    if ((wanted == TUMBLE_COMMAND_HOME_AXIS) || (wanted == TUMBLE_COMMAND_TURN_AXIS)) {
        tumble_sets_pause(&keeper->sets); /* somebody is at work there */
    }
    return status;
}

void tumble_keeper_inhibit(tumble_keeper_t *keeper, uint16_t seconds)
{
    tumble_sets_inhibit(&keeper->sets, seconds);
    keeper->navcomp->due_us = 0; /* what it ends waits for a step */
}

/* Getting ready. */

static void reset(void *context)
{
    tumble_keeper_t *keeper = context;
    tumble_keeper_look(keeper);
    tumble_sets_reset(&keeper->sets);
    (void)tumble_at_rest_begin(&keeper->at_rest, 0);
    tumble_parameters_restore(&keeper->parameters);
}

static void boot(tumble_keeper_t *keeper)
{
    for (int calls = 0; (calls < BOOT_CALLS) && tumble_sets_busy(&keeper->sets); calls++) {
        if (tumble_sets_memory_busy(&keeper->sets)) {
            tumble_sets_step_memory(&keeper->sets);
        } else {
            step_parameters(keeper);
        }
    }
}

static tumble_status_t init(void *context, tumble_navcomp_t *navcomp)
{
    tumble_keeper_t *keeper = context;
    const tumble_port_t *port = navcomp->config->port;
    if ((keeper == NULL) || (keeper->config == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    *keeper = (tumble_keeper_t){.config = keeper->config, .navcomp = navcomp};
    keeper->owner = (tumble_sets_owner_t){
        .port = port,
        .run = &keeper->run,
        .self = keeper,
        .fingerprint = ask_fingerprint,
        .uncertainty = (keeper->config->uncertainty != NULL) ? ask_uncertainty : NULL,
        .norm = (keeper->config->norm != NULL) ? ask_norm : NULL,
        .misfit = &navcomp->procedure.work.found.misfit,
    };
    describe(keeper);
    const tumble_status_t status = tumble_sets_init(&keeper->sets, &keeper->config->sets, &keeper->owner);
    if (status == TUMBLE_E_ARGUMENT) {
        return status;
    }
    tumble_parameters_init(&keeper->parameters, port->nv, &navcomp->node, &keeper->sets.store);
    tumble_keeper_look(keeper);
    boot(keeper);
    tumble_sets_booted(&keeper->sets, status);
    return status;
}

const tumble_keeping_t tumble_keeper_calls = {
    .init = init,
    .step = step,
    .next_us = next_us,
    .sample = see_sample,
    .command = command,
    .reset = reset,
    .objects = &tumble_keeper_extension,
};
