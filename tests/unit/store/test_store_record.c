/* The record of a set: what is refused, and that every altered bit is noticed. Its bytes are held against an independent
 * encoder in tests/integration/test_store_golden.py. */
#include "core/bytes.h"
#include "sets/record.h"
#include "store_sets.h"
#include "support.h"

static tumble_set_t set;
static uint8_t bytes[TUMBLE_SET_BYTES];

static void set_up(void)
{
    set = set_of(3);
    set.origin = TUMBLE_ORIGIN_COMMITTED;
}

static void assert_encodes(tumble_status_t expected)
{
    assert_status(expected, tumble_set_encode(&set, bytes));
}

static void assert_decodes(tumble_status_t expected)
{
    tumble_set_t read = set_of(9);
    const tumble_set_t before = read;
    assert_status(expected, tumble_set_decode(bytes, &read));
    if (expected != TUMBLE_OK) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &read, sizeof read);
    }
}

static void test_what_is_written_is_read(void)
{
    tumble_set_t read;
    assert_encodes(TUMBLE_OK);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_set_decode(bytes, &read));
    TEST_ASSERT_TRUE(set_is(&read, 3));
    TEST_ASSERT_EQUAL_UINT32(77, read.sequence);
    TEST_ASSERT_EQUAL_UINT32(78, read.restores);
    TEST_ASSERT_EQUAL_UINT32(79, read.from_crc);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_ORIGIN_COMMITTED, read.origin);
    TEST_ASSERT_EQUAL_HEX32(tumble_set_crc(bytes), tumble_get_u32(&bytes[316]));
    TEST_ASSERT_EQUAL_HEX32(tumble_set_crc(bytes), read.record_crc);
}

static void test_what_is_unknown_is_zero(void)
{
    tumble_set_t read;
    set.flags = 0;
    set.temperature_c = NOT_A_NUMBER;
    set.gravity_m_s2 = -1.0;
    set.uncertainty.u0_v[2] = -INFINITE;
    set.max_abs_check_g = NOT_A_NUMBER;
    set.closure_v = NOT_A_NUMBER;
    set.temperature_min_half_c = 5;
    set.temperature_max_half_c = -5;
    assert_encodes(TUMBLE_OK);
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, tumble_set_decode(bytes, &read));
    TEST_ASSERT_EQUAL_INT8(0, read.temperature_min_half_c);
    TEST_ASSERT_EQUAL_INT8(0, read.temperature_max_half_c);
    TEST_ASSERT_TRUE(read.temperature_c == 0.0 && read.gravity_m_s2 == 0.0 && read.uncertainty.u0_v[2] == 0.0);
    TEST_ASSERT_TRUE(read.max_abs_check_g == 0.0 && read.closure_v == 0.0);
}

static void test_null_is_refused(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_set_encode(NULL, bytes));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_set_encode(&set, NULL));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_set_decode(NULL, &set));
    TEST_ASSERT_EQUAL_INT(TUMBLE_E_ARGUMENT, tumble_set_decode(bytes, NULL));
}

static void test_every_number_must_be_one_and_in_its_range(void)
{
    double *const any[] = {&set.coefficients.k_v_per_g[0][0], &set.coefficients.k_v_per_g[2][2],
                           &set.coefficients.u0_v[2], &set.temperature_c};
    double *const not_negative[] = {&set.uncertainty.k_v_per_g[0][0],
                                    &set.uncertainty.u0_v[2],
                                    &set.max_abs_fit_g,
                                    &set.max_abs_check_g,
                                    &set.limit_g,
                                    &set.closure_v};
    for (size_t i = 0; i < COUNT_OF(any); i++) {
        *any[i] = (i % 2U == 0U) ? NOT_A_NUMBER : INFINITE;
        assert_encodes(TUMBLE_E_NOT_FINITE);
        *any[i] = -1e300;
        assert_encodes(TUMBLE_OK);
    }
    for (size_t i = 0; i < COUNT_OF(not_negative); i++) {
        *not_negative[i] = (i % 2U == 0U) ? INFINITE : NOT_A_NUMBER;
        assert_encodes(TUMBLE_E_NOT_FINITE);
        *not_negative[i] = -1e-300;
        assert_encodes(TUMBLE_E_ARGUMENT);
        *not_negative[i] = 0.0;
        assert_encodes(TUMBLE_OK);
    }
    set.gravity_m_s2 = 0.0;
    assert_encodes(TUMBLE_E_ARGUMENT);
    set.gravity_m_s2 = NOT_A_NUMBER;
    assert_encodes(TUMBLE_E_NOT_FINITE);
}

