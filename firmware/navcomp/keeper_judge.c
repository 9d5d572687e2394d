/* From a result to a verdict. */
#include "navcomp/keeper_internal.h"
#include "navcomp/navcomp_internal.h"

#include "core/arith.h"
#include "navcomp/uncertainty.h"

#include <string.h>

#define HALF_DEGREES 2.0

static void begin_task(tumble_keeper_t *keeper, unsigned task)
{
    keeper->task = (uint8_t)task;
    keeper->at = 0;
}

/* The set of a result. */

static void add_circumstances(const tumble_keeper_t *keeper, tumble_set_t *set)
{
    (void)memcpy(set->block_serial, keeper->config->serial, tumble_serial_length(keeper->config));
    set->date_utc_s = tumble_keeper_utc_s(keeper);
    set->flags |= keeper->run_resumed ? TUMBLE_SET_RESUMED : 0U;
    if (keeper->warm_samples != 0U) {
        set->temperature_c = (double)keeper->warmth_half_c / ((double)keeper->warm_samples * HALF_DEGREES);
        set->flags |= TUMBLE_SET_HAS_TEMPERATURE;
    }
    if (keeper->settings.gravity_m_s2 > 0.0) {
        set->gravity_m_s2 = keeper->settings.gravity_m_s2;
        set->flags |= TUMBLE_SET_HAS_GRAVITY;
    }
    set->schedule_crc = tumble_keeper_schedule_crc(keeper);
    set->stand_crc = tumble_keeper_stand_crc(keeper);
}

static void add_check(const tumble_keeper_t *keeper, const tumble_gravity_check_t *check, tumble_set_t *set)
{
    set->max_abs_fit_g = check->max_abs_fit_g;
    set->max_abs_check_g = check->max_abs_check_g;
    set->limit_g = keeper->navcomp->procedure_config.gravity_limit_g;
    set->fit_positions = check->fit_positions;
    set->check_positions = check->check_positions;
    set->flags |= TUMBLE_SET_HAS_CHECK;
}

static void add_closure(const tumble_keeper_t *keeper, tumble_set_t *set)
{
    double largest_g = 0.0;
    for (uint8_t m = 0; m < TUMBLE_MAX_MOUNTINGS; m++) {
        const double closure_g = tumble_procedure_closure_g(&keeper->navcomp->procedure, m);
        largest_g = (closure_g > largest_g) ? closure_g : largest_g;
    }
    if (largest_g > 0.0) { /* else no mounting comes back to where it began */
        set->closure_v = largest_g * tumble_abs(keeper->navcomp->procedure_config.nominal_scale_v_per_g);
        set->flags |= TUMBLE_SET_HAS_CLOSURE;
    }
}

static uint32_t count_samples(const tumble_keeper_t *keeper)
{
    const tumble_averaging_t *averages = tumble_procedure_averages(&keeper->navcomp->procedure);
    uint32_t samples = 0;
    for (uint8_t p = 0; p < keeper->navcomp->procedure_config.schedule->position_count; p++) {
        samples += averages->averages[p].samples;
    }
    return samples;
}

/* Rules that were others when the run was done are held against it even if they are the board's when it is decided. */
static void note_rules(tumble_keeper_t *keeper)
{
    const bool others = tumble_keeper_rules_are_other(keeper);
    keeper->set.flags |= tumble_keeper_rules_flag(keeper);
    keeper->set.reasons |= others ? TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_RULES) : 0U;
}

void tumble_keeper_take_result(tumble_keeper_t *keeper)
{
    tumble_set_t *set = &keeper->set;
    tumble_result_t result;
    if (tumble_navcomp_result(keeper->navcomp, &result) != TUMBLE_OK) {
        return;
    }
    *set = (tumble_set_t){
        .estimator = (uint8_t)keeper->navcomp->procedure_config.estimate,
        .coefficients = *result.coefficients,
        .samples = count_samples(keeper),
    };
    add_circumstances(keeper, set);
    add_check(keeper, result.check, set);
    add_closure(keeper, set);
    tumble_count(&keeper->counters.judged);
    note_rules(keeper);
    keeper->verdict = TUMBLE_VERDICT_WORKING;
    keeper->repeated = false;
    keeper->looked_again = false;
    tumble_misfit_begin(&keeper->misfit);
    begin_task(keeper, (keeper->config->uncertainty != NULL) ? TASK_UNCERTAINTY : TASK_COMPARE_SETS);
}

/* What it is worth, by the declared stand. Both questions take a processor without floating point hardware a million
 * instructions and more: so a part a step. */

/* One coefficient. Without all twelve there are none. */
static void judge_uncertainty(tumble_keeper_t *keeper)
{
    tumble_set_t *set = &keeper->set;
    const tumble_navcomp_t *navcomp = keeper->navcomp;
    const bool same = (set->estimator == (uint8_t)navcomp->procedure_config.estimate); /* as when the run ended */
    const uint16_t only = (uint16_t)(UINT32_C(1) << keeper->at);
    if (!same || (keeper->config->uncertainty(navcomp, only, &set->uncertainty) != TUMBLE_OK)) {
        set->uncertainty = (tumble_uncertainty_t){.u0_v = {0.0}};
        begin_task(keeper, TASK_COMPARE_SETS);
        return;
    }
    keeper->at++;
    if (keeper->at == (uint8_t)TUMBLE_COEFFICIENTS) {
        set->flags |= TUMBLE_SET_HAS_UNCERTAINTY;
        begin_task(keeper, (navcomp->config->declared != NULL) ? TASK_FIT : TASK_COMPARE_SETS);
    }
}

