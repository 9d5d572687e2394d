/* The random streams: published vectors, independence of streams, the law of the deviates. */
#include "simulation/random.h"
#include "support.h"

#include <math.h>

/* First outputs for seed 1234567, as published with the reference implementation. */
static void test_splitmix64_gives_the_published_numbers(void)
{
    static const uint64_t EXPECTED[] = {UINT64_C(6457827717110365317), UINT64_C(3203168211198807973),
                                        UINT64_C(9817491932198370423), UINT64_C(4593380528125082431),
                                        UINT64_C(16408922859458223821)};
    uint64_t state = 1234567;
    for (size_t i = 0; i < COUNT_OF(EXPECTED); i++) {
        TEST_ASSERT_EQUAL_HEX64(EXPECTED[i], sim_splitmix64(&state));
    }
}

/* Reference outputs of xoshiro256** from state {1, 2, 3, 4}. */
static void test_xoshiro256ss_gives_the_published_numbers(void)
{
    static const uint64_t EXPECTED[] = {UINT64_C(11520),
                                        UINT64_C(0),
                                        UINT64_C(1509978240),
                                        UINT64_C(1215971899390074240),
                                        UINT64_C(1216172134540287360),
                                        UINT64_C(607988272756665600),
                                        UINT64_C(16172922978634559625),
                                        UINT64_C(8476171486693032832),
                                        UINT64_C(10595114339597558777),
                                        UINT64_C(2904607092377533576)};
    sim_random_t stream = {{1, 2, 3, 4}};
    for (size_t i = 0; i < COUNT_OF(EXPECTED); i++) {
        TEST_ASSERT_EQUAL_HEX64(EXPECTED[i], sim_random_u64(&stream));
    }
}

/* Our own numbers, pinned: a change would give every seed another meaning. */
static void test_a_seed_keeps_its_meaning(void)
{
    sim_random_t stream;
    sim_random_open(&stream, 1, SIM_CAUSE_NOISE, 2);
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0xBDF21A165D0EFC5C), sim_random_u64(&stream));
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0x7211A4261A021858), sim_random_u64(&stream));
    sim_random_open(&stream, 1, SIM_CAUSE_NOISE, 2);
    ASSERT_SAME_DOUBLE(0x1.4C8463BCA194Ep-1, sim_random_normal(&stream));
}

static void test_streams_differ_by_seed_cause_and_index(void)
{
    uint64_t first[3 * 4 * 5];
    size_t count = 0;
    for (uint64_t seed = 0; seed < 3; seed++) {
        for (int cause = 1; cause <= 4; cause++) {
            for (uint32_t index = 0; index < 5; index++) {
                sim_random_t stream;
                sim_random_open(&stream, seed, (sim_cause_t)cause, index);
                first[count++] = sim_random_u64(&stream);
            }
        }
    }
    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j < i; j++) {
            TEST_ASSERT_TRUE(first[i] != first[j]);
        }
    }
}

/* Quantiles to 17 digits, worked out with 50 digits of precision elsewhere. */
static void test_quantile_against_many_digits(void)
{
    static const double CASES[][2] = {
        {0x1.0000000800000p-1, 2.3344794983332981399e-9}, {0x1.051eb851eb852p-1, 0.025068908258711058033},
        {0x1.3333333333333p-1, 0.25334710313579974132},   {0x1.8000000000000p-1, 0.6744897501960817432},
        {0x1.ccccccccccccdp-1, 1.2815515655446005935},    {0x1.d99999999999ap-1, 1.4395314709384562291},
        {0x1.d999999a7580ap-1, 1.4395314716448933733},    {0x1.e666666666666p-1, 1.6448536269514722843},
        {0x1.fae147ae147aep-1, 2.3263478740408407676},    {0x1.ff7ced916872bp-1, 3.0902323061678132778},
        {0x1.ffffde7210be9p-1, 4.7534243088170877657},    {0x1.fffffff768fa1p-1, 5.9978070196016374264},
        {0x1.fffffffffe000p-1, 7.0477002566644087254},    {0x1.3333333333333p-4, -1.4395314709384559349},
        {0x1.3333185b40987p-4, -1.4395321773759005864},   {0x1.47ae147ae147bp-7, -2.3263478740408410931},
        {0x1.0624dd2f1a9fcp-10, -3.0902323061678135354},  {0x1.4f8b588e368f1p-17, -4.2648907939228246102},
        {0x1.5798ee2308c3ap-27, -5.6120012441747887279},  {0x1.b7cdfd9d7bdbbp-34, -6.3613409024040561991},
        {0x1.5fd7fe1796495p-37, -6.7060231554951362961},  {0x1.19799812dea11p-39, -6.9371814280356805277},
        {0x1.19799812dea11p-40, -7.0344838253011319326},  {0x1.c25c268497682p-44, -7.3487961028006775135},
        {0x1.6849b86a12b9bp-47, -7.6506280929352688166},  {0x1.0000000000000p-53, -8.2095361516013868556},
        {0x1.4484bfeebc2a0p-100, -11.46402468844361572},  {0x1.bff2ee48e0530p-333, -21.273453560965324294},
    };
    for (size_t i = 0; i < COUNT_OF(CASES); i++) {
        const double z = CASES[i][1];
        TEST_ASSERT_DOUBLE_WITHIN(2e-15 * (1.0 + fabs(z)), z, sim_normal_quantile(CASES[i][0]));
        TEST_ASSERT_DOUBLE_WITHIN(1e-300, 0.0, sim_normal_quantile(0.5));
    }
}

