/* The uncertainties of a result are computed once, one coefficient a step, and are read as often as anybody likes. */
#include "keeper_sdo.h"

#define MOST_CALLS 64U

static uint16_t asked[MOST_CALLS];
static uint32_t asked_at[MOST_CALLS]; /* event of the bench */
static uint32_t calls;
static uint32_t fails_at;

static tumble_status_t count_call(const tumble_navcomp_t *navcomp, uint16_t coefficients,
                                  tumble_uncertainty_t *uncertainty)
{
    TEST_ASSERT_LESS_THAN_UINT32(MOST_CALLS, calls);
    asked[calls] = coefficients;
    asked_at[calls] = bench.events;
    calls++;
    return (calls == fails_at) ? TUMBLE_E_NOT_FINITE : tumble_navcomp_uncertainty(navcomp, coefficients, uncertainty);
}

static void set_up(void)
{
    keeper_sdo_power_on();
    keeper_config.uncertainty = count_call;
    calls = 0;
    fails_at = 0;
}

static void test_every_coefficient_once_and_in_steps_of_its_own(void)
{
    run_to_done();
    settle_memory();
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_COEFFICIENTS, calls);
    for (uint32_t c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        TEST_ASSERT_EQUAL_HEX16(1U << c, asked[c]);
        TEST_ASSERT_TRUE((c == 0U) || (asked_at[c] > asked_at[c - 1U]));
    }
}

static void test_the_noise_is_looked_at_in_a_step_of_its_own(void)
{
    static tumble_run_noise_t noise;
    declared.take = tumble_navcomp_take_noise;
    declared.noise = &noise;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2026, 1));
    run_to_done();
    while (calls < 2U) {
        bench_event(&bench);
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2023, 1));
    settle_memory();
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_COEFFICIENTS + 1, calls);
    TEST_ASSERT_EQUAL_HEX16(1, asked[0]);
    TEST_ASSERT_EQUAL_HEX16(1, asked[1]);
    TEST_ASSERT_TRUE(asked_at[1] > asked_at[0]);
    TEST_ASSERT_EQUAL_HEX16(2, asked[2]);
    for (uint8_t i = 0; i < 3U; i++) {
        TEST_ASSERT_TRUE(read_f64(0x2026, (uint8_t)(i + 1U)) == noise.seen.noise_v[i]);
    }
    TEST_ASSERT_TRUE(read_f64(0x2026, 4) == 1e-5);
    TEST_ASSERT_EQUAL_UINT8(noise.seen.above, read_number(0x2026, 5, 1));
    TEST_ASSERT_EQUAL_UINT8(noise.seen.undithered, read_number(0x2026, 6, 1));
    TEST_ASSERT_TRUE((noise.seen.noise_v[2] > 0.0) && (noise.blocks.pairs[0] >= POSITIONS));
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2026, 1));
}

/* The checkpoint of the last position is kept first: while the memory is busy, the noise is still to come. */
static void test_until_it_is_looked_at_noise_is_refused(void)
{
    static tumble_run_noise_t noise;
    declared.take = tumble_navcomp_take_noise;
    declared.noise = &noise;
    start_to_average(POSITIONS - 1U);
    memory.busy_every = 1;
    TEST_ASSERT_EQUAL(TUMBLE_STATE_DONE, bench_run(&bench, TUMBLE_STATE_DONE, 600.0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2026, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2026, 6));
    memory.busy_every = 0;
    settle_memory();
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2026, 1));
}

static void test_without_memory_for_it_no_noise_is_told(void)
{
    (void)run_and_judge();
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2023, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2026, 1));
}

static void test_reading_computes_nothing(void)
{
    tumble_uncertainty_t u;
    (void)run_and_judge();
    const uint32_t before = calls;
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_uncertainty(&bench.navcomp, TUMBLE_ALL_COEFFICIENTS, &u));
    for (int times = 0; times < 2; times++) {
        assert_told(u.k_v_per_g, u.u0_v, 0x2023, 0x2024);
    }
    TEST_ASSERT_EQUAL_UINT32(before, calls);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START)); /* there is no result any more */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2023, 1));
}

