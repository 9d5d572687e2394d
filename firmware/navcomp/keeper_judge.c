/* From a result to a verdict, a part in each step:
 *
 *     run_done --> UNCERTAINTY, 13 steps --> NORM, some 60 --> FIT, a step a position --> WHOLE_MODEL, if the board asks
 *         |                                                                                                 |
 *         `-- no stand is declared -------------------------------------------------------------> COMPARE_SETS
 *
 *     COMPARE_SETS --> COMPARE_HISTORY --> DECIDE
 *
 *     DECIDE: seen before: store nothing    no objection: commit    else: hold
 *
 * All of it takes some 100 ms, and the thousand steps of WHOLE_MODEL, which follow each other at once. Meanwhile the means
 * must stay as they are, so commands that begin a run or measure anew are refused (tumble_sets_allow).
 */
#include "navcomp/keeper_parts.h"

#include "core/arith.h"
#include "core/coefficient.h"
#include "core/one_copy.h"
#include "navcomp/uncertainty.h"

#include <string.h>

#define HALF_DEGREES 2.0

/* Lent by the procedure for as long as the means must stay as they are. */
static tumble_misfit_work_t *misfit_of(tumble_keeper_t *keeper)
{
    return &keeper->navcomp->procedure.work.found.misfit;
}

static void begin_task(tumble_keeper_t *keeper, unsigned task)
{
    keeper->task = (uint8_t)task;
    keeper->at = 0;
}

/* The set of a result. */

