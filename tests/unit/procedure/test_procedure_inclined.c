/* The procedure with the estimator `inclined`: a block that is bolted on once, on a stand whose inclinations nobody has
 * measured. */
#include "estimator_bench.h"
#include "procedure_bench.h"
#include "tumble/core.h"

#include <math.h>

static tumble_inclinations_t seen;
static tumble_inclined_source_t source;
static tumble_lent_t lent;
static tumble_mounting_t nominal[3];
static tumble_mounting_t truth[3];
static tumble_schedule_t schedule;

static tumble_angle_t tilt_of(double deg)
{
    return (tumble_angle_t){deg, sin(deg * 3.14159265358979323846 / 180.0), cos(deg * 3.14159265358979323846 / 180.0)};
}

/* What the schedule says of its three inclinations, and where the stand is in truth. */
static void incline(const double says_deg[3], const double is_deg[3])
{
    for (int k = 0; k < 3; k++) {
        nominal[k] = tumble_schedule_inclined.mountings[k];
        truth[k] = nominal[k];
        nominal[k].tilt = tilt_of(says_deg[k]);
        truth[k].tilt = tilt_of(is_deg[k]);
    }
}

static void set_up(void)
{
    static const double says_deg[3] = {0.0, 45.0, -45.0};
    static const double is_deg[3] = {0.7, 43.1, -46.6};
    incline(says_deg, is_deg);
    schedule = (tumble_schedule_t){nominal, tumble_schedule_inclined.positions, 3, 27};
    memset(&seen, 0x5A, sizeof seen);
    source = (tumble_inclined_source_t){NULL, &seen};
    lent = (tumble_lent_t){.estimator = TUMBLE_ESTIMATE_INCLINED,
                           .check = tumble_inclined_check,
                           .estimate = tumble_inclined_estimate,
                           .uncertainty = tumble_inclined_uncertainty,
                           .source = &source};
    bench_init(&bench);
    bench.config.estimate = TUMBLE_ESTIMATE_INCLINED;
    bench.config.lent = &lent;
    bench.config.schedule = &schedule;
    bench.block.truth = truth;
}

static tumble_coefficients_t coefficients_of_a_run(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
    bench_start_to_done(&bench);
    TEST_ASSERT_TRUE(bench_result(&bench).pass);
    return *bench_result(&bench).coefficients;
}

/* What the core makes of the same means, to the bit. */
static void assert_as_the_core_has_it(const tumble_coefficients_t *found, const double *weights)
{
    static tumble_means_t means;
    static const tumble_stand_record_t stand = {.remount_rad = 4e-4, .angle_rad = 4e-5, .noise_v = 3e-4, .samples = 20};
    tumble_coefficients_t expected;
    tumble_inclinations_t shown;
    ASSERT_STATUS(TUMBLE_OK, tumble_averaging_means(tumble_procedure_averages(&bench.procedure), V_PER_COUNT, &means));
    ASSERT_STATUS(TUMBLE_OK, tumble_inclined_weighted(&schedule, &means, weights, &expected, &shown, NULL));
    assert_same_coefficients(&expected, found);
    TEST_ASSERT_EQUAL_MEMORY(shown.sine, seen.sine, 3 * sizeof seen.sine[0]);
    TEST_ASSERT_EQUAL_MEMORY(shown.turn_sine, seen.turn_sine, 3 * sizeof seen.turn_sine[0]);

    const tumble_judged_run_t run = {
        .schedule = &schedule, .stand = &stand, .coefficients = found, .inclinations = &shown, .weights = weights};
    tumble_judged_run_t asked = run;
    tumble_uncertainty_t of_core;
    tumble_uncertainty_t stated;
    asked.inclinations = NULL; /* the source has its own */
    asked.weights = NULL;
    ASSERT_STATUS(TUMBLE_OK, tumble_uncertainty_inclined(&run, &of_core, NULL));
    ASSERT_STATUS(TUMBLE_OK, lent.uncertainty(lent.source, &asked, &stated));
    TEST_ASSERT_EQUAL_MEMORY(&of_core, &stated, sizeof stated);
}

