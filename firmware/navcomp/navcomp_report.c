#include "navcomp/navcomp_internal.h"

#include "core/arith.h"

#include <stddef.h>

/* Commands. */

static tumble_status_t confirm_angle(const tumble_navcomp_t *navcomp, double angle_deg)
{
    const tumble_stand_t *stand = &navcomp->stand;
    return tumble_stand_report(stand)->asks ? stand->kind->confirm(stand->self, angle_deg) : TUMBLE_E_STATE;
}

/* Between runs there may be a table to stop, in FAULT as well: then that is what was asked for. A table at rest is told
 * to stop all the same, but nothing is given up: TUMBLE_E_STATE. */
static tumble_status_t stop(tumble_navcomp_t *navcomp)
{
    const tumble_stand_t *stand = &navcomp->stand;
    const unsigned turns = (1U << (unsigned)TUMBLE_STAND_HOMING) | (1U << (unsigned)TUMBLE_STAND_MOVING) |
                           (1U << (unsigned)TUMBLE_STAND_FAULT);
    if (!tumble_run_is_on(navcomp) && (((turns >> (unsigned)tumble_stand_state(stand)) & 1U) != 0U)) {
        tumble_stand_stop(stand);
        return TUMBLE_OK;
    }
    return tumble_procedure_abort(&navcomp->procedure);
}

/* The stand answers TUMBLE_E_STAND_STATE when it is not in FAULT or cannot leave it now; a caller knows
 * TUMBLE_E_STATE. */
static tumble_status_t clear_fault(tumble_navcomp_t *navcomp)
{
    const tumble_status_t status = tumble_stand_clear_fault(&navcomp->stand);
    return (status == TUMBLE_OK) ? TUMBLE_OK : TUMBLE_E_STATE;
}

/* Home or turn the table for the validation of a fixture: never during a run, and within the cable's limits. */
static tumble_status_t serve(tumble_navcomp_t *navcomp, bool turn)
{
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    const tumble_stand_t *stand = &navcomp->stand;
    const double angle_deg = tumble_staged(navcomp)->command_angle;
    if (turn && (!tumble_is_finite(angle_deg) || tumble_exceeds(config->cable_min_deg, angle_deg) ||
                 tumble_exceeds(angle_deg, config->cable_max_deg))) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_run_is_on(navcomp) || !tumble_is_supervised(navcomp)) {
        return TUMBLE_E_STATE;
    }
    const tumble_status_t status = turn ? tumble_stand_move(stand, angle_deg) : tumble_stand_home(stand);
    return (status == TUMBLE_E_STAND_STATE) ? TUMBLE_E_STATE : status;
}

tumble_status_t tumble_navcomp_obey(tumble_navcomp_t *navcomp, tumble_command_t command, uint8_t argument)
{
    tumble_procedure_t *procedure = &navcomp->procedure;
    tumble_status_t status = TUMBLE_E_ARGUMENT;
    const bool was_on = tumble_run_is_on(navcomp);
    tumble_procedure_set_supervised(procedure, tumble_is_supervised(navcomp)); /* held from here on */
    switch (command) {
    case TUMBLE_COMMAND_NONE:
        status = TUMBLE_OK;
        break;
    case TUMBLE_COMMAND_START:
        status = tumble_procedure_start(procedure);
        break;
    case TUMBLE_COMMAND_ABORT:
        status = stop(navcomp);
        break;
    case TUMBLE_COMMAND_CONFIRM_MOUNTING:
        status = tumble_procedure_confirm_mounting(procedure, argument);
        break;
    case TUMBLE_COMMAND_CONFIRM_ANGLE:
        status = confirm_angle(navcomp, tumble_stand_report(&navcomp->stand)->asked_deg);
        break;
    case TUMBLE_COMMAND_REPEAT_POSITION:
        status = tumble_procedure_repeat_position(procedure, argument);
        break;
    case TUMBLE_COMMAND_REPEAT_MOUNTING:
        status = tumble_procedure_repeat_mounting(procedure, argument);
        break;
    case TUMBLE_COMMAND_RESUME:
        status = tumble_procedure_resume(procedure);
        break;
    case TUMBLE_COMMAND_CLEAR_FAULT:
        status = clear_fault(navcomp);
        break;
    case TUMBLE_COMMAND_HOME_AXIS:
    case TUMBLE_COMMAND_TURN_AXIS:
        status = serve(navcomp, command == TUMBLE_COMMAND_TURN_AXIS);
        break;
    case TUMBLE_COMMAND_ACCEPT:
    case TUMBLE_COMMAND_DISCARD:
    case TUMBLE_COMMAND_ROLLBACK:
        status = TUMBLE_E_STATE; /* there is no keeper to obey them */
        break;
    case TUMBLE_COMMAND_COUNT:
    default:
        break;
    }
    if (!was_on && tumble_run_is_on(navcomp)) {
        tumble_service_run_began(navcomp);
    }
    return status;
}

