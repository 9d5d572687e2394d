#include "procedure/procedure_internal.h"

#include "core/arith.h"

outcome_t tumble_average_enter(tumble_procedure_t *procedure)
{
    (void)tumble_averaging_begin(&procedure->averaging, procedure->index);
    return OUTCOME_STAY;
}

outcome_t tumble_average_poll(tumble_procedure_t *procedure)
{
    if (tumble_stand_state(&procedure->stand) != TUMBLE_STAND_IN_POSITION) {
        return tumble_refuse_position(procedure, TUMBLE_E_NOT_STILL);
    }
    if (procedure->corrupted > procedure->config->max_corrupted) {
        return tumble_refuse_position(procedure, TUMBLE_E_CRC);
    }
    return OUTCOME_STAY;
}

/* Has the position slipped, or was it never what it should be? A mounting that is wrong must be confirmed anew. */
static outcome_t check_position(tumble_procedure_t *procedure)
{
    tumble_reason_t reason = tumble_check_direction(procedure, procedure->index);
    if (reason == TUMBLE_REASON_NONE) {
        reason = tumble_check_closure(procedure, procedure->index);
    }
    if (reason == TUMBLE_REASON_NONE) {
        tumble_count(&procedure->counters.positions);
        return OUTCOME_DONE;
    }
    tumble_count(&procedure->counters.refused);
    tumble_forget_position(procedure, procedure->index);
    if (reason != TUMBLE_REASON_SLIP) {
        procedure->mounted = TUMBLE_NOT_MOUNTED;
    }
    return tumble_fail(procedure, reason);
}

/* Is the mean of every channel as certain as the budget asks? `fixed` where there is no budget. */
static bool is_certain(const tumble_procedure_t *procedure, bool fixed)
{
    double mean_v[TUMBLE_CHANNELS];
    double error_v[TUMBLE_CHANNELS];
    const double budget_v = procedure->config->error_budget_v;
    if (!tumble_is_positive(budget_v)) {
        return fixed;
    }
    bool certain = (tumble_procedure_running(procedure, mean_v, error_v) == TUMBLE_OK);
    for (int i = 0; certain && (i < TUMBLE_CHANNELS); i++) {
        certain = tumble_within(error_v[i], budget_v);
    }
    return certain;
}

static outcome_t finish_position(tumble_procedure_t *procedure)
{
    const bool certain = is_certain(procedure, true);
    tumble_status_t status = tumble_averaging_finish(&procedure->averaging, procedure->config->averaging);
    if ((status == TUMBLE_OK) && !certain) {
        tumble_forget_position(procedure, procedure->index);
        status = TUMBLE_E_UNCERTAIN;
    }
    return (status == TUMBLE_OK) ? check_position(procedure) : tumble_refuse_position(procedure, status);
}

/* Look at the standard error every eighth sample only, from the smallest number of samples on. Stopping on a small
 * scatter prefers scatters that are small by chance; the more often one looks, the more the error is understated
 * (docs/method.md, "Averaging as long as needed"). */
static bool is_good_enough(const tumble_procedure_t *procedure, uint32_t taken)
{
    const uint32_t smallest = procedure->config->averaging->min_samples;
    return (taken >= smallest) && (((taken - smallest) % TUMBLE_BUDGET_CHECK_SAMPLES) == 0U) &&
           is_certain(procedure, false);
}

/* Is the position complete? One that will be refused anyway is given up at once. */
static bool is_complete(const tumble_procedure_t *procedure, tumble_status_t last)
{
    const uint32_t taken = tumble_averaging_samples(&procedure->averaging);
    return (last == TUMBLE_E_SATURATED) || (last == TUMBLE_E_DEVIATION) ||
           (procedure->averaging.open.lost > procedure->config->averaging->max_lost) ||
           (taken >= procedure->config->samples) || ((last == TUMBLE_OK) && is_good_enough(procedure, taken));
}

outcome_t tumble_average_sample(tumble_procedure_t *procedure, const tumble_block_sample_t *sample,
                                tumble_taken_t *taken)
{
    const tumble_status_t status =
        tumble_averaging_add(&procedure->averaging, procedure->config->averaging, &sample->raw);
    if (status == TUMBLE_E_UNHEALTHY) {
        return ((sample->raw.status & TUMBLE_SAMPLE_SATURATED) != 0U)
                   ? tumble_refuse_position(procedure, TUMBLE_E_SATURATED)
                   : tumble_fail(procedure, TUMBLE_REASON_BLOCK_STATUS);
    }
    if (status == TUMBLE_OK) {
        tumble_count(&procedure->counters.averaged);
        taken->index = procedure->index;
        taken->ordinal = tumble_averaging_samples(&procedure->averaging);
    }
    return is_complete(procedure, status) ? finish_position(procedure) : OUTCOME_STAY;
}

outcome_t tumble_average_late(tumble_procedure_t *procedure)
{
    return tumble_refuse_position(procedure, TUMBLE_E_TOO_FEW);
}