static void test_a_range_of_temperatures_has_its_lower_end_first(void)
{
    static const struct {
        int8_t min_half_c;
        int8_t max_half_c;
        tumble_status_t status;
    } ranges[] = {
        {0, 0, TUMBLE_OK},         {-128, 127, TUMBLE_OK},     {-128, -128, TUMBLE_OK},
        {127, 127, TUMBLE_OK},     {-13, -12, TUMBLE_OK},      {-12, -13, TUMBLE_E_ARGUMENT},
        {1, 0, TUMBLE_E_ARGUMENT}, {0, -1, TUMBLE_E_ARGUMENT}, {127, -128, TUMBLE_E_ARGUMENT},
    };
    for (size_t i = 0; i < COUNT_OF(ranges); i++) {
        tumble_set_t read;
        set.temperature_min_half_c = ranges[i].min_half_c;
        set.temperature_max_half_c = ranges[i].max_half_c;
        assert_encodes(ranges[i].status);
        if (ranges[i].status == TUMBLE_OK) {
            TEST_ASSERT_EQUAL_HEX8((uint8_t)ranges[i].min_half_c, bytes[294]);
            TEST_ASSERT_EQUAL_HEX8((uint8_t)ranges[i].max_half_c, bytes[295]);
            assert_status(TUMBLE_OK, tumble_set_decode(bytes, &read));
            TEST_ASSERT_EQUAL_INT8(ranges[i].min_half_c, read.temperature_min_half_c);
            TEST_ASSERT_EQUAL_INT8(ranges[i].max_half_c, read.temperature_max_half_c);
        }
    }
}

static void test_flags_origin_and_serial_are_checked(void)
{
    set.flags = TUMBLE_SET_FLAGS + 1U;
    assert_encodes(TUMBLE_E_ARGUMENT);
    set.flags = 0x8000;
    assert_encodes(TUMBLE_E_ARGUMENT);
    set.flags = TUMBLE_SET_FLAGS;
    set.origin = 0;
    assert_encodes(TUMBLE_E_ARGUMENT);
    set.origin = TUMBLE_ORIGIN_HELD + 1;
    assert_encodes(TUMBLE_E_ARGUMENT);
    set.origin = TUMBLE_ORIGIN_HELD;
    set.block_serial[12] = 'x';
    assert_encodes(TUMBLE_E_ARGUMENT);
    memset(set.block_serial, 'x', sizeof set.block_serial);
    assert_encodes(TUMBLE_OK);
    memset(set.block_serial, 0, sizeof set.block_serial);
    assert_encodes(TUMBLE_OK);
}

static void test_every_altered_bit_is_noticed(void)
{
    assert_encodes(TUMBLE_OK);
    for (unsigned bit = 0; bit < 8U * TUMBLE_SET_BYTES; bit++) {
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        assert_decodes((bit < 64U) ? TUMBLE_E_FRAME : TUMBLE_E_CRC);
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    assert_decodes(TUMBLE_OK);
}

/* A writer's mistakes: wrong, but with the right CRC. */
static void test_what_is_wrong_under_a_right_crc_is_refused(void)
{
    static const struct {
        unsigned byte;
        uint8_t value;
        uint16_t flags;
        tumble_status_t status;
    } wrong[] = {
        {12, 0, 0x3F, TUMBLE_E_ARGUMENT},     {12, 6, 0x3F, TUMBLE_E_ARGUMENT},
        {15, 0x01, 0x3F, TUMBLE_E_ARGUMENT},  {15, 0x80, 0x3F, TUMBLE_E_ARGUMENT},
        {39, 'x', 0x3F, TUMBLE_E_ARGUMENT},   {294, 1, 0x3F, TUMBLE_E_FRAME},
        {295, 1, 0x3F, TUMBLE_E_FRAME},       {48, 1, 0x3E, TUMBLE_E_FRAME},
        {56, 1, 0x3D, TUMBLE_E_FRAME},        {255, 1, 0x3B, TUMBLE_E_FRAME},
        {279, 1, 0x37, TUMBLE_E_FRAME},       {287, 1, 0x2F, TUMBLE_E_FRAME},
        {64, 0x7F, 0x3F, TUMBLE_OK},          {167, 0x80, 0x3F, TUMBLE_E_ARGUMENT},
        {294, 0x7F, 0xBF, TUMBLE_E_ARGUMENT}, {295, 0x80, 0xBF, TUMBLE_E_ARGUMENT},
        {295, 0x7F, 0xBF, TUMBLE_OK},
    };
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        set = set_of(3);
        set.origin = TUMBLE_ORIGIN_FACTORY;
        set.flags = wrong[i].flags;
        assert_encodes(TUMBLE_OK);
        bytes[wrong[i].byte] = wrong[i].value;
        tumble_record_seal(bytes, 316, 0);
        assert_decodes(wrong[i].status);
    }
    memset(&bytes[64], 0xFF, 8);
    tumble_record_seal(bytes, 316, 0);
    assert_decodes(TUMBLE_E_NOT_FINITE);
}
