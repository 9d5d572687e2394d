/* A run that lost power: cut at every position, gone on with on the same samples, and the result is the same to the last
 * bit. Samples are a function of the position and of their number in it, so both runs see the same ones. */
#include "procedure_bench.h"

#define POSITIONS 18U

static bench_t whole;
static bench_t cut;
static bench_t resumed;
static tumble_average_t kept[POSITIONS]; /* what a checkpoint would hold */
static bool is_kept[POSITIONS];

static void set_up(void)
{
    memset(is_kept, 0, sizeof is_kept);
}

/* The noise of a position begins anew with it, whoever measures it and when. */
static void tick(bench_t *b)
{
    const tumble_progress_t progress = bench_progress(b);
    if (progress.state != TUMBLE_STATE_AVERAGE) {
        b->block.dice.state = 1000U + progress.index;
    }
    bench_tick(b);
}

static void run(bench_t *b)
{
    for (int i = 0; (i < 60000) && !bench_has_ended(b); i++) {
        tick(b);
    }
    ASSERT_ENDED(b, TUMBLE_STATE_DONE, TUMBLE_REASON_NONE);
}

/* Up to the sample `samples` of the position at `index`, keeping every mean as soon as it is finished. */
static void run_to_cut(bench_t *b, uint8_t index, uint32_t samples)
{
    for (int i = 0; i < 60000; i++) {
        const tumble_progress_t progress = bench_progress(b);
        for (uint8_t p = 0; p < POSITIONS; p++) {
            if (tumble_procedure_has_mean(&b->procedure, p) && !is_kept[p]) {
                kept[p] = tumble_procedure_averages(&b->procedure)->averages[p];
                is_kept[p] = true;
            }
        }
        if ((progress.index == index) && (progress.state == TUMBLE_STATE_AVERAGE) && (progress.samples >= samples)) {
            return;
        }
        tick(b);
    }
    TEST_FAIL_MESSAGE("the position is never reached");
}

static void start_to_cut(bench_t *b, uint8_t index, uint32_t samples)
{
    bench_start(b);
    run_to_cut(b, index, samples);
}

static void restore_all(bench_t *b)
{
    for (uint8_t p = 0; p < POSITIONS; p++) {
        if (is_kept[p]) {
            ASSERT_STATUS(TUMBLE_OK, tumble_procedure_restore(&b->procedure, p, &kept[p]));
        }
    }
}

static void assert_same_result(const bench_t *a, const bench_t *b)
{
    tumble_result_t first;
    tumble_result_t second;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_result(&a->procedure, &first));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_result(&b->procedure, &second));
    TEST_ASSERT_EQUAL_MEMORY(first.coefficients, second.coefficients, sizeof *first.coefficients);
    TEST_ASSERT_EQUAL_MEMORY(first.calibration, second.calibration, sizeof *first.calibration);
    TEST_ASSERT_EQUAL_MEMORY(first.check->delta_g_g, second.check->delta_g_g, sizeof first.check->delta_g_g);
    for (uint8_t p = 0; p < POSITIONS; p++) {
        TEST_ASSERT_EQUAL_MEMORY(&tumble_procedure_averages(&a->procedure)->averages[p],
                                 &tumble_procedure_averages(&b->procedure)->averages[p], sizeof(tumble_average_t));
    }
    for (uint8_t m = 0; m < 2U; m++) {
        ASSERT_SAME_DOUBLE(tumble_procedure_closure_g(&a->procedure, m), tumble_procedure_closure_g(&b->procedure, m));
    }
}

static void cut_and_resume(uint8_t index, uint32_t samples)
{
    set_up();
    start_to_cut(&cut, index, samples);
    bench_init(&resumed);
    resumed.block.counter = 12345; /* the block has been switched off, too */
    restore_all(&resumed);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&resumed.procedure));
    run(&resumed);
    assert_same_result(&whole, &resumed);
    TEST_ASSERT_EQUAL_UINT32(POSITIONS - index, tumble_procedure_counters(&resumed.procedure)->positions);
    TEST_ASSERT_EQUAL_UINT(1, resumed.stand.homes);
    TEST_ASSERT_EQUAL_UINT((index < 9U) ? 2 : 1, resumed.confirmations);
}