static void add_circumstances(const tumble_keeper_t *keeper, tumble_set_t *set)
{
    (void)memcpy(set->block_serial, keeper->config->sets.serial, tumble_serial_length(keeper->config->sets.serial));
    set->date_utc_s = tumble_keeper_utc_s(keeper);
    set->flags |= keeper->run_resumed ? TUMBLE_SET_RESUMED : 0U;
    if (keeper->warm_samples != 0U) {
        set->temperature_c = (double)keeper->warmth_half_c / ((double)keeper->warm_samples * HALF_DEGREES);
        set->flags |= TUMBLE_SET_HAS_TEMPERATURE;
    }
    tumble_margins_range(&keeper->checkpoint.margins, set);
    if (tumble_is_positive(keeper->settings.gravity_m_s2)) {
        set->gravity_m_s2 = keeper->settings.gravity_m_s2;
        set->flags |= TUMBLE_SET_HAS_GRAVITY;
    }
    set->schedule_crc = tumble_gain_record_schedule_crc(tumble_keeper_schedule(keeper));
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

/* The largest of all mountings. */
static void add_closure(const tumble_keeper_t *keeper, tumble_set_t *set)
{
    const tumble_procedure_t *procedure = &keeper->navcomp->procedure;
    double largest_g = 0.0;
    for (uint8_t m = 0; m < tumble_keeper_schedule(keeper)->mounting_count; m++) {
        const double closure_g = tumble_procedure_closure_g(procedure, m);
        largest_g = tumble_exceeds(closure_g, largest_g) ? closure_g : largest_g;
    }
    const double closure_v = largest_g * tumble_abs(keeper->navcomp->procedure_config.nominal_scale_v_per_g);
    if (tumble_is_positive(closure_v)) { /* else no mounting comes back to where it began */
        set->closure_v = closure_v;
        set->flags |= TUMBLE_SET_HAS_CLOSURE;
    }
}

static uint32_t count_samples(const tumble_keeper_t *keeper)
{
    uint32_t samples = 0;
    for (uint8_t p = 0; p < tumble_keeper_schedule(keeper)->position_count; p++) {
        samples += tumble_keeper_averages(keeper)[p].samples;
    }
    return samples;
}

static void object_if(tumble_keeper_t *keeper, bool objects, tumble_objection_t objection)
{
    keeper->set.reasons |= objects ? TUMBLE_OBJECTION_BIT(objection) : 0U;
}

/* Rules other than the board's when the run was done are an objection, even if the board's are in force again when it
 * is decided. */
static void note_rules(tumble_keeper_t *keeper)
{
    const bool others = tumble_keeper_rules_are_other(keeper);
    keeper->set.flags |= tumble_keeper_rules_flag(keeper);
    object_if(keeper, others, TUMBLE_OBJECTION_OTHER_RULES);
}

void tumble_keeper_run_done(tumble_keeper_t *keeper, const tumble_result_t *result)
{
    tumble_set_t *set = &keeper->set;
    const tumble_sets_config_t *config = &keeper->config->sets;
    *set = (tumble_set_t){
        .estimator = (uint8_t)keeper->navcomp->procedure_config.estimate,
        .samples = count_samples(keeper),
        .stand_crc = tumble_stand_fingerprint(keeper->navcomp),
    };
    set->coefficients = *result->coefficients;
    add_circumstances(keeper, set);
    add_check(keeper, result->check, set);
    add_closure(keeper, set);
    tumble_count(&keeper->counters.judged);
    note_rules(keeper);
    object_if(keeper, keeper->disturbed, TUMBLE_OBJECTION_DISTURBED);
    keeper->verdict = TUMBLE_VERDICT_WORKING;
    keeper->repeated = false;
    keeper->looked_again = false;
    tumble_misfit_begin(misfit_of(keeper));
    if (config->whole_step != NULL) {
        tumble_whole_begin(config->whole_work);
    }
    begin_task(keeper, (keeper->config->uncertainty != NULL) ? TASK_UNCERTAINTY : TASK_COMPARE_SETS);
}

/* What the result is worth, by the declared stand. Uncertainty and fit take a processor without floating point hardware
 * a million instructions and more, so each step does a part. */

static unsigned test_of_fit(const tumble_keeper_t *keeper)
{
    return (keeper->navcomp->config->declared != NULL) ? (unsigned)TASK_FIT : (unsigned)TASK_COMPARE_SETS;
}

/* Is the estimator that of the result still? */
static bool is_same(const tumble_keeper_t *keeper)
{
    return keeper->set.estimator == (uint8_t)keeper->navcomp->procedure_config.estimate;
}

/* One coefficient. Without all twelve there are none. */
static void judge_uncertainty(tumble_keeper_t *keeper)
{
    tumble_set_t *set = &keeper->set;
    const uint16_t only = (uint16_t)(UINT32_C(1) << keeper->at);
    const tumble_status_t status =
        is_same(keeper) ? keeper->config->uncertainty(keeper->navcomp, only, &set->uncertainty) : TUMBLE_E_STATE;
    if (status == TUMBLE_E_PORT_BUSY) {
        return; /* something has to be found first: ask again at the next step */
    }
    if (status != TUMBLE_OK) {
        set->uncertainty = (tumble_uncertainty_t){.u0_v = {0.0}};
        begin_task(keeper, TASK_COMPARE_SETS);
        return;
    }
    keeper->at++;
    if (keeper->at == (uint8_t)TUMBLE_COEFFICIENTS) {
        set->flags |= TUMBLE_SET_HAS_UNCERTAINTY;
        tumble_worst_norm_begin(&keeper->worst_norm);
        begin_task(keeper, (keeper->config->norm != NULL) ? (unsigned)TASK_NORM : test_of_fit(keeper));
    }
}

/* One attitude. What cannot be judged is not shown. */
static void judge_everywhere(tumble_keeper_t *keeper)
{
    double attitude[3];
    double u_g = 0.0;
    tumble_worst_norm_attitude(&keeper->worst_norm, attitude);
    const tumble_status_t status =
        is_same(keeper) ? keeper->config->norm(keeper->navcomp, attitude, &u_g) : TUMBLE_E_STATE;
    if ((status == TUMBLE_OK) && tumble_worst_norm_next(&keeper->worst_norm, u_g)) {
        return;
    }
    const bool shown =
        (status == TUMBLE_OK) && tumble_within(TUMBLE_NORM_COVERAGE * keeper->worst_norm.worst_g, keeper->set.limit_g);
    object_if(keeper, !shown, TUMBLE_OBJECTION_NOT_SHOWN);
    begin_task(keeper, test_of_fit(keeper));
}

/* One step of either test. */
static void judge_fit(tumble_keeper_t *keeper)
{
    const tumble_navcomp_t *navcomp = keeper->navcomp;
    const tumble_sets_config_t *config = &keeper->config->sets;
    const tumble_misfit_run_t run = {
        .schedule = tumble_keeper_schedule(keeper),
        .averaging = tumble_procedure_averages(&navcomp->procedure),
        .coefficients = &keeper->set.coefficients,
        .stand = navcomp->config->declared->stand,
        .v_per_count = navcomp->procedure_config.v_per_count,
    };
    if (keeper->task == (uint8_t)TASK_WHOLE_MODEL) {
        if (!config->whole_step(config->whole_work, &run)) {
            object_if(keeper, config->whole_work->misfits, TUMBLE_OBJECTION_WHOLE_MODEL);
            begin_task(keeper, TASK_COMPARE_SETS);
        }
    } else if (!tumble_misfit_step(misfit_of(keeper), &run)) {
        object_if(keeper, misfit_of(keeper)->misfit, TUMBLE_OBJECTION_DOES_NOT_FIT);
        begin_task(keeper, (config->whole_step != NULL) ? TASK_WHOLE_MODEL : TASK_COMPARE_SETS);
    } else {
        /* the test goes on */
    }
}

/* Has the store held these coefficients before? Noise makes every run different in the last bits. Equal coefficients
 * were not measured: the run was replayed, or the same result is offered again after a loss of power. */

static bool are_same(const tumble_coefficients_t *a, const tumble_coefficients_t *b)
{
    bool same = true;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        same = same && tumble_within(tumble_coefficient(a, c) - tumble_coefficient(b, c), 0.0);
    }
    return same;
}

