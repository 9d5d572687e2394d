/* The object dictionary: finding entries, every type both ways, order of refusals, hooks, homes. */
#include "canopen_fixture.h"

#include <math.h>

static tumble_abort_t refusal;
static uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
static uint8_t size;

static void set_up(void)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, fixture_start(&fixture_quiet));
    memset(bytes, 0xA5, sizeof bytes);
    size = 0xA5;
}

static const tumble_entry_t *find(uint16_t index, uint8_t subindex)
{
    static tumble_entry_t entry;

    refusal = tumble_dictionary_find(&at.node.dictionary, index, subindex, &entry);
    return (refusal == TUMBLE_ABORT_NONE) ? &entry : NULL;
}

static tumble_abort_t read(uint16_t index, uint8_t subindex)
{
    const tumble_entry_t *entry = find(index, subindex);

    TEST_ASSERT_NOT_NULL(entry);
    size = 0xA5;
    return tumble_dictionary_read(&at.node.dictionary, entry, bytes, &size);
}

static tumble_abort_t write_sub(uint16_t index, uint8_t subindex, const void *value, uint8_t length)
{
    const tumble_entry_t *entry = find(index, subindex);

    TEST_ASSERT_NOT_NULL(entry);
    return tumble_dictionary_write(&at.node.dictionary, entry, value, length);
}

static tumble_abort_t write(uint16_t index, const void *value, uint8_t length)
{
    return write_sub(index, 0, value, length);
}

/* Brute force over the whole range of keys that could confuse a search. */
static void test_every_key_is_found_as_the_table_has_it(void)
{
    for (uint32_t index = 0; index <= 0x2020U; index++) {
        for (unsigned sub = 0; sub < 11U; sub++) {
            tumble_abort_t wanted = TUMBLE_ABORT_NO_OBJECT;

            for (size_t i = 0; (i < fixture_table.count) && (wanted != TUMBLE_ABORT_NONE); i++) {
                if (fixture_entries[i].index == index) {
                    bool found = (fixture_entries[i].subindex == sub) || (sub == 0U);
                    wanted = found ? TUMBLE_ABORT_NONE : TUMBLE_ABORT_NO_SUBINDEX;
                }
            }
            (void)find((uint16_t)index, (uint8_t)sub);
            TEST_ASSERT_EQUAL_HEX32(wanted, refusal);
        }
    }
    for (size_t i = 0; i < fixture_table.count; i++) {
        TEST_ASSERT_EQUAL_MEMORY(&fixture_entries[i], find(fixture_entries[i].index, fixture_entries[i].subindex),
                                 sizeof(tumble_entry_t));
    }
    TEST_ASSERT_NULL(find(0xFFFF, 0xFF));
}

static void test_an_empty_table_has_nothing(void)
{
    static const tumble_object_table_t empty = {.entries = fixture_entries, .count = 0};
    tumble_dictionary_t dictionary = {.table = &empty};

    tumble_entry_t entry;

    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT, tumble_dictionary_find(&dictionary, 0x1000, 0, &entry));
}

static void test_every_type_goes_out_little_endian(void)
{
    static const struct {
        uint16_t index;
        uint8_t size;
        uint8_t bytes[8];
    } cases[] = {
        {0x2000, 1, {1}},
        {0x2001, 1, {0xFB}},
        {0x2002, 2, {0x18, 0xFC}},
        {0x2003, 4, {0xFE, 0xFF, 0xFF, 0xFF}},
        {0x2005, 2, {0x34, 0x12}},
        {0x2006, 4, {0x78, 0x56, 0x34, 0x12}},
        {0x2007, 4, {0x00, 0x00, 0x00, 0xBF}},
        {0x2008, 8, {0, 0, 0, 0, 0, 0, 0xD0, 0x3F}},
        {0x2009, 8, {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F}},
        {0x200A, 8, {0xEF, 0xCD, 0xAB, 0x89, 0x67, 0x45, 0x23, 0x01}},
        {0x2013, 2, {0xCD, 0xAB}},
        {0x1000, 4, {0x92, 0x01, 0x02, 0x00}},
        {0x1005, 4, {0x80, 0, 0, 0}},
        {0x2015, 8, {0, 0, 0, 0, 0, 0, 0x0A, 0x40}},
    };

    at.variables = (variables_t){.flag = true,
                                 .i8 = -5,
                                 .i16 = -1000,
                                 .i32 = -2,
                                 .u16 = 0x1234,
                                 .u32 = 0x12345678U,
                                 .f32 = -0.5f,
                                 .f64 = 0.25,
                                 .i64 = INT64_MAX,
                                 .u64 = UINT64_C(0x0123456789ABCDEF)};
    at.other.other = 0xABCD;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(cases[i].index, 0));
        TEST_ASSERT_EQUAL_UINT8(cases[i].size, size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(cases[i].bytes, bytes, size);
    }
}

