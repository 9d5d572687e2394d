#include "navcomp/uncertainty.h"

#include "core/accumulator.h"
#include "core/arith.h"

#include <stddef.h>

#define SKIPS_THE_CHECK 2U /* of the gain record: that is done with the first coefficient */

/* The noise of a run. */

/* Nothing is measured but the open position. */
static bool is_first(const tumble_averaging_t *averaging)
{
    bool first = true;
    for (uint8_t p = 0; p < (uint8_t)TUMBLE_MAX_POSITIONS; p++) {
        first = first && !tumble_averaging_has_mean(averaging, p);
    }
    return first;
}

/* How many samples every position has at least. A run that goes on after a loss of power, of which nothing is known,
 * begins here too. */
static void begin_position(tumble_run_noise_t *noise, const tumble_navcomp_t *navcomp)
{
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    const bool adapts = tumble_is_positive(config->error_budget_v);
    if (is_first(tumble_procedure_averages(&navcomp->procedure)) || (noise->blocks.block_samples == 0U)) {
        noise->blocks = (tumble_blocks_t){.block_samples = 0};
        (void)tumble_blocks_init(&noise->blocks, adapts ? config->averaging->min_samples : config->samples);
    }
    tumble_blocks_begin(&noise->blocks);
}

void tumble_navcomp_take_noise(const tumble_navcomp_t *navcomp, tumble_taken_t taken,
                               const tumble_block_sample_t *sample)
{
    tumble_run_noise_t *noise = navcomp->config->declared->noise;
    if (noise == NULL) {
        return;
    }
    if (taken.ordinal == 1U) {
        begin_position(noise, navcomp);
    }
    noise->looked = false;
    if (noise->blocks.block_samples == 0U) {
        return; /* too few samples for blocks: their scatter speaks alone */
    }
    tumble_blocks_add(&noise->blocks, sample->raw.counts);
    if (tumble_averaging_has_mean(tumble_procedure_averages(&navcomp->procedure), taken.index)) {
        tumble_blocks_finish(&noise->blocks);
    }
}

bool tumble_navcomp_estimate_noise(const tumble_navcomp_t *navcomp)
{
    const tumble_declared_t *declared = navcomp->config->declared;
    tumble_run_noise_t *noise = declared->noise;
    if ((noise == NULL) || noise->looked) {
        return false;
    }
    noise->looked = true;
    noise->status = tumble_blocks_noise(&noise->blocks, tumble_procedure_averages(&navcomp->procedure), declared->stand,
                                        navcomp->procedure_config.v_per_count, &noise->seen);
    return true;
}

tumble_status_t tumble_navcomp_noise(const tumble_navcomp_t *navcomp, const tumble_noise_t **noise)
{
    tumble_result_t result;
    const tumble_declared_t *declared = navcomp->config->declared;
    if ((declared == NULL) || (declared->noise == NULL) || (tumble_navcomp_result(navcomp, &result) != TUMBLE_OK)) {
        return TUMBLE_E_STATE;
    }
    if (!declared->noise->looked) {
        return TUMBLE_E_PORT_BUSY;
    }
    if (declared->noise->status == TUMBLE_OK) {
        *noise = &declared->noise->seen;
    }
    return declared->noise->status;
}

/* The uncertainties. */

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
    if (tumble_navcomp_estimate_noise(navcomp)) {
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
