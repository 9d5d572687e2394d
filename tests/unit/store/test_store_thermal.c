/* Sets over temperature: the record of version 2, and a store that reads both versions beside one that does not. Its bytes
 * are held against an independent encoder in tests/integration/test_store_golden.py. */
#include "core/bytes.h"
#include "core/coefficient.h"
#include "store_sets.h"
#include "support.h"

static tumble_set_t set;
static tumble_thermal_t thermal;
static uint8_t bytes[TUMBLE_SET_BYTES];
static tumble_store_t store;
static nv_memory_t memory;

/* Numbers that single precision holds. */
static void set_up(void)
{
    set = set_of(3);
    set.origin = TUMBLE_ORIGIN_FACTORY;
    thermal = (tumble_thermal_t){.reference_c = 21.3, .lowest_c = -20.0, .highest_c = 55.5};
    for (int m = 0; m < TUMBLE_THERMAL_POWERS; m++) {
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            for (int j = 0; j < TUMBLE_CHANNELS; j++) {
                thermal.power[m].k_v_per_g[i][j] = ((i == j) ? 1.25 : 0.0078125 * (i - j)) / (1 + (4095 * m));
                set.uncertainty.k_v_per_g[i][j] = (1 + i + j) / 65536.0;
            }
            thermal.power[m].u0_v[i] = (i - 1) / 1024.0 / (1 + (8191 * m));
            set.uncertainty.u0_v[i] = (1 + i) / 131072.0;
        }
    }
    nv_make(&memory, TUMBLE_REGION_COUNT, 8, 4096);
}

static bool boot(bool reads_both)
{
    const tumble_status_t status =
        reads_both ? tumble_store_init_thermal(&store, &memory.nv) : tumble_store_init(&store, &memory.nv);
    return (status == TUMBLE_OK) && store_settles(&store);
}

static void write(tumble_which_set_t which)
{
    assert_status(TUMBLE_OK, tumble_store_write_thermal(&store, which, &set, &thermal));
    TEST_ASSERT_TRUE(store_settles(&store));
    assert_status(TUMBLE_OK, tumble_store_outcome(&store));
}

static void assert_slopes(const tumble_thermal_t *found, const tumble_thermal_t *expected)
{
    TEST_ASSERT_TRUE(found->reference_c == expected->reference_c);
    TEST_ASSERT_TRUE((found->lowest_c == expected->lowest_c) && (found->highest_c == expected->highest_c));
    TEST_ASSERT_EQUAL_MEMORY(expected->power, found->power, sizeof found->power);
}

static void assert_reads(tumble_which_set_t which, uint8_t origin)
{
    tumble_set_t read;
    tumble_thermal_t found;
    assert_status(TUMBLE_OK, tumble_store_read_thermal(&store, which, &read, &found));
    assert_slopes(&found, &thermal);
    TEST_ASSERT_EQUAL_UINT8(origin, read.origin);
    TEST_ASSERT_EQUAL_MEMORY(&thermal.power[0], &read.coefficients, sizeof read.coefficients);
    TEST_ASSERT_EQUAL_MEMORY(&set.uncertainty, &read.uncertainty, sizeof read.uncertainty);
}

/* As single precision rounds it, and nothing else. */
static void round_all(void)
{
    for (int m = 0; m < TUMBLE_THERMAL_POWERS; m++) {
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            for (int j = 0; j < TUMBLE_CHANNELS; j++) {
                thermal.power[m].k_v_per_g[i][j] = (double)(float)thermal.power[m].k_v_per_g[i][j];
            }
            thermal.power[m].u0_v[i] = (double)(float)thermal.power[m].u0_v[i];
        }
    }
}

