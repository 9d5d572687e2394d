/* The commit rules: every rule, both sides of every limit. K is twice the identity and all other numbers are powers of two
 * or 3, 4, 5 times them, so that what is compared is exact and one unit in the last place decides. */
#include "support.h"
#include "tumble/sets.h"

#define TINY 0x1p-12 /* unit of uncertainties, V/g and V */

static tumble_set_t candidate;
static tumble_set_t active;
static tumble_commit_limits_t limits;

static double *value(tumble_set_t *set, int c)
{
    return (c < 9) ? &set->coefficients.k_v_per_g[c / 3][c % 3] : &set->coefficients.u0_v[c - 9];
}

static double *uncertainty(tumble_set_t *set, int c)
{
    return (c < 9) ? &set->uncertainty.k_v_per_g[c / 3][c % 3] : &set->uncertainty.u0_v[c - 9];
}

static tumble_set_t good_set(double u)
{
    tumble_set_t set = {.flags = TUMBLE_SET_HAS_UNCERTAINTY | TUMBLE_SET_HAS_CHECK | TUMBLE_SET_HAS_TEMPERATURE,
                        .block_serial = "TB-0001",
                        .date_utc_s = 1700000000,
                        .temperature_c = 25.0,
                        .max_abs_fit_g = 0x1p-13,
                        .max_abs_check_g = 0x1p-14,
                        .limit_g = 0x1p-12,
                        .fit_positions = 18};
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        *value(&set, c) = 0.0;
        *uncertainty(&set, c) = u;
    }
    for (int i = 0; i < 3; i++) {
        set.coefficients.k_v_per_g[i][i] = 2.0;
    }
    return set;
}

static void set_up(void)
{
    candidate = good_set(3.0 * TINY);
    active = good_set(4.0 * TINY);
    limits = (tumble_commit_limits_t){.coverage = 2.0F, .flags = TUMBLE_COMMIT_BY_ITSELF};
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        limits.uncertainty[c] = 0x1p-9F;
        limits.drift_per_month[c] = 0x1p-10F;
        limits.drift_per_kelvin[c] = 0.0F;
    }
}

static uint16_t judge(void)
{
    return tumble_commit_objections(&candidate, &active, &limits, false);
}

#define ASSERT_OBJECTION(objection) TEST_ASSERT_EQUAL_HEX16(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_##objection), judge())
#define ASSERT_NONE() TEST_ASSERT_EQUAL_HEX16(0, judge())

static void test_a_good_set_is_committed(void)
{
    ASSERT_NONE();
}

static void test_gravity_check(void)
{
    candidate.max_abs_fit_g = candidate.limit_g;
    candidate.max_abs_check_g = candidate.limit_g;
    ASSERT_NONE();
    candidate.max_abs_fit_g = one_ulp_beyond(candidate.limit_g);
    ASSERT_OBJECTION(GRAVITY_CHECK);
    candidate.max_abs_fit_g = 0.0;
    candidate.max_abs_check_g = one_ulp_beyond(candidate.limit_g);
    ASSERT_OBJECTION(GRAVITY_CHECK);
    candidate.max_abs_check_g = NOT_A_NUMBER;
    ASSERT_OBJECTION(GRAVITY_CHECK);
    candidate.max_abs_check_g = 0.0;
    candidate.fit_positions = 0;
    ASSERT_OBJECTION(GRAVITY_CHECK);
    candidate.check_positions = 1;
    ASSERT_NONE();
    candidate.limit_g = 0.0;
    ASSERT_OBJECTION(GRAVITY_CHECK);
    candidate.limit_g = 1.0;
    candidate.flags &= (uint16_t)~TUMBLE_SET_HAS_CHECK;
    ASSERT_OBJECTION(GRAVITY_CHECK);
}

static void test_not_finite(void)
{
    static const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        for (size_t b = 0; b < COUNT_OF(bad); b++) {
            set_up();
            *value(&candidate, c) = bad[b];
            ASSERT_OBJECTION(NOT_FINITE);
            set_up();
            *uncertainty(&candidate, c) = bad[b];
            ASSERT_OBJECTION(NOT_FINITE);
        }
        set_up();
        *uncertainty(&candidate, c) = -0x1p-1074;
        ASSERT_OBJECTION(NOT_FINITE);
    }
    set_up();
    candidate.coefficients.k_v_per_g[1][1] = 0.0; /* the whole row */
    ASSERT_OBJECTION(NOT_FINITE);
    candidate.coefficients.k_v_per_g[1][1] = 1e200; /* its length overflows */
    ASSERT_OBJECTION(NOT_FINITE);
}

