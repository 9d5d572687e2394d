#include "navcomp/uncertainty.h"

#include <stddef.h>

#define SKIPS_THE_CHECK 2U /* of the gain record: that is done with the first coefficient */

static tumble_status_t judge(const tumble_procedure_config_t *config, const tumble_judged_run_t *run,
                             tumble_uncertainty_t *found)
{
    const tumble_lent_t *lent = tumble_procedure_lent(config);
    tumble_status_t status = TUMBLE_E_ARGUMENT;
    switch (config->estimate) {
#define ONE(number, name, needs, estimate, uncertainty)                                                                \
    case TUMBLE_ESTIMATE_##number:                                                                                     \
        status = uncertainty(run, found, NULL);                                                                        \
        break;
#define NONE_OF_ITS_OWN(number, name, needs)
        TUMBLE_ESTIMATOR_LIST(ONE, NONE_OF_ITS_OWN)
    default:
        if ((lent != NULL) && (lent->uncertainty != NULL)) {
            status = lent->uncertainty(lent->source, run, found);
        }
        break;
    }
    return status;
}

tumble_status_t tumble_navcomp_judged_run(const tumble_navcomp_t *navcomp, uint32_t samples[TUMBLE_MAX_POSITIONS],
                                          tumble_judged_run_t *run)
{
    const tumble_noise_t *noise = NULL;
    if (tumble_navcomp_noise(navcomp, &noise) == TUMBLE_E_DEVIATION) {
        return TUMBLE_E_DEVIATION;
    }
    const tumble_schedule_t *schedule = navcomp->procedure_config.schedule;
    const tumble_averaging_t *averages = tumble_procedure_averages(&navcomp->procedure);
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        samples[p] = averages->averages[p].samples; /* there is no result before every position has a mean */
    }
    run->schedule = schedule;
    run->stand = navcomp->config->declared->stand;
    run->samples = samples;
    run->noise = noise;
    return TUMBLE_OK;
}

/* `asked`: which coefficients, or at which attitude. */
static tumble_status_t judge_asked(const tumble_navcomp_t *navcomp, const tumble_judged_run_t *asked,
                                   tumble_uncertainty_t *uncertainty)
{
    tumble_result_t result;
    if ((navcomp == NULL) || (navcomp->config->declared == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_navcomp_result(navcomp, &result) != TUMBLE_OK) {
        return TUMBLE_E_STATE;
    }
    if (tumble_navcomp_look_at_noise(navcomp)) {
        return TUMBLE_E_PORT_BUSY; /* enough for one step */
    }
    uint32_t samples[TUMBLE_MAX_POSITIONS];
    tumble_judged_run_t run = *asked;
    run.coefficients = result.coefficients;
    const tumble_status_t status = tumble_navcomp_judged_run(navcomp, samples, &run);
    return (status == TUMBLE_OK) ? judge(&navcomp->procedure_config, &run, uncertainty) : status;
}

tumble_status_t tumble_navcomp_uncertainty(const tumble_navcomp_t *navcomp, uint16_t coefficients,
                                           tumble_uncertainty_t *uncertainty)
{
    const tumble_judged_run_t asked = {.only = (uint16_t)(coefficients & TUMBLE_ALL_COEFFICIENTS)};
    return ((uncertainty == NULL) || (asked.only == 0U)) ? TUMBLE_E_ARGUMENT
                                                         : judge_asked(navcomp, &asked, uncertainty);
}

tumble_status_t tumble_navcomp_norm(const tumble_navcomp_t *navcomp, const double attitude[3], double *norm_g)
{
    const tumble_judged_run_t asked = {.only = SKIPS_THE_CHECK, .attitude = attitude, .norm_g = norm_g};
    return ((attitude == NULL) || (norm_g == NULL)) ? TUMBLE_E_ARGUMENT : judge_asked(navcomp, &asked, NULL);
}