/* One position. */
static void judge_fit(tumble_keeper_t *keeper)
{
    const tumble_navcomp_t *navcomp = keeper->navcomp;
    const tumble_misfit_run_t run = {
        .schedule = navcomp->procedure_config.schedule,
        .averaging = tumble_procedure_averages(&navcomp->procedure),
        .coefficients = &keeper->set.coefficients,
        .stand = navcomp->config->declared->stand,
        .v_per_count = navcomp->procedure_config.v_per_count,
    };
    if (!tumble_misfit_step(&keeper->misfit, &run)) {
        begin_task(keeper, TASK_COMPARE_SETS);
    }
}

/* Has the store held it before? Noise makes no two runs alike to the last bit: one that is was not measured, it was
 * replayed, or it is the same one, offered again. */

static bool are_same(const tumble_coefficients_t *a, const tumble_coefficients_t *b)
{
    bool same = true;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        same = same && (a->u0_v[i] == b->u0_v[i]);
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            same = same && (a->k_v_per_g[i][j] == b->k_v_per_g[i][j]);
        }
    }
    return same;
}

static void compare_with_sets(tumble_keeper_t *keeper)
{
    tumble_set_t other;
    const tumble_status_t status = tumble_store_read(&keeper->store, (tumble_which_set_t)keeper->at, &other);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status == TUMBLE_OK) {
        keeper->repeated = keeper->repeated || are_same(&other.coefficients, &keeper->set.coefficients);
    }
    keeper->at++;
    if (keeper->at > (uint8_t)TUMBLE_SET_PREVIOUS) {
        begin_task(keeper, TASK_COMPARE_HISTORY);
    }
}

/* The history holds them in single precision, which is enough for that. */
static bool are_equal(const float a[TUMBLE_COEFFICIENTS], const float b[TUMBLE_COEFFICIENTS])
{
    bool equal = true;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        equal = equal && (a[c] == b[c]);
    }
    return equal;
}

static void compare_with_history(tumble_keeper_t *keeper)
{
    tumble_history_entry_t mine;
    tumble_history_entry_t other;
    const bool more = (keeper->at < tumble_history_count(&keeper->history)) && !keeper->repeated &&
                      (tumble_history_from_set(&keeper->set, &mine) == TUMBLE_OK);
    if (!more) {
        keeper->task = TASK_DECIDE;
        return;
    }
    const tumble_status_t status = tumble_history_read(&keeper->history, keeper->at, &other);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status == TUMBLE_OK) {
        keeper->repeated = are_equal(other.value, mine.value);
    }
    keeper->at++;
}

/* The verdict. */

/* A store that could not read all its places looks at them anew instead of beginning a job. What it finds may be
 * another active set, so the result is judged once more, by that. */
static void begin_job(tumble_keeper_t *keeper, uint8_t job, tumble_status_t status)
{
    if ((status == TUMBLE_E_NV) && tumble_store_busy(&keeper->store) && !keeper->looked_again) {
        keeper->looked_again = true;
        begin_task(keeper, TASK_COMPARE_SETS);
        return;
    }
    tumble_keeper_begin_job(keeper, job, status);
}

/* An active set that is dated after the present says nothing of what is older: a clock that was ahead once would else hold
 * every set for years. It counts as one without a date; TUMBLE_DUE_DATE tells of it. */
static uint16_t object(const tumble_keeper_t *keeper, tumble_set_t *active)
{
    if ((active != NULL) && tumble_keeper_is_ahead(keeper, active->date_utc_s, 0)) {
        active->date_utc_s = 0;
    }
    const unsigned misfit = keeper->misfit.misfit ? TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_DOES_NOT_FIT) : 0U;
    const unsigned rules = (unsigned)keeper->set.reasons & TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_RULES);
    return (uint16_t)(misfit | rules |
                      tumble_commit_objections(&keeper->set, active, &keeper->settings.limits, keeper->repeated));
}

static void decide(tumble_keeper_t *keeper)
{
    tumble_set_t active;
    const tumble_status_t status = tumble_store_read(&keeper->store, TUMBLE_SET_ACTIVE, &active);
    if ((status == TUMBLE_E_PORT_BUSY) || tumble_store_busy(&keeper->store)) {
        return; /* the memory is; or what was active has decayed, and the store looks for the next */
    }
    keeper->task = TASK_NONE;
    if ((status != TUMBLE_OK) && (status != TUMBLE_E_STATE)) {
        keeper->verdict = TUMBLE_VERDICT_FAILED;
        tumble_keeper_fail(keeper, status);
        return;
    }
    note_rules(keeper);
    keeper->objections = object(keeper, (status == TUMBLE_OK) ? &active : NULL);
    keeper->set.reasons = keeper->objections;
    if (keeper->repeated) {
        keeper->verdict = TUMBLE_VERDICT_REPEATED;
        tumble_keeper_end_checkpoint(keeper);
        tumble_count(&keeper->counters.repeated);
    } else if (keeper->objections == 0U) {
        begin_job(keeper, JOB_COMMIT, tumble_store_commit(&keeper->store, &keeper->set));
    } else {
        begin_job(keeper, JOB_HOLD, tumble_store_hold(&keeper->store, &keeper->set));
    }
}

void tumble_keeper_judge(tumble_keeper_t *keeper)
{
    if (keeper->task == (uint8_t)TASK_UNCERTAINTY) {
        judge_uncertainty(keeper);
    } else if (keeper->task == (uint8_t)TASK_FIT) {
        judge_fit(keeper);
    } else if (keeper->task == (uint8_t)TASK_COMPARE_SETS) {
        compare_with_sets(keeper);
    } else if (keeper->task == (uint8_t)TASK_COMPARE_HISTORY) {
        compare_with_history(keeper);
    } else {
        decide(keeper);
    }
}
