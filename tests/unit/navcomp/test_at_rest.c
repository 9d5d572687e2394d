/* The measurement at rest: means to the last bit, the scatter against numbers of exact fractions, what is spoilt. */
#include "sample/at_rest.h"
#include "support.h"

#define FULL_SCALE 8388607
#define MOST 65535U
#define FAR ((int32_t)TUMBLE_MAX_DEVIATION_COUNTS)

static const tumble_averaging_config_t usual = {
    .saturation_counts = FULL_SCALE, .min_samples = 1, .stillness_ratio = 1.0F};
static tumble_averaging_config_t config;
static tumble_at_rest_t at_rest;
static uint16_t counter;

static void set_up(void)
{
    config = usual;
    counter = 65530; /* it wraps on the way */
    at_rest = (tumble_at_rest_t){0};
}

static void begin(uint16_t wanted)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_at_rest_begin(&at_rest, wanted));
}

static void take_with(int32_t x, int32_t y, int32_t z, uint8_t status, uint32_t dropped)
{
    const tumble_block_sample_t sample = {.raw = {.counts = {x, y, z}, .counter = counter, .status = status}};
    tumble_at_rest_take(&at_rest, &config, &sample, dropped);
    counter++;
}

static void take(int32_t x, int32_t y, int32_t z)
{
    take_with(x, y, z, 0, 0);
}

static void skip(int samples)
{
    counter = (uint16_t)(counter + samples);
}

static void assert_numbers(uint16_t wanted, uint16_t taken, uint16_t spoilt)
{
    tumble_at_rest_view_t view;
    (void)tumble_at_rest_view(&at_rest, 1.0, &view);
    TEST_ASSERT_EQUAL_UINT16(wanted, view.wanted);
    TEST_ASSERT_EQUAL_UINT16(taken, view.taken);
    TEST_ASSERT_EQUAL_UINT16(spoilt, view.spoilt);
}

static tumble_at_rest_view_t view_of(double v_per_count)
{
    tumble_at_rest_view_t view;
    ASSERT_STATUS(TUMBLE_OK, tumble_at_rest_view(&at_rest, v_per_count, &view));
    return view;
}

/* Within so few units of the last place that every rounding on the way counts. */
static void assert_near(double expected, double actual)
{
    const double ulp = one_ulp_beyond(expected) - expected;
    TEST_ASSERT_TRUE(magnitude(actual - expected) <= (3.0 * magnitude(ulp)));
}

/* Numbers. */

static void test_fractions_by_hand(void)
{
    begin(4);
    take(1, -7, 0);
    take(4, -7, 0);
    take(2, -7, 0);
    take(3, -7, 1);
    const tumble_at_rest_view_t view = view_of(1.0);
    ASSERT_SAME_DOUBLE(2.5, view.mean_v[0]);
    ASSERT_SAME_DOUBLE(-7.0, view.mean_v[1]);
    ASSERT_SAME_DOUBLE(0.25, view.mean_v[2]);
    assert_near(0x1.4a7e9cb8a3491p+0, view.deviation_v[0]); /* sqrt(5/3) */
    ASSERT_SAME_DOUBLE(0.0, view.deviation_v[1]);
    ASSERT_SAME_DOUBLE(0.5, view.deviation_v[2]);
}

static void test_volts_and_their_sign(void)
{
    begin(2);
    take(1, 3, -5);
    take(3, 3, -9);
    const tumble_at_rest_view_t view = view_of(-0.25);
    ASSERT_SAME_DOUBLE(-0.5, view.mean_v[0]);
    ASSERT_SAME_DOUBLE(-0.75, view.mean_v[1]);
    ASSERT_SAME_DOUBLE(1.75, view.mean_v[2]);
    assert_near(0x1.6a09e667f3bcdp-2, view.deviation_v[0]); /* sqrt(2) / 4 */
    ASSERT_SAME_DOUBLE(0.0, view.deviation_v[1]);
    assert_near(0x1.6a09e667f3bcdp-1, view.deviation_v[2]);
}

/* Near the end of the range with little noise, around 0, and scattered over a million counts: exact fractions, square
 * roots of 60 digits. */
static const int32_t thirteen[13][3] = {{-7999974, 1, 8245731},  {-8000005, 0, 7517158},  {-7999987, 1, 8181539},
                                        {-7999973, -1, 7960145}, {-7999964, -2, 8112615}, {-8000021, -1, 7935517},
                                        {-8000079, 3, 7948984},  {-7999982, 2, 8207237},  {-7999951, 2, 7620569},
                                        {-8000007, 3, 8377099},  {-8000029, -3, 8066201}, {-7999997, -2, 7619637},
                                        {-8000082, -2, 8106095}};
