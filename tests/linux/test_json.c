/* Texts in JSON: escaped, and UTF-8 whatever they were. */
#define _POSIX_C_SOURCE 200809L

#include "suite.h"
#include "world/json.h"

#include <string.h>

static void expect(const char *text, const char *written)
{
    char got[200] = "";
    FILE *const out = fmemopen(got, sizeof got, "w");
    TEST_ASSERT_NOT_NULL(out);
    bench_json_t json = {.out = out};
    bench_json_text(&json, NULL, text);
    TEST_ASSERT_EQUAL_INT(0, fclose(out));
    TEST_ASSERT_EQUAL_STRING(written, got);
}

static void test_what_json_wants_escaped(void)
{
    expect("", "\"\"");
    expect("a\"b\\c/", "\"a\\\"b\\\\c/\"");
    expect("\n\t\x01\x1f\x7f", "\"\\u000a\\u0009\\u0001\\u001f\x7f\"");
}

static void test_characters_of_each_length(void)
{
    expect("\xc2\x80\xdf\xbf", "\"\xc2\x80\xdf\xbf\"");
    expect("\xe0\xa0\x80\xed\x9f\xbf\xee\x80\x80\xef\xbf\xbf", "\"\xe0\xa0\x80\xed\x9f\xbf\xee\x80\x80\xef\xbf\xbf\"");
    expect("\xf0\x90\x80\x80\xf4\x8f\xbf\xbf", "\"\xf0\x90\x80\x80\xf4\x8f\xbf\xbf\"");
}

static void test_bytes_that_are_no_character(void)
{
    expect("a\xff z", "\"a\\ufffd z\"");
    expect("\xe4", "\"\\ufffd\"");                       /* Latin-1, and the end of the text */
    expect("\xc1\xbf", "\"\\ufffd\\ufffd\"");            /* longer than need be */
    expect("\xed\xa0\x80", "\"\\ufffd\\ufffd\\ufffd\""); /* half of a pair */
    expect("\xe2\x82\"", "\"\\ufffd\\ufffd\\\"\"");      /* what follows is read all the same */
    expect("\xf4\x90\x80\x80", "\"\\ufffd\\ufffd\\ufffd\\ufffd\"");
}

/* Every first and second byte, with as many as could follow: the sizes of RFC 3629, section 3, counted otherwise. */
static void test_every_beginning(void)
{
    for (unsigned bytes = 0x0100; bytes < 0x10000U; bytes++) {
        const unsigned first = bytes >> 8;
        const unsigned second = bytes & 0xFFU;
        const char text[] = {(char)first, (char)second, (char)0x80, (char)0x80, '\0'};
        const unsigned size = (first < 0x80U) ? 1U : (first < 0xE0U) ? 2U : (first < 0xF0U) ? 3U : 4U;
        const unsigned code = (size == 2U)   ? (first & 0x1FU) << 6 | (second & 0x3FU)
                              : (size == 3U) ? (first & 0x0FU) << 12 | (second & 0x3FU) << 6
                                             : (first & 0x07U) << 18 | (second & 0x3FU) << 12;
        const unsigned least = (size == 2U) ? 0x80U : (size == 3U) ? 0x800U : 0x10000U;
        const bool is_pair = code >= 0xD800U && code <= 0xDFFFU;
        const bool is_one = first >= 0xC0U && first < 0xF8U && (second & 0xC0U) == 0x80U && code >= least &&
                            code <= 0x10FFFFU && !is_pair;
        TEST_ASSERT_EQUAL_size_t((size == 1U || is_one) ? size : 0U, bench_json_character(text));
    }
}
