/* The run under way: what happens to it, what its result is worth, its checkpoint, and how it goes on after a loss of power.
 */
#include "navcomp/keeper_parts.h"

#include "core/arith.h"
#include "core/coefficient.h"
#include "core/one_copy.h"
#include "navcomp/uncertainty.h"

#include <stddef.h>
#include <string.h>

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

static void run_done(tumble_keeper_t *keeper, const tumble_result_t *result)
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

/* Sets with slopes, if the board keeps any. */
TUMBLE_ONE_COPY static uint32_t over_temperature(tumble_keeper_t *keeper, tumble_set_t *set)
{
    const tumble_sets_config_t *config = &keeper->config->sets;
    return (config->thermal == NULL)
               ? 0U
               : config->thermal->consult(config->thermal, &keeper->store, &keeper->set, &keeper->settings.limits, set);
}

TUMBLE_ONE_COPY static void compare_with_sets(tumble_keeper_t *keeper)
{
    tumble_set_t other;
    const tumble_status_t status = tumble_store_read(&keeper->store, (tumble_which_set_t)keeper->at, &other);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status == TUMBLE_OK) {
        (void)over_temperature(keeper, &other);
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
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_RULES) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NOT_SHOWN) |
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_TEMPERATURE);
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
    keeper->set.reasons |= over_temperature(keeper, &active);
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
    (void)over_temperature(keeper, NULL);
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

static_assert(TUMBLE_MAX_POSITIONS <= 64, "a position is one bit of 64");

/* A shift of 64 bits is six instructions on 32. */
TUMBLE_ONE_COPY static uint64_t bit_of(uint8_t position)
{
    return UINT64_C(1) << position;
}

static uint8_t positions_of(const tumble_keeper_t *keeper)
{
    return tumble_keeper_schedule(keeper)->position_count;
}

TUMBLE_ONE_COPY static uint64_t measured_positions(const tumble_keeper_t *keeper)
{
    uint64_t measured = 0;
    for (uint8_t p = 0; p < positions_of(keeper); p++) {
        measured |= tumble_procedure_has_mean(&keeper->navcomp->procedure, p) ? bit_of(p) : 0U;
    }
    return measured;
}

/* Of all that must not change in it: with the sequence of the active set, so that the checkpoint of a run that ended in a
 * commit is not resumed. */
static uint32_t fingerprint_of(const tumble_keeper_t *keeper)
{
    return tumble_run_fingerprint(keeper->navcomp, keeper->config->sets.serial, tumble_store_sequence(&keeper->store));
}

static void forget_temperatures(tumble_keeper_t *keeper)
{
    keeper->warmth_half_c = 0;
    keeper->warm_samples = 0;
}

/* What happens to it. */

/* Samples received, less so many for each that went wrong. It falls below where it stood as soon as the share of those is
 * too large. The counters stop at their ends after more than a year of samples: then it says nothing any more. */
static uint32_t balance(const tumble_navcomp_t *navcomp)
{
    const tumble_procedure_counters_t *run = &navcomp->procedure.counters;
    const tumble_block_counters_t *block = &navcomp->block.counters;
    const uint32_t wrong = run->corrupted + run->lost + block->repeated + block->reordered +
                           tumble_stand_report(&navcomp->stand)->stop.implausible;
    return run->samples - (TUMBLE_KEEPER_DISTURBED_ONE_IN * wrong);
}

/* A repetition of some positions leaves standing what was found of the others. */
static void begin_part(tumble_keeper_t *keeper, bool is_disturbed)
{
    keeper->disturbed = is_disturbed;
    keeper->undisturbed = balance(keeper->navcomp);
    (void)tumble_at_rest_begin(&keeper->at_rest, 0);
}