static void test_what_is_written_is_read_as_single_precision(void)
{
    tumble_set_t read;
    tumble_thermal_t found;
    assert_status(TUMBLE_OK, tumble_set_encode_thermal(&set, &thermal, bytes));
    assert_status(TUMBLE_OK, tumble_set_decode_thermal(bytes, &read, &found));
    round_all();
    assert_slopes(&found, &thermal);
    TEST_ASSERT_EQUAL_HEX16((TUMBLE_SET_FLAGS | TUMBLE_SET_HAS_SLOPES) & ~TUMBLE_SET_HAS_TEMPERATURE, read.flags);
    TEST_ASSERT_TRUE(read.temperature_c == 21.3);
    TEST_ASSERT_EQUAL_INT8(-40, read.temperature_min_half_c);
    TEST_ASSERT_EQUAL_INT8(111, read.temperature_max_half_c);
    TEST_ASSERT_EQUAL_MEMORY(&thermal.power[0], &read.coefficients, sizeof read.coefficients);
    TEST_ASSERT_EQUAL_MEMORY(&set.uncertainty, &read.uncertainty, sizeof read.uncertainty);
    TEST_ASSERT_EQUAL_MEMORY(set.block_serial, read.block_serial, sizeof set.block_serial);
    TEST_ASSERT_TRUE((read.max_abs_fit_g == set.max_abs_fit_g) && (read.closure_v == set.closure_v));
    TEST_ASSERT_EQUAL_UINT32(set.samples, read.samples);
    TEST_ASSERT_EQUAL_UINT32(set.reasons, read.reasons);
    TEST_ASSERT_EQUAL_HEX32(tumble_get_u32(&bytes[316]), read.record_crc);
}

static void test_version_1_has_no_slopes_and_all_temperatures(void)
{
    tumble_set_t read;
    tumble_thermal_t found;
    const tumble_set_t plain = set_of(3);
    set.origin = TUMBLE_ORIGIN_COMMITTED;
    set.flags = TUMBLE_SET_FLAGS;
    assert_status(TUMBLE_OK, tumble_set_encode(&set, bytes));
    assert_status(TUMBLE_OK, tumble_set_decode_thermal(bytes, &read, &found));
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_SET_FLAGS, read.flags);
    const tumble_thermal_t expected = {plain.temperature_c, -64.0, 63.5, {plain.coefficients}};
    assert_slopes(&found, &expected);
}

/* Whoever does not read version 2. */
static void test_a_reader_of_version_1_refuses_it(void)
{
    tumble_set_t read = set_of(9);
    const tumble_set_t before = read;
    assert_status(TUMBLE_OK, tumble_set_encode_thermal(&set, &thermal, bytes));
    assert_status(TUMBLE_E_FRAME, tumble_set_decode(bytes, &read));
    TEST_ASSERT_EQUAL_MEMORY(&before, &read, sizeof read);
    tumble_thermal_t found;
    assert_status(TUMBLE_OK, tumble_set_decode_thermal(bytes, &read, &found));
    assert_status(TUMBLE_E_ARGUMENT, tumble_set_encode(&read, bytes)); /* its slopes would be lost */
}

static void test_the_range_is_narrowed_to_what_a_sample_can_tell(void)
{
    static const struct {
        double lowest_c;
        double highest_c;
        double lowest_kept_c;
        double highest_kept_c;
        tumble_status_t status;
    } ranges[] = {
        {-20.4, 20.4, -20.0, 20.0, TUMBLE_OK},       {20.1, 20.9, 20.5, 20.5, TUMBLE_OK},
        {-64.0, 63.5, -64.0, 63.5, TUMBLE_OK},       {-70.0, 85.0, -64.0, 63.5, TUMBLE_OK},
        {-1e300, 1e300, -64.0, 63.5, TUMBLE_OK},     {20.1, 20.4, 0.0, 0.0, TUMBLE_E_ARGUMENT},
        {20.5, 20.0, 0.0, 0.0, TUMBLE_E_ARGUMENT},   {64.0, 70.0, 0.0, 0.0, TUMBLE_E_ARGUMENT},
        {-80.0, -64.1, 0.0, 0.0, TUMBLE_E_ARGUMENT}, {63.5, 63.5, 63.5, 63.5, TUMBLE_OK},
    };
    for (size_t r = 0; r < COUNT_OF(ranges); r++) {
        tumble_set_t read;
        tumble_thermal_t found;
        thermal.lowest_c = ranges[r].lowest_c;
        thermal.highest_c = ranges[r].highest_c;
        assert_status(ranges[r].status, tumble_set_encode_thermal(&set, &thermal, bytes));
        if (ranges[r].status == TUMBLE_OK) {
            assert_status(TUMBLE_OK, tumble_set_decode_thermal(bytes, &read, &found));
            TEST_ASSERT_TRUE(found.lowest_c == ranges[r].lowest_kept_c);
            TEST_ASSERT_TRUE(found.highest_c == ranges[r].highest_kept_c);
        }
    }
}

