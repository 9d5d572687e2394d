/* The range of a run's temperatures in its set: of all samples that went into its means, and of no others; also where power
 * was lost on the way. */
#include "keeper_bench.h"

#include "core/bytes.h"
#include "core/crc32.h"
#include "sets/record.h"

#define CHECKPOINT_AT (MEMORY_SECTOR * TUMBLE_REGION_CHECKPOINT)
#define LARGEST 100 /* drawn for samples that are averaged */
#define BETWEEN 110 /* of a sample between two positions, in magnitude */

typedef struct {
    int low;
    int high;
} span_t;

static const span_t nothing = {INT8_MAX, INT8_MIN};
static span_t seen[POSITIONS]; /* of the samples in each mean, as they are told to the board */
static span_t ever;            /* and of all that were in one */
static dice_t dice;

static void widen(span_t *span, int half_c)
{
    span->low = (half_c < span->low) ? half_c : span->low;
    span->high = (half_c > span->high) ? half_c : span->high;
}

static int8_t draw(void)
{
    return (int8_t)dice_between(&dice, -LARGEST, LARGEST);
}

/* The next sample has another temperature; that behind a position's last one is beyond all others. */
static void take(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    (void)context;
    if (taken.ordinal == 1U) {
        seen[taken.index] = nothing;
    }
    widen(&seen[taken.index], sample->temperature_half_c);
    widen(&ever, sample->temperature_half_c);
    const bool last = (taken.ordinal == BENCH_SAMPLES);
    const int8_t beyond = ((taken.index % 2U) == 0U) ? BETWEEN : -BETWEEN;
    bench.block.temperature_half_c = last ? beyond : draw();
}

static void set_up(void)
{
    keeper_power_on();
    bench.hooks.on_sample_averaged = take;
    dice = (dice_t){11};
    ever = nothing;
    bench.block.temperature_half_c = draw();
}

/* Until the position averages, or all is done. */
static void go_on_to(uint8_t index)
{
    for (int i = 0; i < 2000000; i++) {
        const tumble_navcomp_progress_t now = bench_progress(&bench);
        const bool averages = (now.run.state == TUMBLE_STATE_AVERAGE);
        if ((now.run.state == TUMBLE_STATE_DONE) || (averages && (now.run.index == index) && (now.run.samples > 3U))) {
            return;
        }
        TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_FAULT, now.run.state);
        if (!averages && (now.temperature_half_c == bench.block.temperature_half_c)) {
            bench.block.temperature_half_c = draw(); /* that one has been seen */
        }
        bench_event(&bench);
    }
    TEST_FAIL_MESSAGE("the run does not go on");
}

static void start_to(uint8_t index)
{
    bench.logged = 0;
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    go_on_to(index);
}

static void cut_and_resume(void)
{
    settle_and_power_cycle();
    bench.block.temperature_half_c = draw();
    obey_for(0.1, TUMBLE_COMMAND_RESUME);
}

/* The active set: how the run ended. */
static tumble_set_t end(void)
{
    go_on_to(POSITIONS);
    settle_to(TUMBLE_VERDICT_COMMITTED);
    return set_of(TUMBLE_SET_ACTIVE);
}

static void assert_range(span_t expected, const tumble_set_t *set)
{
    TEST_ASSERT_BITS_HIGH(TUMBLE_SET_HAS_TEMPERATURE_RANGE, set->flags);
    TEST_ASSERT_EQUAL_INT8(expected.low, set->temperature_min_half_c);
    TEST_ASSERT_EQUAL_INT8(expected.high, set->temperature_max_half_c);
}

static void assert_unknown(const tumble_set_t *set)
{
    TEST_ASSERT_BITS_LOW(TUMBLE_SET_HAS_TEMPERATURE_RANGE, set->flags);
    TEST_ASSERT_EQUAL_INT8(0, set->temperature_min_half_c);
    TEST_ASSERT_EQUAL_INT8(0, set->temperature_max_half_c);
}

static span_t in_the_means(void)
{
    span_t span = nothing;
    for (size_t p = 0; p < POSITIONS; p++) {
        widen(&span, seen[p].low);
        widen(&span, seen[p].high);
    }
    return span;
}

static void test_it_is_of_the_samples_in_the_means_alone(void)
{
    for (int run = 0; run < 10; run++) {
        ever = nothing;
        drift(1e-6);
        start_to(0);
        const tumble_set_t set = end();
        assert_range(in_the_means(), &set);
        TEST_ASSERT_EQUAL_INT(in_the_means().low, ever.low);
        TEST_ASSERT_TRUE((ever.low >= -LARGEST) && (ever.high <= LARGEST) && (ever.low < ever.high));
        TEST_ASSERT_BITS_HIGH(TUMBLE_SET_HAS_TEMPERATURE, set.flags);
        TEST_ASSERT_TRUE((2.0 * set.temperature_c > ever.low) && (2.0 * set.temperature_c < ever.high));
    }
}