static void begin_run(tumble_keeper_t *keeper)
{
    const bool repeats = (measured_positions(keeper) != 0U); /* a part of a run that was done */
    begin_part(keeper, keeper->disturbed && repeats);
    keeper->run_was_on = true;
    keeper->task = (keeper->task == (uint8_t)TASK_RESTORE) ? (uint8_t)TASK_NONE : keeper->task;
    if (!repeats) {
        keeper->run_resumed = false;
        forget_temperatures(keeper);
        keeper->checkpoint.margins = (tumble_margins_t){UINT8_MAX, UINT8_MAX};
    }
    keeper->saved = 0;
    keeper->unfit = 0;
    keeper->resumable = 0;
    keeper->wants = (uint8_t)((keeper->wants & ~(unsigned)WANT_CLEAR) | WANT_BEGIN);
}

/* Clear the checkpoint instead of beginning it or adding to it: neither this run nor the one before shall be
 * resumed. */
static void clear_instead(tumble_keeper_t *keeper)
{
    keeper->wants = (uint8_t)((keeper->wants & ~(unsigned)(WANT_BEGIN | WANT_APPEND)) | WANT_CLEAR);
}

/* It is done; or a reset has made it forgotten, as at power-on; or it was given up. */
static void end_run(tumble_keeper_t *keeper)
{
    tumble_result_t result;
    keeper->run_was_on = false;
    tumble_keeper_pause(keeper);
    if (tumble_navcomp_result(keeper->navcomp, &result) == TUMBLE_OK) {
        keeper->disturbed =
            keeper->disturbed || ((balance(keeper->navcomp) - keeper->undisturbed) > (uint32_t)INT32_MAX);
        run_done(keeper, &result);
    } else if (!tumble_keeper_is_idle(keeper)) {
        clear_instead(keeper);
    } else {
        keeper->stale = true;
        if ((keeper->wants & WANT_BEGIN) != 0U) {
            clear_instead(keeper); /* with the means that are gone it would not be what it was wanted for */
        }
    }
}

/* A mean that was dropped must not come back with the next power-on: write the checkpoint anew without it. */
static void check_means(tumble_keeper_t *keeper)
{
    const uint64_t measured = measured_positions(keeper);
    keeper->wants |= ((measured & ~keeper->saved) != 0U) ? (unsigned)WANT_APPEND : 0U;
    keeper->wants |= ((keeper->saved & ~measured) != 0U) ? (unsigned)WANT_BEGIN : 0U;
    if ((keeper->wants & WANT_BEGIN) != 0U) {
        keeper->saved = 0;
    }
}

void tumble_keeper_follow_run(tumble_keeper_t *keeper)
{
    const bool on = tumble_run_is_on(keeper->navcomp);
    if (on && !keeper->run_was_on) {
        begin_run(keeper);
    }
    if (!on && keeper->run_was_on) {
        end_run(keeper);
    }
    if (on) {
        check_means(keeper);
    }
}

/* The checkpoint. */

/* The write failed, so there is no checkpoint. Retry after the next position, not at every step: until then all means
 * count as saved. */
TUMBLE_ONE_COPY static void put_off(tumble_keeper_t *keeper)
{
    keeper->has_checkpoint = false;
    keeper->trying = TRYING_NOTHING;
    keeper->lost = 0;
    keeper->saved = measured_positions(keeper);
}

static void begin_trying(tumble_keeper_t *keeper, uint8_t job)
{
    keeper->tries = (uint8_t)(((keeper->trying == job) ? keeper->tries : 0U) + 1U);
    keeper->trying = job;
}

static void begin_checkpoint(tumble_keeper_t *keeper)
{
    keeper->wants &= (uint8_t)~(unsigned)WANT_BEGIN;
    keeper->saved = 0;
    keeper->lost = 0;
    keeper->has_checkpoint = false;
    begin_trying(keeper, TRYING_TO_BEGIN);
    keeper->fingerprint = fingerprint_of(keeper); /* now: what the run before has left is stored */
    (void)tumble_checkpoint_begin(&keeper->checkpoint, keeper->fingerprint);
}

/* The bit of the mean that is under way; 0: none is. */
static uint64_t tried_mean(const tumble_keeper_t *keeper)
{
    const bool mean = (keeper->trying != (uint8_t)TRYING_NOTHING) && (keeper->trying <= (uint8_t)TUMBLE_MAX_POSITIONS);
    return mean ? bit_of((uint8_t)(keeper->trying - 1U)) : 0U;
}