static const double thirteen_mean[3] = {-0x1.e8480fb13b13bp+22, 0x1.3b13b13b13b14p-4, 0x1.e7ce0989d89d9p+22};
static const double thirteen_deviation[3] = {0x1.445848e66a0afp+5, 0x1.07adff98e35aap+1, 0x1.01c7ff0d14164p+18};

static void test_thirteen_samples(void)
{
    begin(13);
    for (size_t k = 0; k < COUNT_OF(thirteen); k++) {
        take(thirteen[k][0], thirteen[k][1], thirteen[k][2]);
    }
    const tumble_at_rest_view_t view = view_of(1.0);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        ASSERT_SAME_DOUBLE(thirteen_mean[i], view.mean_v[i]);
        assert_near(thirteen_deviation[i], view.deviation_v[i]);
    }
}

static void test_the_order_does_not_matter(void)
{
    dice_t dice = {2152};
    uint8_t order[COUNT_OF(thirteen)];
    tumble_at_rest_view_t first = {0};
    for (uint8_t k = 0; k < COUNT_OF(order); k++) {
        order[k] = k;
    }
    for (int round = 0; round < 1000; round++) {
        begin(13);
        for (size_t k = 0; k < COUNT_OF(order); k++) {
            take(thirteen[order[k]][0], thirteen[order[k]][1], thirteen[order[k]][2]);
        }
        const tumble_at_rest_view_t view = view_of(-1e-6);
        first = (round == 0) ? view : first;
        TEST_ASSERT_EQUAL_MEMORY(&first, &view, sizeof view);
        for (uint32_t k = COUNT_OF(order) - 1U; k > 0U; k--) {
            const uint32_t other = dice_below(&dice, k + 1U);
            const uint8_t kept = order[k];
            order[k] = order[other];
            order[other] = kept;
        }
    }
}

/* So many of one count, all others as far away as they may be, and as many samples as there may be. */
static void take_most(uint32_t count, int32_t first, int32_t far)
{
    begin((uint16_t)MOST);
    for (uint32_t k = 0; k < MOST; k++) {
        const int32_t counts = (k < count) ? first : far;
        take(counts, -counts, counts);
    }
    assert_numbers((uint16_t)MOST, (uint16_t)MOST, 0);
}

static void test_the_sums_hold_the_most_samples(void)
{
    static const struct {
        uint32_t count;
        double mean;
        double deviation;
    } cases[] = {
        {1, 0x1.8000780080008p+22, 0x1.0000800060005p+13},
        {32767, 0x1.bfffb7ffbfffcp+22, 0x1.0000800060005p+20},
        {32768, 0x1.c000380040004p+22, 0x1.0000800060005p+20},
        {65534, 0x1.ffff77ff7fff8p+22, 0x1.0000800060005p+13},
    };
    for (size_t k = 0; k < COUNT_OF(cases); k++) {
        take_most(cases[k].count, FULL_SCALE - 1, FULL_SCALE - 1 - FAR);
        const tumble_at_rest_view_t view = view_of(1.0);
        ASSERT_SAME_DOUBLE(cases[k].mean, view.mean_v[0]);
        ASSERT_SAME_DOUBLE(-cases[k].mean, view.mean_v[1]);
        assert_near(cases[k].deviation, view.deviation_v[0]);
        assert_near(cases[k].deviation, view.deviation_v[1]);
    }
}

/* All but the first one count away from it. */
static void test_little_noise_among_the_most_samples(void)
{
    take_most(1, 0, 1);
    const tumble_at_rest_view_t view = view_of(1.0);
    ASSERT_SAME_DOUBLE(0x1.fffdfffdfffe0p-1, view.mean_v[0]);
    ASSERT_SAME_DOUBLE(-0x1.fffdfffdfffe0p-1, view.mean_v[1]);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        assert_near(0x1.0000800060005p-8, view.deviation_v[i]); /* 1 / sqrt(65535) */
    }
}

/* A converter of 32 bits. */
static void test_the_sums_hold_the_largest_counts(void)
{
    config.saturation_counts = INT32_MAX;
    take_most(32767, INT32_MAX - 1, INT32_MAX - 1 - FAR);
    const tumble_at_rest_view_t view = view_of(1.0);
    ASSERT_SAME_DOUBLE(0x1.ffbfffb7ffc00p+30, view.mean_v[0]);
    ASSERT_SAME_DOUBLE(-0x1.ffbfffb7ffc00p+30, view.mean_v[1]);
    assert_near(0x1.0000800060005p+20, view.deviation_v[2]);
}

/* Begin and end. */

static void test_one_sample_is_none(void)
{
    begin(5);
    take(1, 2, 3);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_at_rest_begin(&at_rest, 1));
    assert_numbers(5, 1, 0);
    begin(0);
    assert_numbers(0, 0, 0);
}

