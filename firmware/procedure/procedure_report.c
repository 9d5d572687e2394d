#include "procedure/procedure_internal.h"

#include "core/accumulator.h"
#include "core/arith.h"
#include "core/closure.h"
#include "core/one_copy.h"

#include <stddef.h>

uint8_t tumble_mounting_index(const tumble_schedule_t *schedule, uint8_t index)
{
    return (uint8_t)(tumble_schedule_mounting_of(schedule, index) - schedule->mountings);
}

bool tumble_is_measured(const tumble_procedure_t *procedure, uint8_t index)
{
    return tumble_averaging_has_mean(&procedure->averaging, index);
}

uint8_t tumble_first_unmeasured(const tumble_procedure_t *procedure, uint8_t mounting_index)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    uint8_t p = 0;
    while ((p < schedule->position_count) &&
           (tumble_is_measured(procedure, p) ||
            ((mounting_index != TUMBLE_NOT_MOUNTED) && (tumble_mounting_index(schedule, p) != mounting_index)))) {
        p++;
    }
    return p;
}

tumble_status_t tumble_begin_averaging(tumble_procedure_t *procedure)
{
    if (procedure->begun) {
        return TUMBLE_OK;
    }
    const tumble_status_t status = tumble_averaging_init(&procedure->averaging, procedure->config->averaging);
    procedure->begun = (status == TUMBLE_OK);
    return status;
}

/* Opening a position forgets what it held, and an open one counts as not measured. */
void tumble_forget_position(tumble_procedure_t *procedure, uint8_t index)
{
    (void)tumble_averaging_begin(&procedure->averaging, index);
    procedure->solved = false;
}

static uint8_t count_finished(const tumble_procedure_t *procedure)
{
    uint8_t finished = 0;
    for (uint8_t p = 0; procedure->begun && (p < procedure->config->schedule->position_count); p++) {
        finished = (uint8_t)(finished + (tumble_is_measured(procedure, p) ? 1U : 0U));
    }
    return finished;
}

bool tumble_procedure_has_mean(const tumble_procedure_t *procedure, uint8_t index)
{
    return procedure->begun && (index < procedure->config->schedule->position_count) &&
           tumble_is_measured(procedure, index);
}

void tumble_procedure_progress(const tumble_procedure_t *procedure, tumble_progress_t *progress)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    *progress = (tumble_progress_t){
        .state = procedure->state,
        .failed_in = procedure->failed_in,
        .reason = procedure->reason,
        .status = procedure->status,
        .drive_code = procedure->drive_code,
        .attempt = procedure->attempt,
        .samples_wanted = procedure->config->samples,
        .target_deg = procedure->target_deg,
    };
    if (!procedure->begun) {
        return;
    }
    progress->index = procedure->index;
    progress->count = schedule->position_count;
    progress->finished = count_finished(procedure);
    progress->position = schedule->positions[procedure->index].number;
    progress->mounting = schedule->positions[procedure->index].mounting;
    const uint8_t m = tumble_schedule_find_mounting(schedule, progress->mounting);
    progress->inclination_deg = schedule->mountings[m].tilt.deg;
    progress->stays_bolted = tumble_schedule_stays_bolted(schedule, m);
    progress->samples = tumble_averaging_samples(&procedure->averaging);
    progress->elapsed_us = procedure->restart_run ? 0U : (procedure->now_us - procedure->started_us);
}

TUMBLE_ONE_COPY tumble_status_t tumble_procedure_running(const tumble_procedure_t *procedure,
                                                         double mean_v[TUMBLE_CHANNELS],
                                                         double standard_error_v[TUMBLE_CHANNELS])
{
    if (!procedure->begun) {
        return TUMBLE_E_NOT_OPEN;
    }
    const tumble_status_t status = tumble_averaging_running(&procedure->averaging, mean_v, standard_error_v);
    if (status == TUMBLE_OK) {
        const double v_per_count = procedure->config->v_per_count;
        const double size_v = tumble_abs(v_per_count);
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            mean_v[i] *= v_per_count;
            standard_error_v[i] *= size_v;
        }
    }
    return status;
}

const tumble_averaging_t *tumble_procedure_averages(const tumble_procedure_t *procedure)
{
    return &procedure->averaging;
}

tumble_status_t tumble_procedure_result(const tumble_procedure_t *procedure, tumble_result_t *result)
{
    if (!procedure->solved) {
        return TUMBLE_E_STATE;
    }
    *result = (tumble_result_t){
        .coefficients = &procedure->coefficients,
        .calibration = &procedure->calibration,
        .check = &procedure->work.found.check,
        .pass = procedure->work.found.check.pass,
    };
    return TUMBLE_OK;
}

double tumble_procedure_closure_g(const tumble_procedure_t *procedure, uint8_t mounting_index)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    tumble_closure_pair_t pair;
    if (!procedure->begun || (mounting_index >= schedule->mounting_count) ||
        (tumble_first_unmeasured(procedure, mounting_index) != schedule->position_count) ||
        !tumble_closure_find(schedule, NULL, schedule->mountings[mounting_index].number, &pair)) {
        return 0.0;
    }
    double early[TUMBLE_CHANNELS];
    double late[TUMBLE_CHANNELS];
    tumble_seen_g(procedure, pair.early, early);
    tumble_seen_g(procedure, pair.late, late);
    double largest_g = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        largest_g = tumble_larger(tumble_abs(late[i] - early[i]), largest_g);
    }
    return largest_g;
}

const tumble_procedure_counters_t *tumble_procedure_counters(const tumble_procedure_t *procedure)
{
    return &procedure->counters;
}

tumble_status_t tumble_procedure_restore(tumble_procedure_t *procedure, uint8_t index, const tumble_average_t *average)
{
    if (procedure->state != TUMBLE_STATE_IDLE) {
        return TUMBLE_E_STATE;
    }
    if (index >= procedure->config->schedule->position_count) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_status_t status = tumble_begin_averaging(procedure);
    if (status == TUMBLE_OK) {
        status = tumble_averaging_restore(&procedure->averaging, procedure->config->averaging, index, average);
    }
    if (status != TUMBLE_OK) {
        return status;
    }
    if ((tumble_check_direction(procedure, index) != TUMBLE_REASON_NONE) ||
        (tumble_check_closure(procedure, index) != TUMBLE_REASON_NONE)) {
        tumble_forget_position(procedure, index);
        return TUMBLE_E_ARGUMENT;
    }
    procedure->restored = true;
    return TUMBLE_OK;
}
