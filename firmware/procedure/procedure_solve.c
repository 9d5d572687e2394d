#include "procedure/procedure_internal.h"

#include "core/one_copy.h"

#include <stddef.h>

typedef tumble_status_t (*estimator_t)(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                       tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

static outcome_t fail_to_solve(tumble_procedure_t *procedure, tumble_status_t status)
{
    procedure->status = status;
    return tumble_fail(procedure, TUMBLE_REASON_SINGULAR);
}

TUMBLE_ONE_COPY static void make_means(tumble_procedure_t *procedure)
{
    (void)tumble_averaging_means(&procedure->averaging, procedure->config->v_per_count, &procedure->work.means);
}

static tumble_status_t estimate(tumble_procedure_t *procedure)
{
#define ESTIMATOR(number, name, needs, estimate, uncertainty) [TUMBLE_ESTIMATE_##number] = (estimate),
#define NONE_OF_ITS_OWN(number, name, needs) [TUMBLE_ESTIMATE_##number] = NULL,
    static const estimator_t estimators[] = {TUMBLE_ESTIMATOR_LIST(ESTIMATOR, NONE_OF_ITS_OWN)};
    const tumble_procedure_config_t *config = procedure->config;
    const estimator_t own = estimators[config->estimate];
    if (own == NULL) {
        const tumble_lent_t *lent = tumble_procedure_lent(config);
        return lent->estimate(lent->source, config->schedule, &procedure->work.means, &procedure->coefficients);
    }
    return own(config->schedule, &procedure->work.means, &procedure->coefficients, &procedure->refusal);
}

/* A part for each step, so that none is long. */
outcome_t tumble_solve_poll(tumble_procedure_t *procedure)
{
    tumble_status_t status = TUMBLE_OK;
    outcome_t outcome = OUTCOME_STAY;
    procedure->parts_done++;
    if (procedure->parts_done == 1U) {
        make_means(procedure);
    } else if (procedure->parts_done == 2U) {
        status = estimate(procedure);
    } else {
        status = tumble_calibration_invert(&procedure->coefficients, &procedure->calibration);
        outcome = OUTCOME_DONE;
    }
    return (status == TUMBLE_OK) ? outcome : fail_to_solve(procedure, status);
}

/* The check's result takes the memory of the means, which nothing has touched since SOLVE made them. */
outcome_t tumble_verify_poll(tumble_procedure_t *procedure)
{
    tumble_gravity_check_t found;
    const tumble_status_t status =
        tumble_gravity_check(procedure->config->schedule, &procedure->work.means, &procedure->calibration,
                             procedure->config->gravity_limit_g, &found);
    if (status != TUMBLE_OK) {
        return fail_to_solve(procedure, status);
    }
    procedure->work.found.check = found;
    return OUTCOME_DONE;
}

/* A result that fails the check is offered too: it is readable, with `pass` false. */
outcome_t tumble_propose_poll(tumble_procedure_t *procedure)
{
    procedure->solved = true;
    procedure->reason = procedure->work.found.check.pass ? TUMBLE_REASON_NONE : TUMBLE_REASON_GRAVITY_CHECK;
    return OUTCOME_DONE;
}