TUMBLE_ONE_COPY static void compare_with_sets(tumble_keeper_t *keeper)
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
        const double difference = (double)a[c] - (double)b[c]; /* exact, unlike that of floats */
        equal = equal && tumble_within(difference, 0.0);
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

/* An active set that is dated after the present counts as one without a date. Otherwise a clock that was ahead once
 * would hold every later set as "older", for years. TUMBLE_DUE_DATE tells of such a date. */
static uint32_t object(const tumble_keeper_t *keeper, tumble_set_t *active)
{
    if ((active != NULL) && tumble_keeper_is_ahead(keeper, active->date_utc_s, 0)) {
        active->date_utc_s = 0;
    }
    const uint32_t found =
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_DOES_NOT_FIT) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_WHOLE_MODEL) |
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_DISTURBED) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NEWER_SET) |
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_RULES) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NOT_SHOWN);
    return (keeper->set.reasons & found) |
           tumble_commit_objections(&keeper->set, active, &keeper->settings.limits, keeper->repeated);
}

TUMBLE_ONE_COPY static void decide(tumble_keeper_t *keeper)
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
    object_if(keeper, tumble_store_has_newer(&keeper->store), TUMBLE_OBJECTION_NEWER_SET);
    keeper->objections = object(keeper, (status == TUMBLE_OK) ? &active : NULL);
    keeper->set.reasons = keeper->objections;
    if (keeper->repeated) {
        keeper->verdict = TUMBLE_VERDICT_REPEATED;
        tumble_keeper_end_checkpoint(keeper);
        tumble_count(&keeper->counters.repeated);
    } else if (keeper->objections == 0U) {
        begin_job(keeper, TUMBLE_VERDICT_COMMITTED, tumble_store_commit(&keeper->store, &keeper->set));
    } else {
        begin_job(keeper, TUMBLE_VERDICT_HELD, tumble_store_hold(&keeper->store, &keeper->set));
    }
}

void tumble_keeper_judge(tumble_keeper_t *keeper)
{
    if (keeper->task == (uint8_t)TASK_UNCERTAINTY) {
        judge_uncertainty(keeper);
    } else if (keeper->task == (uint8_t)TASK_NORM) {
        judge_everywhere(keeper);
    } else if (tumble_keeper_is_assessing(keeper)) {
        judge_fit(keeper);
    } else if (keeper->task == (uint8_t)TASK_COMPARE_SETS) {
        compare_with_sets(keeper);
    } else if (keeper->task == (uint8_t)TASK_COMPARE_HISTORY) {
        compare_with_history(keeper);
    } else {
        decide(keeper);
    }
}