/* What the memory would not take before it may take now. */
static void end_well(tumble_keeper_t *keeper)
{
    keeper->has_checkpoint = true;
    if (tried_mean(keeper) != 0U) {
        tumble_count(&keeper->counters.checkpoints);
        keeper->saved &= ~keeper->lost;
        keeper->wants |= (keeper->lost != 0U) ? (unsigned)WANT_APPEND : 0U;
        keeper->lost = 0;
    }
    keeper->trying = TRYING_NOTHING;
}

/* Should the failed job of the checkpoint be retried? A mean, only while there is a checkpoint: the failure may have
 * cost all of it. A clear, in any case: what is left of the run before must not be resumed, and a record that cannot be
 * read now may be readable at the next power-on. */
static bool is_to_be_tried(const tumble_keeper_t *keeper)
{
    bool to_be_tried = keeper->checkpoint.kept && keeper->has_checkpoint;
    if (keeper->trying == (uint8_t)TRYING_TO_CLEAR) {
        to_be_tried = true;
    } else if (keeper->trying == (uint8_t)TRYING_TO_BEGIN) {
        to_be_tried = keeper->run_was_on && (keeper->tries < TUMBLE_SETS_TRIES);
    } else {
        /* a mean */
    }
    return to_be_tried;
}

static void try_again(tumble_keeper_t *keeper)
{
    const bool again = keeper->tries < TUMBLE_SETS_TRIES;
    const uint64_t mean = tried_mean(keeper);
    if (!again) {
        keeper->lost |= mean;
        keeper->trying = TRYING_NOTHING;
    } else if (mean != 0U) {
        keeper->saved &= ~mean;
        keeper->wants |= WANT_APPEND;
    } else if (keeper->trying == (uint8_t)TRYING_TO_CLEAR) {
        tumble_keeper_end_checkpoint(keeper);
    } else if (keeper->trying == (uint8_t)TRYING_TO_BEGIN) {
        keeper->wants |= WANT_BEGIN;
    } else {
        /* it looked what is there */
    }
}

tumble_status_t tumble_keeper_step_checkpoint(tumble_keeper_t *keeper)
{
    const tumble_status_t status = tumble_checkpoint_step(&keeper->checkpoint);
    if (status == TUMBLE_OK) {
        end_well(keeper);
    } else if (status == TUMBLE_E_PORT_BUSY) {
        /* it goes on */
    } else if (is_to_be_tried(keeper)) {
        try_again(keeper);
    } else {
        put_off(keeper);
    }
    return status;
}

static void append(tumble_keeper_t *keeper)
{
    const uint64_t missing = measured_positions(keeper) & ~keeper->saved;
    uint8_t p = 0;
    while ((p < positions_of(keeper)) && ((missing & bit_of(p)) == 0U)) {
        p++;
    }
    if (p == positions_of(keeper)) {
        keeper->wants &= (uint8_t)~(unsigned)WANT_APPEND;
        return;
    }
    if (!keeper->has_checkpoint) {
        keeper->wants |= WANT_BEGIN;
        return;
    }
    const tumble_status_t status = tumble_checkpoint_append(&keeper->checkpoint, p, &tumble_keeper_averages(keeper)[p]);
    if (status == TUMBLE_E_FULL) {
        keeper->wants |= WANT_BEGIN; /* of what was measured again only the last remains */
        return;
    }
    keeper->saved |= bit_of(p);
    if (status == TUMBLE_OK) {
        begin_trying(keeper, (uint8_t)(p + 1U));
    } else {
        tumble_keeper_fail(keeper, status);
    }
}

void tumble_keeper_end_checkpoint(tumble_keeper_t *keeper)
{
    keeper->wants |= keeper->run_was_on ? 0U : (unsigned)WANT_CLEAR;
}