static void test_a_run_is_solved_without_its_inclinations(void)
{
    tumble_coefficients_t block;
    bench.block.noise_counts = 0;
    memcpy(block.k_v_per_g, bench.block.k_v_per_g, sizeof block.k_v_per_g);
    memcpy(block.u0_v, bench.block.u0_v, sizeof block.u0_v);
    const tumble_coefficients_t found = coefficients_of_a_run();
    assert_coefficients(&block, &found, 1e-6); /* half a count of a mean */
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(2e-6, truth[k].tilt.sine, seen.sine[k]);
    }
    assert_as_the_core_has_it(&found, NULL);
}

static void test_channels_weigh_as_the_board_says(void)
{
    static const double weights[3] = {1.0, 0.5, 3.0};
    source.weights = weights;
    const tumble_coefficients_t found = coefficients_of_a_run();
    assert_as_the_core_has_it(&found, weights);
    source.weights = NULL;
    set_up();
    const tumble_coefficients_t of_equal = coefficients_of_a_run();
    TEST_ASSERT_TRUE(memcmp(&found, &of_equal, sizeof found) != 0);
}

/* A board may lend both: the configured one is asked, wherever it stands. */
static void test_of_two_that_are_lent_the_configured_one_is_asked(void)
{
    static tumble_optimal_t work;
    static const tumble_optimal_source_t no_record = {NULL, 0, &work};
    tumble_lent_t optimal = {.estimator = TUMBLE_ESTIMATE_OPTIMAL,
                             .check = tumble_optimal_check,
                             .estimate = tumble_optimal_estimate,
                             .uncertainty = tumble_optimal_uncertainty,
                             .source = &no_record,
                             .next = &lent};
    bench.config.lent = &optimal;
    const tumble_coefficients_t found = coefficients_of_a_run();
    assert_as_the_core_has_it(&found, NULL);
    TEST_ASSERT_EQUAL_PTR(&lent, tumble_procedure_lent(&bench.config));
    optimal.next = NULL;
    TEST_ASSERT_NULL(tumble_procedure_lent(&bench.config));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_validate(&bench.config, NULL));
    lent.next = &optimal;
    bench.config.lent = &lent;
    bench.config.estimate = TUMBLE_ESTIMATE_OPTIMAL;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_validate(&bench.config, NULL)); /* no memory of a record */
    TEST_ASSERT_EQUAL_PTR(&optimal, tumble_procedure_lent(&bench.config));
    bench.config.estimate = TUMBLE_ESTIMATE_REFINED;
    TEST_ASSERT_NULL(tumble_procedure_lent(&bench.config));
}

static void assert_never_begins(tumble_status_t expected, tumble_reason_t why)
{
    tumble_reason_t reason = TUMBLE_REASON_NONE;
    ASSERT_STATUS(expected, tumble_procedure_validate(&bench.config, &reason));
    TEST_ASSERT_EQUAL_STRING(tumble_reason_name(why), tumble_reason_name(reason));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, why);
    ASSERT_STATUS(expected, bench_progress(&bench).status);
    TEST_ASSERT_EQUAL_UINT(0, bench.stand.moves);
}

static void test_a_run_does_not_begin_on_a_schedule_without_inclinations(void)
{
    const tumble_schedule_t *const without[] = {&tumble_schedule_paper, &tumble_schedule_diagonal, &schedule};
    nominal[1].bolting = 2; /* bolted on anew */
    for (size_t i = 0; i < COUNT_OF(without); i++) {
        bench.config.schedule = without[i];
        assert_never_begins(TUMBLE_E_NOT_INCLINED, TUMBLE_REASON_SCHEDULE);
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_abort(&bench.procedure));
    }
}

static void test_a_run_does_not_begin_without_what_the_board_must_lend(void)
{
    static const double weights[][3] = {{1.0, 0.0, 1.0}, {1.0, 1.0, -1.0}, {NAN, 1.0, 1.0}, {1.0, 1.0, INFINITY}};
    for (size_t i = 0; i < COUNT_OF(weights); i++) {
        source.weights = weights[i];
        assert_never_begins(TUMBLE_E_ARGUMENT, TUMBLE_REASON_CONFIGURATION);
    }
    source = (tumble_inclined_source_t){NULL, NULL};
    assert_never_begins(TUMBLE_E_ARGUMENT, TUMBLE_REASON_CONFIGURATION);
    lent.source = NULL;
    assert_never_begins(TUMBLE_E_ARGUMENT, TUMBLE_REASON_CONFIGURATION);
    bench.config.lent = NULL;
    assert_never_begins(TUMBLE_E_ARGUMENT, TUMBLE_REASON_CONFIGURATION);
}

