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
#include "sets/parts.h"

#include "core/arith.h"
#include "core/coefficient.h"
#include "core/one_copy.h"

#include <string.h>

#define HALF_DEGREES 2.0

static void begin_task(tumble_sets_t *sets, unsigned task)
{
    sets->task = (uint8_t)task;
    sets->at = 0;
}

/* The set of a result. */

/* At an end of what a sample can tell a block may have been colder or warmer still: then the range is not known. The end
 * of the cold is two values wide, for a block whose values are as many below 0 as above ends at -63.5 degrees C. */
static void add_temperature_range(const tumble_margins_t *margins, tumble_set_t *set)
{
    const int min_half_c = (int)margins->cold + (int)INT8_MIN;
    const int max_half_c = (int)INT8_MAX - (int)margins->warm;
    if ((min_half_c > -(int)INT8_MAX) && (max_half_c < (int)INT8_MAX) && (min_half_c <= max_half_c)) {
        set->temperature_min_half_c = (int8_t)min_half_c;
        set->temperature_max_half_c = (int8_t)max_half_c;
        set->flags |= TUMBLE_SET_HAS_TEMPERATURE_RANGE;
    }
}

static void add_circumstances(const tumble_sets_t *sets, tumble_set_t *set)
{
    (void)memcpy(set->block_serial, sets->config->serial, tumble_serial_length(sets->config));
    set->date_utc_s = tumble_sets_utc_s(sets);
    set->flags |= sets->run_resumed ? TUMBLE_SET_RESUMED : 0U;
    if (sets->warm_samples != 0U) {
        set->temperature_c = (double)sets->warmth_half_c / ((double)sets->warm_samples * HALF_DEGREES);
        set->flags |= TUMBLE_SET_HAS_TEMPERATURE;
    }
    add_temperature_range(&sets->checkpoint.margins, set);
    if (tumble_is_positive(sets->settings.gravity_m_s2)) {
        set->gravity_m_s2 = sets->settings.gravity_m_s2;
        set->flags |= TUMBLE_SET_HAS_GRAVITY;
    }
    set->schedule_crc = tumble_gain_record_schedule_crc(sets->run->schedule);
}

static void add_check(const tumble_sets_t *sets, const tumble_gravity_check_t *check, tumble_set_t *set)
{
    set->max_abs_fit_g = check->max_abs_fit_g;
    set->max_abs_check_g = check->max_abs_check_g;
    set->limit_g = sets->run->gravity_limit_g;
    set->fit_positions = check->fit_positions;
    set->check_positions = check->check_positions;
    set->flags |= TUMBLE_SET_HAS_CHECK;
}

static void add_closure(double closure_v, tumble_set_t *set)
{
    if (tumble_is_positive(closure_v)) { /* else no mounting comes back to where it began */
        set->closure_v = closure_v;
        set->flags |= TUMBLE_SET_HAS_CLOSURE;
    }
}

static uint32_t count_samples(const tumble_sets_t *sets)
{
    const tumble_sets_run_t *run = sets->run;
    uint32_t samples = 0;
    for (uint8_t p = 0; p < run->schedule->position_count; p++) {
        samples += run->averaging->averages[p].samples;
    }
    return samples;
}

static void object_if(tumble_sets_t *sets, bool objects, tumble_objection_t objection)
{
    sets->set.reasons |= objects ? TUMBLE_OBJECTION_BIT(objection) : 0U;
}

/* Rules other than the board's when the run was done are an objection, even if the board's are in force again when it
 * is decided. */
static void note_rules(tumble_sets_t *sets)
{
    const bool others = tumble_sets_rules_are_other(sets);
    sets->set.flags |= tumble_sets_rules_flag(sets);
    object_if(sets, others, TUMBLE_OBJECTION_OTHER_RULES);
}

void tumble_sets_run_done(tumble_sets_t *sets, const tumble_finished_run_t *run)
{
    tumble_set_t *set = &sets->set;
    sets->run_was_on = false;
    tumble_sets_pause(sets);
    *set = (tumble_set_t){
        .estimator = sets->run->estimator,
        .samples = count_samples(sets),
        .stand_crc = run->stand_crc,
    };
    set->coefficients = *run->coefficients;
    add_circumstances(sets, set);
    add_check(sets, run->check, set);
    add_closure(run->closure_v, set);
    tumble_count(&sets->counters.judged);
    note_rules(sets);
    object_if(sets, run->disturbed, TUMBLE_OBJECTION_DISTURBED);
    sets->verdict = TUMBLE_VERDICT_WORKING;
    sets->repeated = false;
    sets->looked_again = false;
    tumble_misfit_begin(sets->owner->misfit);
    if (sets->config->whole_step != NULL) {
        tumble_whole_begin(sets->config->whole_work);
    }
    begin_task(sets, (sets->owner->uncertainty != NULL) ? TASK_UNCERTAINTY : TASK_COMPARE_SETS);
}