static void test_cut_anywhere_the_result_is_the_same(void)
{
    bench_start(&whole);
    run(&whole);
    for (uint8_t index = 1; index < POSITIONS; index++) {
        cut_and_resume(index, 0);  /* as it begins */
        cut_and_resume(index, 11); /* in the middle of averaging */
        cut_and_resume(index, 19); /* one sample from its end */
    }
}

static void test_a_run_that_was_all_measured_needs_no_stand(void)
{
    bench_start(&whole);
    run(&whole);
    bench_init(&resumed);
    for (uint8_t p = 0; p < POSITIONS; p++) {
        const tumble_average_t *average = &tumble_procedure_averages(&whole.procedure)->averages[p];
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_restore(&resumed.procedure, p, average));
    }
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&resumed.procedure));
    run(&resumed);
    assert_same_result(&whole, &resumed);
    TEST_ASSERT_EQUAL_UINT(0, resumed.confirmations);
    TEST_ASSERT_EQUAL_UINT(0, resumed.stand.moves);
}

/* Whoever mounts the block anew measures the mounting anew: repeat_mounting says so. */
static void test_a_mounting_touched_meanwhile_is_repeated(void)
{
    start_to_cut(&cut, 5, 3);
    bench_init(&resumed);
    resumed.operator_is_away = true;
    restore_all(&resumed);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&resumed.procedure));
    bench_run_to(&resumed, TUMBLE_STATE_WAIT_MOUNTING);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_repeat_mounting(&resumed.procedure, 1));
    resumed.operator_is_away = false;
    run(&resumed);
    TEST_ASSERT_EQUAL_UINT32(POSITIONS, tumble_procedure_counters(&resumed.procedure)->positions);
}

/* Only the first confirmation keeps means; a later one of a mounting means that it was put on anew. */
static void test_only_the_first_confirmation_keeps(void)
{
    start_to_cut(&cut, 12, 3); /* mounting 1 whole, three of mounting 2 */
    is_kept[4] = false;        /* and one of mounting 1 was lost */
    bench_init(&resumed);
    restore_all(&resumed);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&resumed.procedure));
    run(&resumed);
    TEST_ASSERT_EQUAL_UINT32(1U + 9U, tumble_procedure_counters(&resumed.procedure)->positions);
}

static void test_start_forgets_what_was_put_back(void)
{
    start_to_cut(&cut, 12, 3);
    bench_init(&resumed);
    restore_all(&resumed);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&resumed.procedure));
    run(&resumed);
    TEST_ASSERT_EQUAL_UINT32(POSITIONS, tumble_procedure_counters(&resumed.procedure)->positions);
    TEST_ASSERT_EQUAL_UINT(2, resumed.confirmations);
}

static void test_states_and_arguments(void)
{
    start_to_cut(&cut, 3, 3);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_restore(&cut.procedure, 0, &kept[0]));
    bench_init(&resumed);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_resume(&resumed.procedure)); /* nothing was put back */
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_restore(&resumed.procedure, POSITIONS, &kept[0]));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_procedure_restore(&resumed.procedure, 0, NULL));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_resume(&resumed.procedure));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_restore(&resumed.procedure, 0, &kept[0]));
    TEST_ASSERT_TRUE(tumble_procedure_has_mean(&resumed.procedure, 0));
    TEST_ASSERT_FALSE(tumble_procedure_has_mean(&resumed.procedure, 1));
    TEST_ASSERT_FALSE(tumble_procedure_has_mean(&resumed.procedure, POSITIONS));
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&resumed.procedure));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_procedure_resume(&resumed.procedure));
}

static void refuse(uint8_t index, const tumble_average_t *average, tumble_status_t status)
{
    static const tumble_average_t empty;
    ASSERT_STATUS(status, tumble_procedure_restore(&resumed.procedure, index, average));
    TEST_ASSERT_EQUAL_MEMORY(&empty, &tumble_procedure_averages(&resumed.procedure)->averages[index], sizeof empty);
    TEST_ASSERT_FALSE(tumble_procedure_has_mean(&resumed.procedure, index));
}