static void test_every_type_comes_back_as_it_was_written(void)
{
    static const uint16_t indices[] = {0x2000, 0x2001, 0x2002, 0x2003, 0x2004, 0x2005, 0x2006,
                                       0x2007, 0x2008, 0x2009, 0x200A, 0x2010, 0x2013, 0x2014};
    static const uint8_t value[8] = {1, 0, 0, 0, 0, 0, 0, 0};
    static const uint8_t hundred[8] = {100, 0, 0, 0, 0, 0, 0, 0};

    for (size_t i = 0; i < COUNT_OF(indices); i++) {
        const uint8_t *source = (indices[i] == 0x2006) ? hundred : value;
        uint8_t length = find(indices[i], 0)->size;

        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, write(indices[i], source, length));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(indices[i], 0));
        TEST_ASSERT_EQUAL_UINT8(length, size);
        TEST_ASSERT_EQUAL_HEX8_ARRAY(source, bytes, length);
    }
    TEST_ASSERT_EQUAL_UINT32(1, at.computed);
    TEST_ASSERT_EQUAL_UINT16(1, at.other.other);
    TEST_ASSERT_EQUAL_UINT32(0, at.other.unused);
    TEST_ASSERT_EQUAL_INT64(1, at.variables.i64);
}

static void test_the_helpers_of_bytes_agree_with_the_machine(void)
{
    static const int32_t values[] = {0, 1, -1, 127, -128, 32767, -32768, INT32_MAX, INT32_MIN, 0x12345678};

    for (size_t i = 0; i < COUNT_OF(values); i++) {
        tumble_put_i32(bytes, values[i]);
        TEST_ASSERT_EQUAL_INT32(values[i], tumble_get_i32(bytes));
        TEST_ASSERT_EQUAL_INT16((int16_t)(uint16_t)((uint32_t)values[i] & 0xFFFFU), tumble_get_i16(bytes));
        TEST_ASSERT_EQUAL_INT8((int8_t)(uint8_t)((uint32_t)values[i] & 0xFFU), tumble_get_i8(bytes));
    }
    tumble_put_f64(bytes, -1.5);
    TEST_ASSERT_TRUE(tumble_get_f64(bytes) == -1.5);
    tumble_put_f32(bytes, 0.1f);
    TEST_ASSERT_TRUE(tumble_get_f32(bytes) == 0.1f);
    tumble_put_u64(bytes, UINT64_C(0xFEDCBA9876543210));
    TEST_ASSERT_TRUE(tumble_get_u64(bytes) == UINT64_C(0xFEDCBA9876543210));
}

static void test_strings_end_at_their_padding_or_their_size(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(0x1008, 0));
    TEST_ASSERT_EQUAL_UINT8(16, size);
    TEST_ASSERT_EQUAL_MEMORY("Tumble test node", bytes, 16);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(0x200B, 0));
    TEST_ASSERT_EQUAL_UINT8(0, size);
    memset(at.variables.text, 'x', sizeof at.variables.text); /* no room for a zero */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(0x200B, 0));
    TEST_ASSERT_EQUAL_UINT8(32, size);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, write(0x200B, "hello", 5));
    for (size_t i = 5; i < sizeof at.variables.text; i++) {
        TEST_ASSERT_EQUAL_INT(0, at.variables.text[i]);
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, write(0x200B, "", 0));
    TEST_ASSERT_EQUAL_STRING("", at.variables.text);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LONG, write(0x200B, "012345678901234567890123456789012", 33));
}

static void test_a_hook_may_shorten_a_string_but_not_lengthen_it(void)
{
    memset(at.sentence, 'y', 64);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(0x2011, 0));
    TEST_ASSERT_EQUAL_UINT8(64, size);
    at.sentence[3] = '\0';
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(0x2011, 0));
    TEST_ASSERT_EQUAL_UINT8(3, size);
}

static tumble_abort_t boastful_read(void *context, const tumble_entry_t *entry, uint8_t *out, uint8_t *length)
{
    (void)context;
    (void)entry;
    memset(out, 0, TUMBLE_MAX_OBJECT_BYTES);
    *length = 200;
    return TUMBLE_ABORT_NONE;
}