static void test_batch_and_single_draws_agree(void)
{
    sim_random_t one;
    sim_random_t many;
    double batch[100];
    sim_random_open(&one, 99, SIM_CAUSE_NOISE, 0);
    sim_random_open(&many, 99, SIM_CAUSE_NOISE, 0);
    sim_random_normals(&many, batch, 60);
    sim_random_normals(&many, batch + 60, 40);
    for (size_t i = 0; i < 100; i++) {
        ASSERT_SAME_DOUBLE(batch[i], sim_random_normal(&one));
    }
}

/* Kolmogorov-Smirnov against the normal law over 64 equally likely cells, and the first four moments. */
static void test_normal_deviates_are_normal(void)
{
    enum { DRAWS = 1000000, CELLS = 64 };
    static uint32_t cells[CELLS];
    double edges[CELLS];
    double sums[4] = {0};
    sim_random_t stream;
    sim_random_open(&stream, 12345, SIM_CAUSE_NOISE, 1);
    for (int c = 1; c < CELLS; c++) {
        edges[c] = sim_normal_quantile((double)c / (double)CELLS);
    }
    for (int n = 0; n < DRAWS; n++) {
        const double z = sim_random_normal(&stream);
        int c = 0;
        while (c < CELLS - 1 && z >= edges[c + 1]) {
            c++;
        }
        cells[c]++;
        sums[0] += z;
        sums[1] += z * z;
        sums[2] += z * z * z;
        sums[3] += z * z * z * z;
    }
    double chi2 = 0.0;
    for (int c = 0; c < CELLS; c++) {
        const double expected = (double)DRAWS / (double)CELLS;
        chi2 += ((double)cells[c] - expected) * ((double)cells[c] - expected) / expected;
    }
    TEST_ASSERT_TRUE(chi2 > 29.0 && chi2 < 118.0); /* 63 degrees of freedom: 1 in 10^5 on either side */
    TEST_ASSERT_DOUBLE_WITHIN(4.5e-3, 0.0, sums[0] / (double)DRAWS);
    TEST_ASSERT_DOUBLE_WITHIN(6.4e-3, 1.0, sums[1] / (double)DRAWS);
    TEST_ASSERT_DOUBLE_WITHIN(1.8e-2, 0.0, sums[2] / (double)DRAWS);
    TEST_ASSERT_DOUBLE_WITHIN(4.5e-2, 3.0, sums[3] / (double)DRAWS);
}

/* Moments of the three laws for a limit of 0.3, and a draw is used up even when the limit is 0. */
static void test_laws_read_their_limit(void)
{
    static const double VARIANCE[] = {0.09, 0.01, 0.03};
    for (int law = SIM_LAW_SIGMA1; law <= SIM_LAW_UNIFORM; law++) {
        sim_random_t stream;
        double square = 0.0;
        double largest = 0.0;
        sim_random_open(&stream, 7, SIM_CAUSE_LEVEL, (uint32_t)law);
        for (int n = 0; n < 200000; n++) {
            const double x = sim_law_draw((sim_law_t)law, 0.3, &stream);
            square += x * x;
            largest = (fabs(x) > largest) ? fabs(x) : largest;
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.015 * VARIANCE[law], VARIANCE[law], square / 200000);
        TEST_ASSERT_TRUE((largest < 0.3) == (law == SIM_LAW_UNIFORM) || law == SIM_LAW_SIGMA3);
    }
    sim_random_t silent;
    sim_random_t plain;
    sim_random_open(&silent, 7, SIM_CAUSE_LEVEL, 0);
    sim_random_open(&plain, 7, SIM_CAUSE_LEVEL, 0);
    ASSERT_SAME_DOUBLE(0.0, sim_law_draw(SIM_LAW_SIGMA1, 0.0, &silent));
    (void)sim_random_u64(&plain);
    TEST_ASSERT_EQUAL_HEX64(sim_random_u64(&plain), sim_random_u64(&silent));
}