/* The samples of the position that was cut off are measured again: they are in no mean. */
static void test_it_outlives_power_cut_at_every_position(void)
{
    for (uint8_t index = 1; index < POSITIONS; index++) {
        set_up();
        dice = (dice_t){100U + index};
        start_to(index);
        cut_and_resume();
        TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.resumed);
        const tumble_set_t set = end();
        TEST_ASSERT_BITS_HIGH(TUMBLE_SET_RESUMED, set.flags);
        assert_range(in_the_means(), &set);
    }
}

/* The first position is colder than all that comes behind two losses of power. */
static void test_it_outlives_two_cuts(void)
{
    start_to(4);
    cut_and_resume();
    go_on_to(13);
    cut_and_resume();
    const tumble_set_t set = end();
    assert_range(in_the_means(), &set);
}

static void test_after_an_nmt_reset(void)
{
    start_to(6);
    settle_memory();
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 0.5);
    obey_for(0.1, TUMBLE_COMMAND_RESUME);
    const tumble_set_t set = end();
    assert_range(in_the_means(), &set);
}

/* What was measured and dropped may count: the range holds all samples that are in the means, and none that never was. */
static void test_a_position_that_is_repeated(void)
{
    start_to(0);
    (void)end();
    drift(1e-6);
    ASSERT_STATUS(TUMBLE_OK, bench_command(&bench, TUMBLE_COMMAND_REPEAT_POSITION, POSITIONS - 1U));
    const tumble_set_t set = end();
    TEST_ASSERT_EQUAL_UINT32(2, set.sequence);
    assert_range(ever, &set);
}

static void test_the_next_run_begins_anew(void)
{
    start_to(5);
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_ABORT));
    ever = nothing;
    start_to(7);
    settle_and_power_cycle();
    ever = nothing; /* a run that is begun anew knows nothing of the one that could have been resumed */
    start_to(0);
    const tumble_set_t set = end();
    assert_range(ever, &set);
}

/* An entry of an earlier version has zeros there. */
static void test_one_entry_that_does_not_know_it_is_enough(void)
{
    start_to(6);
    settle_memory();
    uint8_t fingerprint[4];
    uint8_t *const entry = &memory.bytes[CHECKPOINT_AT + (3U * TUMBLE_CHECKPOINT_BYTES)];
    tumble_put_u32(fingerprint, keeper.checkpoint.fingerprint);
    TEST_ASSERT_NOT_EQUAL(0, entry[44]);
    memset(&entry[44], 0, 2);
    tumble_record_seal(entry, 60, tumble_crc32(0, fingerprint, sizeof fingerprint));
    cut_and_resume();
    go_on_to(9);
    cut_and_resume(); /* the entries behind do not know it either */
    const tumble_set_t set = end();
    TEST_ASSERT_BITS_HIGH(TUMBLE_SET_RESUMED | TUMBLE_SET_HAS_TEMPERATURE, set.flags);
    assert_unknown(&set);
}

/* A frame tells -64 to 63.5 degrees C, and there are blocks that tell no less than -63.5: at an end it may be any more. */
static void test_at_an_end_of_what_can_be_told_it_is_not_known(void)
{
    static const struct {
        int8_t half_c;
        bool known;
    } ends[] = {{-128, false}, {-127, false}, {-126, true}, {126, true}, {127, false}};
    for (size_t i = 0; i < COUNT_OF(ends); i++) {
        keeper_power_on();
        bench.block.temperature_half_c = ends[i].half_c;
        TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
        const tumble_set_t set = set_of(TUMBLE_SET_ACTIVE);
        TEST_ASSERT_BITS_HIGH(TUMBLE_SET_HAS_TEMPERATURE, set.flags);
        if (ends[i].known) {
            assert_range((span_t){ends[i].half_c, ends[i].half_c}, &set);
        } else {
            assert_unknown(&set);
        }
    }
}

/* One sample at an end is enough. */
static void test_one_sample_at_an_end(void)
{
    for (int i = 0; i < 2; i++) {
        set_up();
        start_to(9);
        const uint32_t sent = bench.block.sent;
        bench.hooks.on_sample_averaged = NULL;
        bench.block.temperature_half_c = (i == 0) ? INT8_MIN : INT8_MAX;
        while (bench.block.sent == sent) {
            bench_event(&bench);
        }
        bench.block.temperature_half_c = 0;
        TEST_ASSERT_EQUAL(TUMBLE_STATE_AVERAGE, run_state());
        go_on_to(POSITIONS);
        settle_memory();
        const tumble_set_t set = set_of(TUMBLE_SET_ACTIVE);
        assert_unknown(&set);
    }
}
