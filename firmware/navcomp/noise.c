#include "navcomp/uncertainty.h"

#include "core/arith.h"
#include "core/averaging_state.h"

#include <stddef.h>

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

bool tumble_navcomp_look_at_noise(const tumble_navcomp_t *navcomp)
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