static void test_a_size_that_a_hook_invents_is_cut(void)
{
    static const tumble_object_hooks_t hooks = {.read = boastful_read};

    at.node.dictionary.application.hooks = &hooks;
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(0x2011, 0));
    TEST_ASSERT_EQUAL_UINT8(64, size);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, read(0x2010, 0));
    TEST_ASSERT_EQUAL_UINT8(4, size);
}

static void test_access_is_checked_before_length(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_READ_ONLY, write(0x200D, "abc", 3));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_READ_ONLY, write(0x1000, "abcd", 4));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_WRITE_ONLY, read(0x200C, 0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, write(0x200C, "a", 1));
    TEST_ASSERT_EQUAL_UINT8('a', at.variables.secret);
}

static void test_length_must_be_exact_for_numbers(void)
{
    static const uint8_t zeros[64] = {0};

    for (uint8_t length = 0; length < 64; length++) {
        tumble_abort_t wanted = (length < 4)   ? TUMBLE_ABORT_TOO_SHORT
                                : (length > 4) ? TUMBLE_ABORT_TOO_LONG
                                               : TUMBLE_ABORT_NONE;

        TEST_ASSERT_EQUAL_HEX32(wanted, write(0x2003, zeros, length));
        TEST_ASSERT_EQUAL_HEX32(wanted, tumble_dictionary_accepts(find(0x2003, 0), length));
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LONG, tumble_dictionary_accepts(find(0x200B, 0), UINT32_MAX));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, tumble_dictionary_accepts(find(0x200B, 0), 0));
}

static void test_integer_limits_are_inclusive(void)
{
    static const struct {
        uint16_t index;
        uint8_t size;
        uint32_t value;
        tumble_abort_t wanted;
    } cases[] = {
        {0x2001, 1, 0x05, TUMBLE_ABORT_NONE},        {0x2001, 1, 0x06, TUMBLE_ABORT_TOO_HIGH},
        {0x2001, 1, 0xFB, TUMBLE_ABORT_NONE},        {0x2001, 1, 0xFA, TUMBLE_ABORT_TOO_LOW},
        {0x2001, 1, 0x80, TUMBLE_ABORT_TOO_LOW},     {0x2001, 1, 0x7F, TUMBLE_ABORT_TOO_HIGH},
        {0x2002, 2, 1000, TUMBLE_ABORT_NONE},        {0x2002, 2, 1001, TUMBLE_ABORT_TOO_HIGH},
        {0x2002, 2, 0xFC18, TUMBLE_ABORT_NONE},      {0x2002, 2, 0xFC17, TUMBLE_ABORT_TOO_LOW},
        {0x2003, 4, 0x80000000U, TUMBLE_ABORT_NONE}, {0x2003, 4, 0x7FFFFFFFU, TUMBLE_ABORT_NONE},
        {0x2006, 4, 9, TUMBLE_ABORT_TOO_LOW},        {0x2006, 4, 10, TUMBLE_ABORT_NONE},
        {0x2006, 4, 4000000000U, TUMBLE_ABORT_NONE}, {0x2006, 4, 4000000001U, TUMBLE_ABORT_TOO_HIGH},
        {0x2000, 1, 2, TUMBLE_ABORT_VALUE},          {0x2000, 1, 1, TUMBLE_ABORT_NONE},
        {0x2000, 1, 255, TUMBLE_ABORT_VALUE},        {0x2014, 4, 13, TUMBLE_ABORT_DEVICE_STATE},
    };

    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        uint8_t value[4];
        variables_t before = at.variables;

        tumble_put_u32(value, cases[i].value);
        TEST_ASSERT_EQUAL_HEX32(cases[i].wanted, write(cases[i].index, value, cases[i].size));
        if (cases[i].wanted != TUMBLE_ABORT_NONE) {
            TEST_ASSERT_EQUAL_MEMORY(&before, &at.variables, sizeof before); /* a refused value changes nothing */
        }
    }
}