static void test_nothing_is_told_before_all_are_there(void)
{
    tumble_at_rest_view_t view;
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_at_rest_view(&at_rest, 1.0, &view));
    take(1, 2, 3);
    assert_numbers(0, 0, 0);
    begin(3);
    for (uint16_t k = 0; k < 3U; k++) {
        ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_at_rest_view(&at_rest, 1.0, &view));
        assert_numbers(3, k, 0);
        ASSERT_SAME_DOUBLE(0.0, view.mean_v[0]);
        take(7, 8, 9);
    }
    ASSERT_SAME_DOUBLE(7.0, view_of(1.0).mean_v[0]);
    skip(100);
    take(100, 100, 100); /* it stays what it is */
    assert_numbers(3, 3, 0);
    ASSERT_SAME_DOUBLE(7.0, view_of(1.0).mean_v[0]);
    begin(2);
    assert_numbers(2, 0, 0);
    ASSERT_STATUS(TUMBLE_E_TOO_FEW, tumble_at_rest_view(&at_rest, 1.0, &view));
}

/* What is spoilt. */

static void test_what_is_missing_is_spoilt(void)
{
    begin(100);
    take(1, 1, 1);
    skip(3);
    take(1, 1, 1);
    assert_numbers(100, 2, 3);
    skip(32766); /* the longest gap that is none backwards */
    take(1, 1, 1);
    assert_numbers(100, 3, 32769);
}

static void test_what_comes_again_or_too_late_is_spoilt(void)
{
    begin(100);
    take(1, 1, 1);
    counter--;
    take(1, 1, 1); /* the same counter again */
    assert_numbers(100, 1, 1);
    skip(-5); /* a block that restarts its count: only this one is lost */
    take(1, 1, 1);
    assert_numbers(100, 1, 2);
    take(1, 1, 1);
    assert_numbers(100, 2, 2);
    skip(32767); /* the shortest gap that reads as one backwards */
    take(1, 1, 1);
    assert_numbers(100, 2, 3);
}

/* Those that did not get here; what was dropped before it began does not count. */
static void test_what_was_dropped_is_spoilt(void)
{
    begin(100);
    take_with(1, 1, 1, 0, UINT32_MAX);
    assert_numbers(100, 1, 0);
    take_with(1, 1, 1, 0, UINT32_MAX);
    assert_numbers(100, 2, 0);
    take_with(1, 1, 1, 0, 1);
    assert_numbers(100, 3, 2);
}

static void test_saturated_samples_are_spoilt(void)
{
    begin(100);
    take(FULL_SCALE - 1, 1 - FULL_SCALE, 0);
    assert_numbers(100, 1, 0);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            int32_t counts[3] = {FULL_SCALE - 1, 1 - FULL_SCALE, 0};
            counts[i] = sign * FULL_SCALE;
            take(counts[0], counts[1], counts[2]);
        }
    }
    assert_numbers(100, 1, 6);
    config.saturation_counts = INT32_MAX;
    take(FULL_SCALE, 1 - FULL_SCALE, INT32_MIN);
    assert_numbers(100, 1, 7);
}

static void test_whatever_the_block_reports_is_spoilt(void)
{
    begin(100);
    for (uint8_t status = 1; status < 16U; status++) {
        take_with(1, 1, 1, status, 0);
        assert_numbers(100, 0, status);
    }
    take(5, 5, 5); /* none of those was the first */
    take(5, 5, 5);
    assert_numbers(100, 2, 15);
}

static void test_what_lies_too_far_from_the_first_is_spoilt(void)
{
    begin(100);
    take(10, 20, 30);
    take(10 + FAR, 20 - FAR, 30);
    assert_numbers(100, 2, 0);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            int32_t counts[3] = {10, 20, 30};
            counts[i] += sign * (FAR + 1);
            take(counts[0], counts[1], counts[2]);
        }
    }
    assert_numbers(100, 2, 6);
}

/* A refused sample leaves the numbers as they would be without it, and its place in the counter is not missed. */
static void test_spoilt_samples_are_not_averaged(void)
{
    begin(13);
    for (size_t k = 0; k < COUNT_OF(thirteen); k++) {
        take(thirteen[k][0], thirteen[k][1], thirteen[k][2]);
        take_with(0, 0, 0, TUMBLE_SAMPLE_CONVERTER, 0);
    }
    assert_numbers(13, 13, 12); /* the last one came when all were there */
    ASSERT_SAME_DOUBLE(thirteen_mean[0], view_of(1.0).mean_v[0]);
    assert_near(thirteen_deviation[0], view_of(1.0).deviation_v[0]);
}

static void test_the_count_of_spoilt_samples_stops_at_its_end(void)
{
    begin(100);
    take(1, 1, 1);
    for (int gap = 0; gap < 3; gap++) {
        skip(30000);
        take(1, 1, 1);
    }
    assert_numbers(100, 4, UINT16_MAX);
    take_with(1, 1, 1, 1, 0);
    assert_numbers(100, 4, UINT16_MAX);
}