static void test_a_mean_that_the_gates_would_not_have_kept_is_refused(void)
{
    start_to_cut(&cut, 3, 3);
    bench_init(&resumed);
    tumble_average_t bad = kept[0];
    bad.samples = resumed.averaging.min_samples - 1U;
    for (int i = 0; i < 3; i++) {
        bad.sum_counts[i] = 0;
    }
    refuse(0, &bad, TUMBLE_E_TOO_FEW);
    bad = kept[0];
    bad.scatter_counts[1] = 60.5F; /* above twice the declared 30 */
    refuse(0, &bad, TUMBLE_E_NOT_STILL);
    bad.scatter_counts[1] = -1.0F;
    refuse(0, &bad, TUMBLE_E_ARGUMENT);
    bad.scatter_counts[1] = NAN;
    refuse(0, &bad, TUMBLE_E_ARGUMENT);
    bad = kept[0];
    bad.sum_counts[2] = (INT64_C(7999999) * bad.samples) + 1;
    refuse(0, &bad, TUMBLE_E_ARGUMENT);
    bad.sum_counts[2] = (-INT64_C(7999999) * bad.samples) - 1;
    refuse(0, &bad, TUMBLE_E_ARGUMENT);
    bad = kept[0];
    bad.samples = (uint32_t)TUMBLE_MAX_SAMPLES + 1U;
    refuse(0, &bad, TUMBLE_E_ARGUMENT);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_restore(&resumed.procedure, 0, &kept[0]));
}

static void test_a_mean_of_another_direction_is_refused(void)
{
    start_to_cut(&cut, 12, 3);
    bench_init(&resumed);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_restore(&resumed.procedure, 0, &kept[0]));
    refuse(1, &kept[3], TUMBLE_E_ARGUMENT);
    refuse(9, &kept[4], TUMBLE_E_ARGUMENT); /* upside down for the first of its mounting */
    tumble_average_t turned = kept[1];
    turned.sum_counts[0] = -turned.sum_counts[0];
    refuse(1, &turned, TUMBLE_E_ARGUMENT);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_restore(&resumed.procedure, 1, &kept[1]));
}

/* U9 - U1 of 1e-3 g and no more, as when they were measured. */
static void test_a_closure_beyond_its_limit_is_refused(void)
{
    const double counts_per_g = 2.0 / V_PER_COUNT;
    start_to_cut(&cut, 9, 0);
    bench_init(&resumed);
    tumble_average_t off = kept[8];
    off.sum_counts[0] = kept[0].sum_counts[0] + (int64_t)(1.1e-3 * counts_per_g * off.samples);
    for (uint8_t p = 0; p < 8U; p++) {
        ASSERT_STATUS(TUMBLE_OK, tumble_procedure_restore(&resumed.procedure, p, &kept[p]));
    }
    refuse(8, &off, TUMBLE_E_ARGUMENT);
    off.sum_counts[0] = kept[0].sum_counts[0] + (int64_t)(0.9e-3 * counts_per_g * off.samples);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_restore(&resumed.procedure, 8, &off));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.9e-3, tumble_procedure_closure_g(&resumed.procedure, 0));
}

/* A mean that was put back is the reference of those measured after it. */
static void test_a_block_moved_meanwhile_is_noticed(void)
{
    start_to_cut(&cut, 5, 3);
    bench_init(&resumed);
    resumed.block.slip_deg = 30.0; /* somebody turned it on the table, and confirmed all the same */
    restore_all(&resumed);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&resumed.procedure));
    ASSERT_ENDS(&resumed, TUMBLE_STATE_FAULT, TUMBLE_REASON_SLIP);
    set_up();
    start_to_cut(&cut, 5, 3);
    bench_init(&resumed);
    resumed.block.slip_deg = 0.1; /* less than that the direction does not tell; the closure does */
    restore_all(&resumed);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_resume(&resumed.procedure));
    ASSERT_ENDS(&resumed, TUMBLE_STATE_FAULT, TUMBLE_REASON_SLIP);
}

static void test_giving_up_for_another_reason(void)
{
    start_to_cut(&cut, 2, 3);
    tumble_procedure_give_up(&cut.procedure, TUMBLE_REASON_INHIBITED);
    ASSERT_ENDED(&cut, TUMBLE_STATE_ABORT, TUMBLE_REASON_INHIBITED);
    TEST_ASSERT_EQUAL_UINT(1, cut.stand.stops);
    tumble_procedure_give_up(&cut.procedure, TUMBLE_REASON_COMMAND); /* there is no run any more */
    ASSERT_ENDED(&cut, TUMBLE_STATE_ABORT, TUMBLE_REASON_INHIBITED);
    TEST_ASSERT_EQUAL_UINT(1, cut.stand.stops);
    TEST_ASSERT_EQUAL_UINT32(0, tumble_procedure_counters(&cut.procedure)->commands_refused);
}