static void test_without_memory_nothing_is_estimated_or_stated(void)
{
    static const tumble_means_t means;
    const tumble_inclined_source_t no_memory = {NULL, NULL};
    const void *const sources[] = {NULL, &no_memory};
    const tumble_judged_run_t run = {.schedule = &schedule};
    tumble_coefficients_t found;
    tumble_uncertainty_t stated;
    for (size_t i = 0; i < COUNT_OF(sources); i++) {
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_inclined_estimate(sources[i], &schedule, &means, &found));
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_inclined_uncertainty(sources[i], &run, &stated));
    }
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_inclined_uncertainty(&source, NULL, &stated));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_inclined_uncertainty(&source, &run, NULL));
}

/* Before each mounting: is the block to be mounted, or the stand inclined, and how far? */
static void test_the_operator_is_asked_to_incline_where_the_block_stays_bolted(void)
{
    static const struct {
        const tumble_schedule_t *schedule;
        tumble_estimate_t estimate;
        uint8_t mountings;
        bool stays[3];
        double deg[3];
    } cases[] = {{&schedule, TUMBLE_ESTIMATE_INCLINED, 3, {false, true, true}, {0.0, 45.0, -45.0}},
                 {&tumble_schedule_paper, TUMBLE_ESTIMATE_REFINED, 2, {false, false}, {0.0, 0.0}},
                 {&schedule, TUMBLE_ESTIMATE_LEAST_SQUARES, 3, {false, false, true}, {0.0, 45.0, -45.0}}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        bench.mounted = 0;
        bench.config.schedule = cases[i].schedule;
        bench.config.estimate = cases[i].estimate;
        bench.block.truth = (cases[i].schedule == &schedule) ? truth : NULL;
        nominal[0].bolting =
            (cases[i].estimate == TUMBLE_ESTIMATE_LEAST_SQUARES) ? 0 : 1; /* then two in a row are left */
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
        TEST_ASSERT_FALSE(bench_progress(&bench).stays_bolted);
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
        for (uint8_t m = 0; m < cases[i].mountings; m++) {
            bench.operator_is_away = true;
            bench_run_to(&bench, TUMBLE_STATE_WAIT_MOUNTING);
            const tumble_progress_t progress = bench_progress(&bench);
            TEST_ASSERT_EQUAL_UINT(m + 1U, progress.mounting);
            TEST_ASSERT_EQUAL(cases[i].stays[m], progress.stays_bolted);
            ASSERT_SAME_DOUBLE(cases[i].deg[m], progress.inclination_deg);
            bench.operator_is_away = false;
            bench_ticks(&bench, 2);
        }
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_abort(&bench.procedure));
    }
}

/* Whoever forgets to incline is told by gravity, as with a wrong mounting, and goes on. */
static void test_a_stand_that_was_not_inclined_is_noticed(void)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
    bench.operator_mounts = 0;
    ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_WRONG_MOUNTING);
    TEST_ASSERT_EQUAL_UINT(2, bench_progress(&bench).mounting);
    bench.operator_mounts = UINT8_MAX;
    bench.mounted = 1;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_confirm_mounting(&bench.procedure, 2));
    bench_run_to_done(&bench);
    const tumble_coefficients_t found = *bench_result(&bench).coefficients;
    assert_as_the_core_has_it(&found, NULL);
}

/* Inclinations too small for gravity to tell them apart beforehand: the run itself must. */
static void test_a_run_that_shows_no_inclinations_ends_in_a_fault(void)
{
    static const double says_deg[3] = {0.0, 3.0, -3.0};
    static const struct {
        double is_deg[3];
        tumble_status_t status;
    } cases[] = {
        {{0.0, 0.0, 0.0}, TUMBLE_E_ALIKE}, {{2.0, 2.0, 2.0}, TUMBLE_E_ALIKE}, {{3.0, 5.0, 1.0}, TUMBLE_E_ONE_SIDE}};
    bench.block.noise_counts = 0;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        tumble_result_t result;
        incline(says_deg, cases[i].is_deg);
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&bench.procedure, &bench.config, &bench.table));
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&bench.procedure));
        ASSERT_ENDS(&bench, TUMBLE_STATE_FAULT, TUMBLE_REASON_SINGULAR);
        ASSERT_STATUS(cases[i].status, bench_progress(&bench).status);
        ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_result(&bench.procedure, &result));
    }
}