/* What the result is worth, by the declared stand. Uncertainty and fit take a processor without floating point hardware
 * a million instructions and more, so each step does a part. */

static unsigned test_of_fit(const tumble_sets_t *sets)
{
    return (sets->run->stand != NULL) ? (unsigned)TASK_FIT : (unsigned)TASK_COMPARE_SETS;
}

/* One coefficient. Without all twelve there are none. */
static void judge_uncertainty(tumble_sets_t *sets)
{
    tumble_set_t *set = &sets->set;
    const tumble_sets_owner_t *owner = sets->owner;
    const bool same = (set->estimator == sets->run->estimator); /* as when the run ended */
    const uint16_t only = (uint16_t)(UINT32_C(1) << sets->at);
    const tumble_status_t status = same ? owner->uncertainty(owner->self, only, &set->uncertainty) : TUMBLE_E_STATE;
    if (status == TUMBLE_E_PORT_BUSY) {
        return; /* something has to be found first: ask again at the next step */
    }
    if (status != TUMBLE_OK) {
        set->uncertainty = (tumble_uncertainty_t){.u0_v = {0.0}};
        begin_task(sets, TASK_COMPARE_SETS);
        return;
    }
    sets->at++;
    if (sets->at == (uint8_t)TUMBLE_COEFFICIENTS) {
        set->flags |= TUMBLE_SET_HAS_UNCERTAINTY;
        tumble_worst_norm_begin(&sets->worst_norm);
        begin_task(sets, (owner->norm != NULL) ? (unsigned)TASK_NORM : test_of_fit(sets));
    }
}

/* One attitude. What cannot be judged is not shown. */
static void judge_everywhere(tumble_sets_t *sets)
{
    const tumble_sets_owner_t *owner = sets->owner;
    double attitude[3];
    double u_g = 0.0;
    tumble_worst_norm_attitude(&sets->worst_norm, attitude);
    const bool same = (sets->set.estimator == sets->run->estimator);
    const tumble_status_t status = same ? owner->norm(owner->self, attitude, &u_g) : TUMBLE_E_STATE;
    if ((status == TUMBLE_OK) && tumble_worst_norm_next(&sets->worst_norm, u_g)) {
        return;
    }
    const bool shown =
        (status == TUMBLE_OK) && tumble_within(TUMBLE_NORM_COVERAGE * sets->worst_norm.worst_g, sets->set.limit_g);
    object_if(sets, !shown, TUMBLE_OBJECTION_NOT_SHOWN);
    begin_task(sets, test_of_fit(sets));
}