static tumble_status_t account(tumble_navcomp_t *navcomp, tumble_status_t status)
{
    if (status != TUMBLE_OK) {
        tumble_count(&navcomp->events.commands_refused);
    }
    navcomp->due_us = 0; /* what it set going waits for a step */
    return status;
}

tumble_status_t tumble_navcomp_command(tumble_navcomp_t *navcomp, tumble_command_t command, uint8_t argument)
{
    const tumble_keeping_t *keeping = navcomp->config->keeping;
    return account(navcomp, (keeping != NULL) ? keeping->command(navcomp->config->keeper, command, argument)
                                              : tumble_navcomp_obey(navcomp, command, argument));
}

tumble_status_t tumble_navcomp_turn(tumble_navcomp_t *navcomp, double angle_deg)
{
    navcomp->objects.command_angle = angle_deg;
    return tumble_navcomp_command(navcomp, TUMBLE_COMMAND_TURN_AXIS, 0);
}

tumble_status_t tumble_navcomp_accept(tumble_navcomp_t *navcomp, uint32_t proposal)
{
    navcomp->objects.command_proposal = proposal;
    return tumble_navcomp_command(navcomp, TUMBLE_COMMAND_ACCEPT, 0);
}

tumble_status_t tumble_navcomp_confirm_angle(tumble_navcomp_t *navcomp, double angle_deg)
{
    return account(navcomp, confirm_angle(navcomp, angle_deg));
}

/* The readable side. */

bool tumble_navcomp_request(const tumble_navcomp_t *navcomp, double *angle_deg)
{
    const tumble_stand_report_t *report = tumble_stand_report(&navcomp->stand);
    if (report->asks) {
        *angle_deg = report->asked_deg;
    }
    return report->asks;
}

void tumble_navcomp_progress(const tumble_navcomp_t *navcomp, tumble_navcomp_progress_t *progress)
{
    *progress = (tumble_navcomp_progress_t){0};
    tumble_procedure_progress(&navcomp->procedure, &progress->run);
    progress->has_mean =
        tumble_procedure_running(&navcomp->procedure, progress->mean_v, progress->standard_error_v) == TUMBLE_OK;
    progress->stand = tumble_stand_state(&navcomp->stand);
    progress->angle_deg = navcomp->stand.kind->angle_deg(navcomp->stand.self);
    progress->temperature_half_c = navcomp->temperature_half_c;
    progress->stand_fault = (uint8_t)tumble_stand_fault(&navcomp->stand);
    const tumble_stand_report_t *report = tumble_stand_report(&navcomp->stand);
    progress->limited = report->limited ? 1U : 0U;
    progress->rung = report->rung;
    progress->refusal = report->refusal;
    progress->as_byte.state = (uint8_t)progress->run.state;
    progress->as_byte.reason = (uint8_t)progress->run.reason;
    progress->as_byte.failed_in = (uint8_t)progress->run.failed_in;
    progress->as_byte.status = (uint8_t)progress->run.status;
    progress->as_byte.stand = (uint8_t)progress->stand;
    progress->as_byte.stays_bolted = (uint8_t)progress->run.stays_bolted;
}

tumble_status_t tumble_navcomp_result(const tumble_navcomp_t *navcomp, tumble_result_t *result)
{
    return tumble_procedure_result(&navcomp->procedure, result);
}

void tumble_navcomp_counters(const tumble_navcomp_t *navcomp, tumble_navcomp_counters_t *counters)
{
    counters->link = navcomp->node.link.counters;
    counters->events = navcomp->events;
    counters->block = navcomp->block.counters;
    counters->averaging = tumble_procedure_averages(&navcomp->procedure)->counters;
    counters->procedure = *tumble_procedure_counters(&navcomp->procedure);
    counters->stop = tumble_stand_report(&navcomp->stand)->stop;
}

tumble_stand_refusal_t tumble_navcomp_drive_refusal(const tumble_navcomp_t *navcomp)
{
    return tumble_stand_report(&navcomp->stand)->refusal;
}

const tumble_procedure_t *tumble_navcomp_procedure(const tumble_navcomp_t *navcomp)
{
    return &navcomp->procedure;
}
