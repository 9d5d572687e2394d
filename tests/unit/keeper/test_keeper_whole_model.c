/* The whole-model test on board: in steps after a run, an objection of its own, readable, and gone with power. */
#include "keeper_sdo.h"
#include "keeper_world.h"

#define BEYOND TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_WHOLE_MODEL)
#define TESTING 4U /* tumble_keeper_t.task */
#define UTC_S 1800000000U
#define FIT 0x2025U
#define CHI_SQUARED 1U
#define LIMIT 2U
#define MISFIT 3U
#define FREEDOM 4U

static tumble_whole_work_t whole_work;
static uint32_t steps;

static bool count_step(tumble_whole_work_t *work, const tumble_misfit_run_t *run)
{
    steps++;
    return tumble_whole_step(work, run);
}

static void set_up(void)
{
    memset(&whole_work, 0xA5, sizeof whole_work);
    keeper_sdo_power_on();
    keeper_config.sets.whole_step = count_step;
    keeper_config.sets.whole_work = &whole_work;
    steps = 0;
}

static void go_to_the_middle(void)
{
    for (int i = 0; i < 3000; i++) {
        if ((keeper.task == TESTING) && whole_work.under_way && (whole_work.round == 2U)) {
            return;
        }
        bench_event(&bench);
    }
    TEST_FAIL_MESSAGE("never in the middle");
}

/* A block that a run does not fit: between its mountings a bias moves, by less than the gravity check notices. */
static void run_and_move(double by_v)
{
    bench.logged = 0;
    start_to_average(9);
    drift(-by_v / 2.0);
    bench.block.u0_v[0] += by_v;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
}

static void test_a_run_that_fits_is_committed(void)
{
    run_to_done();
    const uint32_t before = bench.events;
    settle_to(TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_TRUE((steps > 1000U) && (steps < 1300U));
    TEST_ASSERT_TRUE((bench.events - before) > steps); /* one in a step of the computer */
    assert_objects(0);
    const double chi_squared = read_f64(FIT, CHI_SQUARED);
    TEST_ASSERT_EQUAL_DOUBLE(whole_work.chi_squared, chi_squared);
    TEST_ASSERT_TRUE(chi_squared < read_f64(FIT, LIMIT));
    TEST_ASSERT_TRUE(fabs(read_f64(FIT, LIMIT) - 76.17) < 0.01);
    TEST_ASSERT_EQUAL_DOUBLE(sqrt(chi_squared / 42.0), read_f64(FIT, MISFIT));
    TEST_ASSERT_EQUAL_UINT32(42, read_number(FIT, FREEDOM, 1));
}

static void test_until_it_is_known_reading_is_refused(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(FIT, CHI_SQUARED));
    run_to_done();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(FIT, CHI_SQUARED));
    go_to_the_middle();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(FIT, FREEDOM));
    ASSERT_STATUS(TUMBLE_E_STATE, tell(TUMBLE_COMMAND_START)); /* the means must stay */
    assert_verdict(TUMBLE_VERDICT_WORKING);
    settle_memory();
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(FIT, FREEDOM));
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(FIT, FREEDOM));
}

/* Held, and in force when an operator says so: the reason stays with the set. */
static void test_a_run_that_does_not_fit_is_held_unless_forced(void)
{
    run_and_move(3e-4);
    settle_to(TUMBLE_VERDICT_HELD);
    assert_objects(BEYOND);
    TEST_ASSERT_EQUAL_HEX16(BEYOND, set_of(TUMBLE_SET_PROPOSAL).reasons);
    TEST_ASSERT_TRUE(read_f64(FIT, CHI_SQUARED) > read_f64(FIT, LIMIT));
    TEST_ASSERT_EQUAL_UINT32(0, keeper.sequence);
    decide(TUMBLE_COMMAND_ACCEPT);
    assert_verdict(TUMBLE_VERDICT_ACCEPTED);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
    TEST_ASSERT_EQUAL_HEX16(BEYOND, set_of(TUMBLE_SET_ACTIVE).reasons);
}

static void test_the_next_run_is_judged_by_itself(void)
{
    run_and_move(3e-4);
    settle_memory();
    assert_objects(BEYOND);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    TEST_ASSERT_TRUE(read_f64(FIT, CHI_SQUARED) < read_f64(FIT, LIMIT));
}