/* One step of either test. */
static void judge_fit(tumble_sets_t *sets)
{
    const tumble_sets_run_t *at_hand = sets->run;
    const tumble_sets_config_t *config = sets->config;
    const tumble_misfit_run_t run = {
        .schedule = at_hand->schedule,
        .averaging = at_hand->averaging,
        .coefficients = &sets->set.coefficients,
        .stand = at_hand->stand,
        .v_per_count = at_hand->v_per_count,
    };
    if (sets->task == (uint8_t)TASK_WHOLE_MODEL) {
        if (!config->whole_step(config->whole_work, &run)) {
            object_if(sets, config->whole_work->misfits, TUMBLE_OBJECTION_WHOLE_MODEL);
            begin_task(sets, TASK_COMPARE_SETS);
        }
    } else if (!tumble_misfit_step(sets->owner->misfit, &run)) {
        object_if(sets, sets->owner->misfit->misfit, TUMBLE_OBJECTION_DOES_NOT_FIT);
        begin_task(sets, (config->whole_step != NULL) ? TASK_WHOLE_MODEL : TASK_COMPARE_SETS);
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

TUMBLE_ONE_COPY static void compare_with_sets(tumble_sets_t *sets)
{
    tumble_set_t other;
    const tumble_status_t status = tumble_store_read(&sets->store, (tumble_which_set_t)sets->at, &other);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status == TUMBLE_OK) {
        sets->repeated = sets->repeated || are_same(&other.coefficients, &sets->set.coefficients);
    }
    sets->at++;
    if (sets->at > (uint8_t)TUMBLE_SET_PREVIOUS) {
        begin_task(sets, TASK_COMPARE_HISTORY);
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

static void compare_with_history(tumble_sets_t *sets)
{
    tumble_history_entry_t mine;
    tumble_history_entry_t other;
    const bool more = (sets->at < tumble_history_count(&sets->history)) && !sets->repeated &&
                      (tumble_history_from_set(&sets->set, &mine) == TUMBLE_OK);
    if (!more) {
        sets->task = TASK_DECIDE;
        return;
    }
    const tumble_status_t status = tumble_history_read(&sets->history, sets->at, &other);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status == TUMBLE_OK) {
        sets->repeated = are_equal(other.value, mine.value);
    }
    sets->at++;
}

/* The verdict. */

/* A store that could not read all its places looks at them anew instead of beginning a job. What it finds may be
 * another active set, so the result is judged once more, by that. */
static void begin_job(tumble_sets_t *sets, uint8_t job, tumble_status_t status)
{
    if ((status == TUMBLE_E_NV) && tumble_store_busy(&sets->store) && !sets->looked_again) {
        sets->looked_again = true;
        begin_task(sets, TASK_COMPARE_SETS);
        return;
    }
    tumble_sets_begin_job(sets, job, status);
}

/* An active set that is dated after the present counts as one without a date. Otherwise a clock that was ahead once
 * would hold every later set as "older", for years. TUMBLE_DUE_DATE tells of such a date. */
static uint32_t object(const tumble_sets_t *sets, tumble_set_t *active)
{
    if ((active != NULL) && tumble_sets_is_ahead(sets, active->date_utc_s, 0)) {
        active->date_utc_s = 0;
    }
    const uint32_t found =
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_DOES_NOT_FIT) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_WHOLE_MODEL) |
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_DISTURBED) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NEWER_SET) |
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_RULES) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NOT_SHOWN);
    return (sets->set.reasons & found) |
           tumble_commit_objections(&sets->set, active, &sets->settings.limits, sets->repeated);
}

TUMBLE_ONE_COPY static void decide(tumble_sets_t *sets)
{
    tumble_set_t active;
    const tumble_status_t status = tumble_store_read(&sets->store, TUMBLE_SET_ACTIVE, &active);
    if ((status == TUMBLE_E_PORT_BUSY) || tumble_store_busy(&sets->store)) {
        return; /* the memory is; or what was active has decayed, and the store looks for the next */
    }
    sets->task = TASK_NONE;
    if ((status != TUMBLE_OK) && (status != TUMBLE_E_STATE)) {
        sets->verdict = TUMBLE_VERDICT_FAILED;
        tumble_sets_fail(sets, status);
        return;
    }
    note_rules(sets);
    object_if(sets, tumble_store_has_newer(&sets->store), TUMBLE_OBJECTION_NEWER_SET);
    sets->objections = object(sets, (status == TUMBLE_OK) ? &active : NULL);
    sets->set.reasons = sets->objections;
    if (sets->repeated) {
        sets->verdict = TUMBLE_VERDICT_REPEATED;
        tumble_sets_end_checkpoint(sets);
        tumble_count(&sets->counters.repeated);
    } else if (sets->objections == 0U) {
        begin_job(sets, TUMBLE_VERDICT_COMMITTED, tumble_store_commit(&sets->store, &sets->set));
    } else {
        begin_job(sets, TUMBLE_VERDICT_HELD, tumble_store_hold(&sets->store, &sets->set));
    }
}

void tumble_sets_judge(tumble_sets_t *sets)
{
    if (sets->task == (uint8_t)TASK_UNCERTAINTY) {
        judge_uncertainty(sets);
    } else if (sets->task == (uint8_t)TASK_NORM) {
        judge_everywhere(sets);
    } else if (tumble_sets_is_assessing(sets)) {
        judge_fit(sets);
    } else if (sets->task == (uint8_t)TASK_COMPARE_SETS) {
        compare_with_sets(sets);
    } else if (sets->task == (uint8_t)TASK_COMPARE_HISTORY) {
        compare_with_history(sets);
    } else {
        decide(sets);
    }
}