static void test_uncertainty_unknown(void)
{
    candidate.flags &= (uint16_t)~TUMBLE_SET_HAS_UNCERTAINTY;
    ASSERT_OBJECTION(UNCERTAINTY_UNKNOWN);
}

static void test_uncertainty_of_every_coefficient(void)
{
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        set_up();
        *uncertainty(&candidate, c) = 0x1p-8; /* twice the limit of a row of length 2 */
        ASSERT_NONE();
        *uncertainty(&candidate, c) = one_ulp_beyond(0x1p-8);
        ASSERT_OBJECTION(UNCERTAIN);
        limits.uncertainty[c] = 0x1p-8F;
        ASSERT_NONE();
    }
}

/* allowed = coverage * 5 TINY + drift * months * 2, exactly. */
static void change_and_assert(int c, double allowed)
{
    const double start = *value(&active, c);
    for (int sign = -1; sign <= 1; sign += 2) {
        const double end = start + (sign * allowed);
        *value(&candidate, c) = end;
        /* The length of the row moves with its own scale factor: what is allowed then is not exact. */
        if ((c >= 9) || (c % 4 != 0)) {
            TEST_ASSERT_EQUAL_HEX16_MESSAGE(0, judge() & ~TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_UNCERTAIN), "at it");
        }
        *value(&candidate, c) = start + (sign * allowed * (1.0 - 1e-2));
        ASSERT_NONE();
        *value(&candidate, c) = start + (sign * allowed * (1.0 + 1e-2));
        ASSERT_OBJECTION(CHANGE);
        *value(&candidate, c) = start;
    }
}

static void test_change_of_every_coefficient(void)
{
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        set_up();
        change_and_assert(c, (10.0 * TINY) + 0x1p-9);
        limits.drift_per_month[c] = 0.0F;
        change_and_assert(c, 10.0 * TINY);
        limits.coverage = 1.0F;
        change_and_assert(c, 5.0 * TINY);
        active.flags &= (uint16_t)~TUMBLE_SET_HAS_UNCERTAINTY; /* what is not known excuses nothing */
        change_and_assert(c, 3.0 * TINY);
    }
}

/* Each coefficient is judged by its own uncertainties: by those of no other, however certain or uncertain that is. */
static void test_change_by_the_uncertainty_of_the_same_coefficient(void)
{
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        set_up();
        *uncertainty(&candidate, c) = 6.0 * TINY;
        *uncertainty(&active, c) = 8.0 * TINY;
        for (int other = 0; other < TUMBLE_COEFFICIENTS; other++) {
            change_and_assert(other, (((other == c) ? 20.0 : 10.0) * TINY) + 0x1p-9);
        }
        *uncertainty(&active, c) = 0.0;
        change_and_assert(c, (12.0 * TINY) + 0x1p-9);
        *uncertainty(&candidate, c) = 0.0;
        *uncertainty(&active, c) = 8.0 * TINY;
        change_and_assert(c, (16.0 * TINY) + 0x1p-9);
    }
}

/* A bias has no part in the length of a row: here one unit in the last place decides. */
static void test_change_to_the_last_bit(void)
{
    for (int c = 9; c < TUMBLE_COEFFICIENTS; c++) {
        set_up();
        const double allowed = (10.0 * TINY) + 0x1p-9;
        *value(&candidate, c) = allowed;
        ASSERT_NONE();
        *value(&candidate, c) = one_ulp_beyond(allowed);
        ASSERT_OBJECTION(CHANGE);
        *value(&candidate, c) = -allowed;
        ASSERT_NONE();
        *value(&candidate, c) = one_ulp_beyond(-allowed);
        ASSERT_OBJECTION(CHANGE);
    }
}