static void test_what_single_precision_cannot_hold_is_refused(void)
{
    double *const numbers[] = {&thermal.reference_c,
                               &thermal.lowest_c,
                               &thermal.highest_c,
                               &thermal.power[0].u0_v[0],
                               &thermal.power[2].u0_v[2],
                               &thermal.power[1].k_v_per_g[0][0],
                               &set.uncertainty.k_v_per_g[2][2]};
    for (size_t n = 0; n < COUNT_OF(numbers); n++) {
        const double held = *numbers[n];
        *numbers[n] = NOT_A_NUMBER;
        assert_status(TUMBLE_E_NOT_FINITE, tumble_set_encode_thermal(&set, &thermal, bytes));
        if (n > 2U) {
            *numbers[n] = 3.5e38;
            assert_status(TUMBLE_E_NOT_FINITE, tumble_set_encode_thermal(&set, &thermal, bytes));
        }
        *numbers[n] = held;
    }
    set.uncertainty.u0_v[1] = -1e-6;
    assert_status(TUMBLE_E_ARGUMENT, tumble_set_encode_thermal(&set, &thermal, bytes));
    set.flags &= (uint16_t)~TUMBLE_SET_HAS_UNCERTAINTY; /* then it is not looked at */
    assert_status(TUMBLE_OK, tumble_set_encode_thermal(&set, &thermal, bytes));
}

static void test_null_is_refused(void)
{
    tumble_set_t read;
    assert_status(TUMBLE_E_ARGUMENT, tumble_set_encode_thermal(NULL, &thermal, bytes));
    assert_status(TUMBLE_E_ARGUMENT, tumble_set_encode_thermal(&set, NULL, bytes));
    assert_status(TUMBLE_E_ARGUMENT, tumble_set_encode_thermal(&set, &thermal, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_set_decode_thermal(NULL, &set, &thermal));
    assert_status(TUMBLE_E_ARGUMENT, tumble_set_decode_thermal(bytes, NULL, &thermal));
    assert_status(TUMBLE_E_ARGUMENT, tumble_set_decode_thermal(bytes, &set, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_init_thermal(NULL, &memory.nv));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_init_thermal(&store, NULL));
    TEST_ASSERT_TRUE(boot(true));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_read_thermal(&store, TUMBLE_SET_ACTIVE, &read, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_write_thermal(&store, TUMBLE_SET_ACTIVE, NULL, &thermal));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_write_thermal(&store, TUMBLE_SET_ACTIVE, &set, NULL));
    assert_status(TUMBLE_E_ARGUMENT, tumble_store_write_thermal(&store, TUMBLE_SET_PREVIOUS, &set, &thermal));
    TEST_ASSERT_FALSE(tumble_store_busy(&store));
}

static void seal(void)
{
    tumble_record_seal(bytes, 316, 0);
}

/* Under a right CRC: what its writer must not have written. */
static void test_wrong_fields_under_a_right_crc_are_refused(void)
{
    static const struct {
        uint16_t at;
        uint8_t byte;
        tumble_status_t status;
    } changes[] = {
        {4, 3, TUMBLE_E_FRAME},        {15, 0x00, TUMBLE_E_ARGUMENT}, {15, 0x03, TUMBLE_E_ARGUMENT},
        {14, 0xFF, TUMBLE_E_ARGUMENT}, {14, 0x7E, TUMBLE_E_ARGUMENT}, {14, 0xFA, TUMBLE_E_FRAME},
        {12, 0, TUMBLE_E_ARGUMENT},    {294, 112, TUMBLE_E_ARGUMENT},
    };
    tumble_set_t read;
    tumble_thermal_t found;
    for (size_t c = 0; c < COUNT_OF(changes); c++) {
        assert_status(TUMBLE_OK, tumble_set_encode_thermal(&set, &thermal, bytes));
        bytes[changes[c].at] = changes[c].byte;
        seal();
        assert_status(changes[c].status, tumble_set_decode_thermal(bytes, &read, &found));
    }
    for (uint32_t at = 64; at < 256U; at += 4U) {
        assert_status(TUMBLE_OK, tumble_set_encode_thermal(&set, &thermal, bytes));
        tumble_put_u32(&bytes[at], 0x7F800000U); /* infinite */
        seal();
        assert_status(TUMBLE_E_NOT_FINITE, tumble_set_decode_thermal(bytes, &read, &found));
    }
}

