#include "navcomp/uncertainty.h"

#include <stddef.h>

static tumble_status_t judge(const tumble_procedure_config_t *config, const tumble_declared_t *declared,
                             const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty)
{
    tumble_status_t status = TUMBLE_E_ARGUMENT;
    switch (config->estimate) {
    case TUMBLE_ESTIMATE_AVERAGED:
        status = tumble_uncertainty_averaged(run, uncertainty, NULL);
        break;
    case TUMBLE_ESTIMATE_REFINED:
        status = tumble_uncertainty_refined(run, uncertainty, NULL);
        break;
    case TUMBLE_ESTIMATE_LEAST_SQUARES:
        status = tumble_uncertainty_least_squares(run, uncertainty, NULL);
        break;
    case TUMBLE_ESTIMATE_OPTIMAL:
        if (declared->weighted != NULL) {
            status = declared->weighted(config->weighted->source, run, uncertainty);
        }
        break;
    default:
        break;
    }
    return status;
}

tumble_status_t tumble_navcomp_uncertainty(const tumble_navcomp_t *navcomp, uint16_t coefficients,
                                           tumble_uncertainty_t *uncertainty)
{
    tumble_result_t result;
    const uint16_t only = (uint16_t)(coefficients & TUMBLE_ALL_COEFFICIENTS);
    if ((navcomp == NULL) || (uncertainty == NULL) || (only == 0U) || (navcomp->config->declared == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (tumble_navcomp_result(navcomp, &result) != TUMBLE_OK) {
        return TUMBLE_E_STATE;
    }
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    const tumble_declared_t *declared = navcomp->config->declared;
    const tumble_averaging_t *averages = tumble_procedure_averages(&navcomp->procedure);
    uint32_t samples[TUMBLE_MAX_POSITIONS];
    for (uint8_t p = 0; p < config->schedule->position_count; p++) {
        samples[p] = averages->averages[p].samples; /* there is no result before every position has a mean */
    }
    const tumble_judged_run_t run = {.schedule = config->schedule,
                                     .stand = declared->stand,
                                     .coefficients = result.coefficients,
                                     .samples = samples,
                                     .only = only};
    return judge(config, declared, &run, uncertainty);
}