static void test_drift_grows_with_the_months(void)
{
    const uint64_t month_s = (uint64_t)TUMBLE_MONTH_S;
    limits.drift_per_month[10] = 0x1p-6F;
    const double excused = 10.0 * TINY;
    const double month = 0x1p-5;
    const struct {
        uint64_t later_s;
        double months;
    } cases[] = {{0, 1.0}, {month_s / 2U, 1.0}, {month_s, 1.0}, {2U * month_s, 2.0}, {8U * month_s, 8.0}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        candidate.date_utc_s = active.date_utc_s + cases[i].later_s;
        candidate.coefficients.u0_v[1] = excused + (cases[i].months * month);
        ASSERT_NONE();
        candidate.coefficients.u0_v[1] = one_ulp_beyond(candidate.coefficients.u0_v[1]);
        ASSERT_OBJECTION(CHANGE);
    }
    candidate.date_utc_s = 0; /* unknown counts as one month */
    ASSERT_OBJECTION(CHANGE);
    candidate.coefficients.u0_v[1] = excused + month;
    ASSERT_NONE();
    candidate.date_utc_s = 1700000000;
    active.date_utc_s = 0;
    ASSERT_NONE();
    candidate.coefficients.u0_v[1] = one_ulp_beyond(candidate.coefficients.u0_v[1]);
    ASSERT_OBJECTION(CHANGE);
}

/* A clock that is years ahead excuses no more than TUMBLE_COMMIT_MAX_MONTHS do. */
static void test_drift_is_allowed_for_so_many_months_at_most(void)
{
    const uint64_t month_s = (uint64_t)TUMBLE_MONTH_S;
    limits.drift_per_month[10] = 0x1p-6F;
    const double before = (10.0 * TINY) + (23.0 * 0x1p-5);
    const double most = (10.0 * TINY) + (24.0 * 0x1p-5);
    const struct {
        uint64_t later_s;
        double allowed;
    } cases[] = {{23U * month_s, before}, {24U * month_s, most},   {(24U * month_s) + 1U, most},
                 {25U * month_s, most},   {1200U * month_s, most}, {UINT64_MAX - 1700000000U, most}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        candidate.date_utc_s = active.date_utc_s + cases[i].later_s;
        candidate.coefficients.u0_v[1] = cases[i].allowed;
        ASSERT_NONE();
        candidate.coefficients.u0_v[1] = one_ulp_beyond(cases[i].allowed);
        ASSERT_OBJECTION(CHANGE);
    }
}

static void test_temperature_excuses_a_change(void)
{
    limits.drift_per_kelvin[9] = 0x1p-8F;
    for (int sign = -1; sign <= 1; sign += 2) {
        candidate.temperature_c = 25.0 + (sign * 4.0);
        candidate.coefficients.u0_v[0] = (10.0 * TINY) + 0x1p-9 + (4.0 * 0x1p-7);
        ASSERT_NONE();
        candidate.coefficients.u0_v[0] = one_ulp_beyond(candidate.coefficients.u0_v[0]);
        ASSERT_OBJECTION(CHANGE);
    }
    candidate.coefficients.u0_v[0] = (10.0 * TINY) + 0x1p-9;
    candidate.flags &= (uint16_t)~TUMBLE_SET_HAS_TEMPERATURE; /* unknown excuses nothing */
    ASSERT_NONE();
    candidate.coefficients.u0_v[0] = one_ulp_beyond(candidate.coefficients.u0_v[0]);
    ASSERT_OBJECTION(CHANGE);
    candidate.flags |= TUMBLE_SET_HAS_TEMPERATURE;
    active.flags &= (uint16_t)~TUMBLE_SET_HAS_TEMPERATURE;
    ASSERT_OBJECTION(CHANGE);
}

static void test_block_and_date(void)
{
    candidate.block_serial[6] = '2';
    ASSERT_OBJECTION(OTHER_BLOCK);
    set_up();
    candidate.block_serial[TUMBLE_SET_SERIAL_BYTES - 1U] = 'x';
    ASSERT_OBJECTION(OTHER_BLOCK);
    set_up();
    memset(active.block_serial, 0, sizeof active.block_serial);
    ASSERT_OBJECTION(OTHER_BLOCK);
    set_up();
    candidate.date_utc_s = active.date_utc_s - 1U;
    ASSERT_OBJECTION(OLDER);
    active.date_utc_s = 0;
    ASSERT_NONE();
    active.date_utc_s = candidate.date_utc_s;
    ASSERT_NONE();
}

static void test_first_replayed_and_by_hand(void)
{
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_FIRST),
                            tumble_commit_objections(&candidate, NULL, &limits, false));
    limits.flags |= TUMBLE_COMMIT_FIRST;
    TEST_ASSERT_EQUAL_HEX16(0, tumble_commit_objections(&candidate, NULL, &limits, false));
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_REPLAYED),
                            tumble_commit_objections(&candidate, &active, &limits, true));
    limits.flags = TUMBLE_COMMIT_FIRST;
    ASSERT_OBJECTION(BY_HAND);
    limits.flags = 0;
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_BY_HAND) |
                                TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_FIRST),
                            tumble_commit_objections(&candidate, NULL, &limits, false));
}