/* The checkpoint lasts until the result is stored. The memory of the test is lost with power. */
static void test_a_loss_of_power_in_the_middle_loses_nothing(void)
{
    run_and_move(3e-4);
    go_to_the_middle();
    memset(&whole_work, 0x5A, sizeof whole_work);
    keeper_power_cycle_for(1.0);
    assert_verdict(TUMBLE_VERDICT_NONE);
    assert_resumable(POSITIONS);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(FIT, CHI_SQUARED));
    resume_to_end();
    assert_verdict(TUMBLE_VERDICT_HELD);
    assert_objects(BEYOND);
}

static void test_a_reset_in_the_middle_loses_nothing(void)
{
    run_to_done();
    go_to_the_middle();
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 0.0);
    bench_event(&bench);
    settle_to(TUMBLE_VERDICT_NONE);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(FIT, CHI_SQUARED));
    resume_to_commit();
    TEST_ASSERT_TRUE(read_f64(FIT, CHI_SQUARED) < read_f64(FIT, LIMIT));
}

/* A stop of the table and an inhibit do not touch a run that is done. */
static void test_an_inhibit_in_the_middle_changes_nothing(void)
{
    run_and_move(3e-4);
    go_to_the_middle();
    tumble_keeper_inhibit(&keeper, 60);
    (void)tell(TUMBLE_COMMAND_ABORT);
    settle_to(TUMBLE_VERDICT_HELD);
    assert_objects(BEYOND);
}

static void test_without_a_declared_stand_nobody_asks(void)
{
    (void)run_and_judge();
    TEST_ASSERT_TRUE(whole_work.known);
    steps = 0;
    bench.config.declared = NULL;
    keeper_power_cycle();
    drift(1e-4);
    (void)run_and_judge();
    TEST_ASSERT_EQUAL_UINT32(0, steps);
    TEST_ASSERT_EQUAL_HEX16(0, state_of_keeper().objections & BEYOND);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(FIT, CHI_SQUARED));
}

static void test_a_board_without_the_test_holds_nothing(void)
{
    keeper_config.sets.whole_step = NULL;
    keeper_config.sets.whole_work = NULL;
    run_and_move(3e-4);
    settle_to(TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(FIT, CHI_SQUARED));
}

/* On the simulated bench: the stand of the examples, and a block that is not what the model says. */

#define PAPER                                                                                                          \
    "stand.limits = sigma1\noperator.mend_s = -1\nblock.scale_v_per_g = 2\nstand.axis_tilt_rad = 2e-5\n"               \
    "stand.level_rad = 2e-5\nstand.remount_rad = 4e-4\nstand.angle_rad = 4e-5\nblock.noise_v = 3e-4 3e-4 3e-4\n"

static tumble_sets_state_t run_simulated(const char *more, uint64_t seed)
{
    static char text[2048];
    (void)snprintf(text, sizeof text, PAPER "%s", more);
    memory_init(&memory);
    kept_world_prepare(text);
    keeper_config.sets.whole_step = tumble_whole_step;
    keeper_config.sets.whole_work = &whole_work;
    return kept_world_run(seed, UTC_S);
}

static void test_simulated_runs(void)
{
    static const struct {
        const char *what;
        const char *lines;
        tumble_verdict_t verdict;
        uint16_t objections;
    } cases[] = {
        {"honest", "", TUMBLE_VERDICT_COMMITTED, 0},
        {"declared seats", "stand.seat_rad = 1e-4\nstand.platform_rad = 1e-4\n", TUMBLE_VERDICT_COMMITTED, 0},
        {"declared encoder and drift", "stand.encoder_rad = 2e-4\nstand.drift_v = 1e-3\n", TUMBLE_VERDICT_COMMITTED, 0},
        {"second order", "block.k2_per_g = 1e-4 1e-4 1e-4\n", TUMBLE_VERDICT_HELD, BEYOND},
        {"drift", "block.drift_v_per_h = 1.5e-2 1.5e-2 1.5e-2\n", TUMBLE_VERDICT_HELD, BEYOND},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const tumble_sets_state_t state = run_simulated(cases[i].lines, 11U);
        char text[120];
        (void)snprintf(text, sizeof text, "%s: %.1f of %.1f, misfit %.2f, objections %X", cases[i].what,
                       whole_work.chi_squared, whole_work.limit, whole_work.misfit, (unsigned)state.objections);
        TEST_MESSAGE(text);
        TEST_ASSERT_EQUAL_UINT8_MESSAGE(cases[i].verdict, state.verdict, text);
        TEST_ASSERT_EQUAL_HEX16_MESSAGE(cases[i].objections, state.objections, text);
    }
}