/* Between DONE and the twelfth coefficient: ask again. The verdict waits as well. */
static void test_until_they_are_ready_reading_is_refused(void)
{
    run_to_done();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2023, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, refusal_of(0x2024, 3));
    TEST_ASSERT_LESS_THAN_UINT32(TUMBLE_COEFFICIENTS, calls);
    assert_verdict(TUMBLE_VERDICT_WORKING);
    TEST_ASSERT_TRUE(state_of_keeper().busy);
    const uint64_t done_us = bench.fake.now_us;
    settle_memory();
    TEST_ASSERT_EQUAL_HEX32(0, refusal_of(0x2023, 1));
    assert_verdict(TUMBLE_VERDICT_COMMITTED);
    TEST_ASSERT_TRUE((bench.fake.now_us - done_us) < 500000U);
}

static void test_one_that_fails_leaves_none(void)
{
    fails_at = 5;
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_and_judge());
    TEST_ASSERT_EQUAL_UINT32(5, calls);
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, refusal_of(0x2023, 1));
}

/* Another estimator is written before they are all there: they would be those of neither. */
static void test_of_another_estimator_there_are_none(void)
{
    run_to_done();
    bench.navcomp.procedure_config.estimate = TUMBLE_ESTIMATE_AVERAGED;
    settle_to(TUMBLE_VERDICT_HELD);
    assert_objects(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN));
}

/* Three u(|a|) at the worst attitude, against the limit of the gravity check. */

static double told_g;
static uint32_t norms;

static tumble_status_t tell_norm(const tumble_navcomp_t *navcomp, const double attitude[3], double *norm_g)
{
    (void)navcomp;
    const double square = (attitude[0] * attitude[0]) + (attitude[1] * attitude[1]) + (attitude[2] * attitude[2]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0, square);
    norms++;
    *norm_g = told_g;
    return (told_g < 0.0) ? TUMBLE_E_NOT_FINITE : TUMBLE_OK;
}

static tumble_verdict_t judged_with(double norm_g)
{
    told_g = norm_g;
    norms = 0;
    keeper_config.norm = tell_norm;
    return run_and_judge();
}

static void assert_not_shown(void)
{
    assert_objects(0);
    TEST_ASSERT_EQUAL_HEX16(1, state_of_keeper().more_objections);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_NOT_SHOWN), set_of(TUMBLE_SET_PROPOSAL).reasons);
    ASSERT_READS({0x2120, 6, 2, 0}, {0x2120, 15, 2, 1}, {0x2102, 13, 4, 0x10000});
}

static void test_within_the_limit_it_is_committed(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, judged_with(0.999e-4));
    TEST_ASSERT_EQUAL_UINT32(50, norms); /* 26, and four rounds of six that lead nowhere */
    TEST_ASSERT_EQUAL_HEX16(0, read_number(0x2120, 15, 2));
}

static void test_beyond_the_limit_it_is_held(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, judged_with(1.001e-4));
    assert_not_shown();
    decide(TUMBLE_COMMAND_ACCEPT);
    assert_verdict(TUMBLE_VERDICT_ACCEPTED);
}

static void test_what_cannot_be_judged_is_not_shown(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, judged_with(-1.0));
    TEST_ASSERT_EQUAL_UINT32(1, norms);
    assert_not_shown();
}

static void test_a_seat_that_is_declared_coarse_is_not_shown(void)
{
    declared_stand.seat_rad = 1.6e-4;
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, run_and_judge());
    assert_not_shown();
}

static void test_a_board_that_does_not_ask_has_no_such_objection(void)
{
    declared_stand.seat_rad = 1.6e-4;
    keeper_config.norm = NULL;
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
}

/* A reset takes the means away. What is in the checkpoint goes on, as after a loss of power. */
static void test_a_reset_meanwhile_loses_nothing(void)
{
    run_to_done();
    for (int i = 0; i < 200; i++) {
        bench_event(&bench);
        if (keeper.task == 3U) { /* does it fit? */
            break;
        }
    }
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 0.0);
    bench_event(&bench);
    TEST_ASSERT_EQUAL(TUMBLE_STATE_IDLE, run_state());
    settle_to(TUMBLE_VERDICT_NONE);
    TEST_ASSERT_EQUAL_UINT32(0, keeper.sequence);
    assert_resumable(POSITIONS);
    resume_to_commit();
}