/* Called while the memory is at rest: a job is always taken then, and its steps tell how it ends. */
void tumble_keeper_keep_run(tumble_keeper_t *keeper)
{
    if ((keeper->wants & WANT_BEGIN) != 0U) {
        begin_checkpoint(keeper);
    } else if ((keeper->wants & WANT_CLEAR) != 0U) {
        keeper->wants &= (uint8_t)~(unsigned)(WANT_CLEAR | WANT_APPEND);
        keeper->resumable = 0;
        begin_trying(keeper, TRYING_TO_CLEAR);
        (void)tumble_checkpoint_clear(&keeper->checkpoint);
    } else if ((keeper->wants & WANT_APPEND) != 0U) {
        append(keeper);
    } else {
        /* nothing to do */
    }
}

/* After a loss of power. */

static bool is_fit(const tumble_keeper_t *keeper, uint8_t index)
{
    return tumble_checkpoint_has(&keeper->checkpoint, index) && ((keeper->unfit & bit_of(index)) == 0U);
}

/* One that is about to be cleared holds none. */
void tumble_keeper_count_resumable(tumble_keeper_t *keeper)
{
    const bool idle = tumble_keeper_is_idle(keeper) && ((keeper->wants & WANT_CLEAR) == 0U);
    keeper->resumable = 0;
    if (idle && tumble_checkpoint_matches(&keeper->checkpoint, fingerprint_of(keeper))) {
        for (uint8_t p = 0; p < positions_of(keeper); p++) {
            keeper->resumable = (uint8_t)(keeper->resumable + (is_fit(keeper, p) ? 1U : 0U));
        }
    }
}

static tumble_status_t refuse(tumble_keeper_t *keeper)
{
    tumble_count(&keeper->counters.not_resumed);
    return TUMBLE_E_STATE;
}

tumble_status_t tumble_keeper_resume(tumble_keeper_t *keeper)
{
    if ((keeper->task != (uint8_t)TASK_NONE) || keeper->stale || tumble_keeper_busy(keeper)) {
        return refuse(keeper);
    }
    keeper->unfit = 0; /* a command tries all of them again */
    tumble_keeper_count_resumable(keeper);
    if (keeper->resumable == 0U) {
        return refuse(keeper);
    }
    keeper->fingerprint = fingerprint_of(keeper);
    keeper->saved = 0;
    keeper->lost = 0;
    keeper->checkpoint.margins = (tumble_margins_t){UINT8_MAX, UINT8_MAX}; /* each mean brings its own along */
    keeper->task = TASK_RESTORE;
    keeper->at = 0;
    return TUMBLE_OK;
}

/* All kept means have been put back. Only the configuration can have changed since the command: check it again. */
static void go_on(tumble_keeper_t *keeper)
{
    keeper->task = TASK_NONE;
    if ((keeper->fingerprint != fingerprint_of(keeper)) || tumble_keeper_is_inhibited(keeper) ||
        (tumble_navcomp_obey(keeper->navcomp, TUMBLE_COMMAND_RESUME, 0) != TUMBLE_OK)) {
        (void)refuse(keeper);
        tumble_keeper_count_resumable(keeper); /* for what cannot be put back nothing waits */
        return;
    }
    begin_part(keeper, false); /* a reset may have taken the counters away */
    tumble_count(&keeper->counters.resumed);
    keeper->has_checkpoint = true;
    keeper->run_was_on = true;
    keeper->run_resumed = true;
    forget_temperatures(keeper);
    keeper->resumable = 0;
}

void tumble_keeper_restore(tumble_keeper_t *keeper)
{
    tumble_average_t mean;
    while ((keeper->at < positions_of(keeper)) && !tumble_checkpoint_has(&keeper->checkpoint, keeper->at)) {
        keeper->at++;
    }
    if (keeper->at == positions_of(keeper)) {
        go_on(keeper);
        return;
    }
    tumble_status_t status = tumble_checkpoint_read(&keeper->checkpoint, keeper->at, &mean);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status == TUMBLE_OK) {
        status = tumble_procedure_restore(&keeper->navcomp->procedure, keeper->at, &mean);
    }
    uint64_t *const means = (status == TUMBLE_OK) ? &keeper->saved : &keeper->unfit;
    *means |= bit_of(keeper->at);
    keeper->at++;
}