static void assert_limit(float *limit, float good, float bad)
{
    const float before = *limit;
    *limit = good;
    TEST_ASSERT_TRUE(tumble_commit_limits_valid(&limits));
    *limit = bad;
    TEST_ASSERT_FALSE(tumble_commit_limits_valid(&limits));
    ASSERT_OBJECTION(LIMITS);
    *limit = before;
}

static void test_limits_have_ranges(void)
{
    const float beyond_one = 0x1.000002p0F;
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        assert_limit(&limits.uncertainty[c], 1.0F, beyond_one);
        assert_limit(&limits.uncertainty[c], 0x1p-149F, 0.0F);
        assert_limit(&limits.uncertainty[c], 1.0F, NAN);
        assert_limit(&limits.drift_per_month[c], 0.0F, -0x1p-149F);
        assert_limit(&limits.drift_per_month[c], 1.0F, beyond_one);
        assert_limit(&limits.drift_per_kelvin[c], 0.0F, -0x1p-149F);
        assert_limit(&limits.drift_per_kelvin[c], 1.0F, INFINITY);
    }
    assert_limit(&limits.coverage, 1.0F, 0x1.fffffep-1F);
    assert_limit(&limits.coverage, 10.0F, 0x1.400002p3F);
    assert_limit(&limits.coverage, 10.0F, NAN);
    limits.flags = TUMBLE_COMMIT_BY_ITSELF | 4U;
    ASSERT_OBJECTION(LIMITS);
}

/* Several at a time are all told. */
static void test_objections_add_up(void)
{
    candidate.max_abs_fit_g = 1.0;
    candidate.block_serial[0] = 'X';
    *value(&candidate, 11) = 1.0;
    *uncertainty(&candidate, 2) = 1.0;
    candidate.date_utc_s = 1;
    limits.flags = 0;
    TEST_ASSERT_EQUAL_HEX16(
        TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_GRAVITY_CHECK) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_BLOCK) |
            TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_UNCERTAIN) |
            TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OLDER) | TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_REPLAYED) |
            TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_BY_HAND),
        tumble_commit_objections(&candidate, &active, &limits, true));
}

static void test_numbers_names_and_sentences(void)
{
    TEST_ASSERT_EQUAL_INT(0, TUMBLE_OBJECTION_GRAVITY_CHECK);
    TEST_ASSERT_EQUAL_INT(4, TUMBLE_OBJECTION_CHANGE);
    TEST_ASSERT_EQUAL_INT(8, TUMBLE_OBJECTION_REPLAYED);
    TEST_ASSERT_EQUAL_INT(10, TUMBLE_OBJECTION_BY_HAND);
    TEST_ASSERT_EQUAL_INT(11, TUMBLE_OBJECTION_OTHER_RULES);
    TEST_ASSERT_EQUAL_INT(12, TUMBLE_OBJECTION_DOES_NOT_FIT);
    TEST_ASSERT_EQUAL_INT(13, TUMBLE_OBJECTION_WHOLE_MODEL);
    TEST_ASSERT_EQUAL_INT(14, TUMBLE_OBJECTION_DISTURBED);
    TEST_ASSERT_EQUAL_INT(15, TUMBLE_OBJECTION_NEWER_SET);
    TEST_ASSERT_EQUAL_INT(16, TUMBLE_OBJECTION_NOT_SHOWN);
    TEST_ASSERT_EQUAL_INT(17, TUMBLE_OBJECTION_TEMPERATURE);
    TEST_ASSERT_EQUAL_INT(18, TUMBLE_OBJECTION_COUNT);
    for (int i = 0; i < TUMBLE_OBJECTION_COUNT; i++) {
        const char *const name = tumble_objection_name((tumble_objection_t)i);
        const char *const sentence = tumble_objection_sentence((tumble_objection_t)i);
        TEST_ASSERT_EQUAL_STRING_LEN("TUMBLE_OBJECTION_", name, 17);
        TEST_ASSERT_GREATER_THAN_size_t(10, strlen(sentence));
        TEST_ASSERT_NOT_EQUAL('.', sentence[strlen(sentence) - 1U]);
    }
    TEST_ASSERT_EQUAL_STRING("TUMBLE_OBJECTION_UNKNOWN", tumble_objection_name(TUMBLE_OBJECTION_COUNT));
    TEST_ASSERT_EQUAL_STRING("this objection is not in the list", tumble_objection_sentence((tumble_objection_t)99));
}