static void test_every_altered_bit_is_noticed(void)
{
    tumble_set_t read;
    tumble_thermal_t found;
    assert_status(TUMBLE_OK, tumble_set_encode_thermal(&set, &thermal, bytes));
    for (uint32_t bit = 0; bit < (8U * TUMBLE_SET_BYTES); bit++) {
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        TEST_ASSERT_NOT_EQUAL_INT(TUMBLE_OK, tumble_set_decode_thermal(bytes, &read, &found));
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
}

static void test_the_store_keeps_them_wherever_a_set_may_be(void)
{
    round_all();
    TEST_ASSERT_TRUE(boot(true));
    write(TUMBLE_SET_FACTORY);
    assert_reads(TUMBLE_SET_ACTIVE, TUMBLE_ORIGIN_FACTORY);
    write(TUMBLE_SET_ACTIVE);
    assert_reads(TUMBLE_SET_ACTIVE, TUMBLE_ORIGIN_COMMITTED);
    write(TUMBLE_SET_PROPOSAL);
    assert_reads(TUMBLE_SET_PROPOSAL, TUMBLE_ORIGIN_HELD);
    assert_status(TUMBLE_OK, tumble_store_accept(&store, TUMBLE_SET_OTHER_RULES));
    TEST_ASSERT_TRUE(store_settles(&store));
    assert_reads(TUMBLE_SET_ACTIVE, TUMBLE_ORIGIN_ACCEPTED);
    assert_status(TUMBLE_OK, tumble_store_rollback(&store));
    TEST_ASSERT_TRUE(store_settles(&store));
    assert_reads(TUMBLE_SET_ACTIVE, TUMBLE_ORIGIN_ROLLED_BACK);
    TEST_ASSERT_TRUE(boot(true));
    assert_reads(TUMBLE_SET_ACTIVE, TUMBLE_ORIGIN_ROLLED_BACK);
    TEST_ASSERT_FALSE(tumble_store_has_newer(&store));
}

static void commit_plain(unsigned tag)
{
    const tumble_set_t plain = set_of(tag);
    assert_status(TUMBLE_OK, tumble_store_commit(&store, &plain));
    TEST_ASSERT_TRUE(store_settles(&store));
    assert_status(TUMBLE_OK, tumble_store_outcome(&store));
}

/* Back to a firmware that reads version 1 alone, and forth again: it goes by its own sets, says so, and touches nothing. */
static void test_a_store_of_version_1_takes_them_for_newer(void)
{
    tumble_set_t read;
    round_all();
    TEST_ASSERT_TRUE(boot(true));
    commit_plain(4);
    write(TUMBLE_SET_ACTIVE);
    static uint8_t image[NV_MAX_BYTES];
    memcpy(image, memory.bytes, memory.nv.size_bytes);
    TEST_ASSERT_TRUE(boot(false));
    TEST_ASSERT_TRUE(tumble_store_has_newer(&store));
    assert_status(TUMBLE_OK, tumble_store_read(&store, TUMBLE_SET_ACTIVE, &read));
    TEST_ASSERT_TRUE(set_is(&read, 4));
    TEST_ASSERT_EQUAL_UINT32(0, store.cells.torn);
    TEST_ASSERT_EQUAL_MEMORY(image, memory.bytes, memory.nv.size_bytes);
    TEST_ASSERT_TRUE(boot(true));
    TEST_ASSERT_FALSE(tumble_store_has_newer(&store));
    assert_reads(TUMBLE_SET_ACTIVE, TUMBLE_ORIGIN_COMMITTED);
}

static void test_a_store_of_both_reads_sets_of_version_1(void)
{
    tumble_set_t read;
    tumble_thermal_t found;
    TEST_ASSERT_TRUE(boot(false));
    commit_plain(4);
    TEST_ASSERT_TRUE(boot(true));
    assert_status(TUMBLE_OK, tumble_store_read_thermal(&store, TUMBLE_SET_ACTIVE, &read, &found));
    TEST_ASSERT_TRUE(set_is(&read, 4));
    const tumble_thermal_t expected = {read.temperature_c, -64.0, 63.5, {read.coefficients}};
    assert_slopes(&found, &expected);
}

static void test_a_refused_set_begins_no_job(void)
{
    TEST_ASSERT_TRUE(boot(true));
    thermal.power[1].u0_v[0] = 1e39;
    assert_status(TUMBLE_E_NOT_FINITE, tumble_store_write_thermal(&store, TUMBLE_SET_ACTIVE, &set, &thermal));
    TEST_ASSERT_FALSE(tumble_store_busy(&store));
    TEST_ASSERT_FALSE(tumble_store_has(&store, TUMBLE_SET_ACTIVE));
}