static void test_limits_of_unsigned_numbers(void)
{
    for (unsigned value = 0; value < 1000U; value++) {
        tumble_abort_t wanted = (value < 3U)     ? TUMBLE_ABORT_TOO_LOW
                                : (value > 200U) ? TUMBLE_ABORT_TOO_HIGH
                                                 : TUMBLE_ABORT_NONE;
        uint8_t number[2];

        tumble_put_u16(number, (uint16_t)value);
        TEST_ASSERT_EQUAL_HEX32(wanted, write_sub(0x200F, 2, number, 2));
        if (value < 256U) {
            TEST_ASSERT_EQUAL_HEX32(wanted, write_sub(0x200E, 1, number, 1));
        }
    }
}

static void test_real_limits_refuse_what_is_not_a_number(void)
{
    static const float refused[] = {NAN, INFINITY, -INFINITY};
    uint8_t value[8];

    for (size_t i = 0; i < COUNT_OF(refused); i++) {
        tumble_put_f64(value, (double)refused[i]);
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, write(0x2008, value, 8));
        tumble_put_f32(value, refused[i]);
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, write(0x2007, value, 4));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, write_sub(0x200F, 1, value, 4)); /* also without limits */
        tumble_put_f64(value, (double)refused[i]);
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, write(0x200F, value, 8));
    }
    tumble_put_f64(value, -1e300);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, write(0x200F, value, 8));
    TEST_ASSERT_TRUE(at.variables.unlimited == -1e300);
    tumble_put_f64(value, 1.0);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, write(0x2008, value, 8));
    tumble_put_f64(value, nextafter(1.0, 2.0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write(0x2008, value, 8));
    tumble_put_f64(value, nextafter(-1.0, -2.0));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_LOW, write(0x2008, value, 8));
    TEST_ASSERT_TRUE(at.variables.f64 == 1.0);
    tumble_put_f32(value, 1.5f);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_TOO_HIGH, write(0x2007, value, 4));
}

static void test_a_hook_can_pack_what_it_has_in_memory(void)
{
    const uint32_t number = 0x12345678U;
    const char text[64] = "sixteen or fewer";

    tumble_dictionary_pack(find(0x2010, 0), &number, bytes, &size);
    TEST_ASSERT_EQUAL_UINT8(4, size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY("\x78\x56\x34\x12", bytes, 4);
    tumble_dictionary_pack(find(0x2011, 0), text, bytes, &size);
    TEST_ASSERT_EQUAL_UINT8(16, size);
    TEST_ASSERT_EQUAL_MEMORY(text, bytes, 16);
}

static void test_the_hook_is_asked_after_the_checks_only(void)
{
    (void)write(0x2001, "\x7F", 1);
    (void)write(0x2003, "ab", 2);
    (void)write(0x200D, "ab", 2);
    TEST_ASSERT_EQUAL_UINT(0, at.writes);
    (void)write(0x2001, "\x01", 1);
    TEST_ASSERT_EQUAL_UINT(1, at.writes);
}

static void test_without_hooks_variables_work_and_computed_objects_refuse(void)
{
    static const tumble_object_hooks_t none = {0};

    for (int i = 0; i < 2; i++) {
        at.node.dictionary.application.hooks = (i == 0) ? NULL : &none;
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, write(0x2004, "\x07", 1));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_DATA, read(0x2010, 0));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_ACCESS, write(0x2010, "\1\2\3\4", 4));
    }
}

static void test_a_dummy_takes_everything_and_keeps_nothing(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, write(0x0005, "\xFF", 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_WRITE_ONLY, read(0x0005, 0));
    TEST_ASSERT_EQUAL_UINT(0, at.writes);
}

static void test_the_node_reads_and_writes_its_own_objects_by_the_same_rules(void)
{
    static const uint8_t hundred[4] = {100};

    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, tumble_node_write(&at.node, 0x2006, 0, hundred, 4));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NONE, tumble_node_read(&at.node, 0x2006, 0, bytes, &size));
    TEST_ASSERT_EQUAL_UINT32(100, tumble_get_u32(bytes));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_OBJECT, tumble_node_read(&at.node, 0x3006, 0, bytes, &size));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_NO_SUBINDEX, tumble_node_write(&at.node, 0x2006, 1, hundred, 4));
}

static void test_abort_codes_have_sentences(void)
{
    TEST_ASSERT_EQUAL_STRING("object does not exist", tumble_abort_sentence(TUMBLE_ABORT_NO_OBJECT));
    TEST_ASSERT_EQUAL_STRING("value is too low", tumble_abort_sentence(0x06090032U));
    TEST_ASSERT_EQUAL_STRING("this abort code is not in the list", tumble_abort_sentence(0xFFFFFFFFU));
}

static const around_t around_each = {set_up, fixture_end};
