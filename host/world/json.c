#include "world/json.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>

static void put(bench_json_t *json, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    if (json->out != NULL) {
        (void)vfprintf(json->out, format, arguments);
    } else {
        const int size = vsnprintf(&json->text[json->used], json->room - json->used, format, arguments);
        const size_t left = json->room - json->used - 1U;
        json->used += ((size_t)size < left) ? (size_t)size : left;
    }
    va_end(arguments);
}

static void begin(bench_json_t *json, const char *name)
{
    const char *const comma = json->comma ? "," : "";
    if (name != NULL) {
        put(json, "%s\"%s\":", comma, name);
    } else {
        put(json, "%s", comma);
    }
    json->comma = true;
}

void bench_json_open(bench_json_t *json, const char *name, char bracket)
{
    begin(json, name);
    put(json, "%c", bracket);
    json->comma = false;
}

void bench_json_close(bench_json_t *json, char bracket)
{
    put(json, "%c", bracket);
    json->comma = true;
}

void bench_json_null(bench_json_t *json, const char *name)
{
    begin(json, name);
    put(json, "null");
}

void bench_json_number(bench_json_t *json, const char *name, double value)
{
    if (!isfinite(value)) {
        bench_json_null(json, name);
        return;
    }
    begin(json, name);
    /* Programs that read what is in memory take -0 for a whole number, which has no sign. */
    put(json, (json->out == NULL && value == 0.0 && signbit(value)) ? "%.1f" : "%.17g", value);
}

void bench_json_whole(bench_json_t *json, const char *name, uint64_t value)
{
    begin(json, name);
    put(json, "%" PRIu64, value);
}

void bench_json_flag(bench_json_t *json, const char *name, bool value)
{
    begin(json, name);
    put(json, "%s", value ? "true" : "false");
}

/* By the first byte, how many follow and between which limits the second is: so nothing is longer than need be, no half
 * of a pair, and nothing above 10FFFFh. */
size_t bench_json_character(const char *text)
{
    static const struct {
        unsigned char first;
        unsigned char last;
        unsigned char low;
        unsigned char high;
        unsigned char size;
    } rows[] = {
        {0x01, 0x7F, 0x00, 0x00, 1}, {0xC2, 0xDF, 0x80, 0xBF, 2}, {0xE0, 0xE0, 0xA0, 0xBF, 3},
        {0xE1, 0xEC, 0x80, 0xBF, 3}, {0xED, 0xED, 0x80, 0x9F, 3}, {0xEE, 0xEF, 0x80, 0xBF, 3},
        {0xF0, 0xF0, 0x90, 0xBF, 4}, {0xF1, 0xF3, 0x80, 0xBF, 4}, {0xF4, 0xF4, 0x80, 0x8F, 4},
    };
    const unsigned char *const bytes = (const unsigned char *)text;
    size_t row = 0;
    while (row < sizeof rows / sizeof rows[0] && bytes[0] > rows[row].last) {
        row++;
    }
    if (row == sizeof rows / sizeof rows[0] || bytes[0] < rows[row].first) {
        return 0;
    }
    for (size_t i = 1; i < rows[row].size; i++) {
        const unsigned char low = (i == 1U) ? rows[row].low : 0x80U;
        const unsigned char high = (i == 1U) ? rows[row].high : 0xBFU;
        if (bytes[i] < low || bytes[i] > high) {
            return 0;
        }
    }
    return rows[row].size;
}

void bench_json_text(bench_json_t *json, const char *name, const char *value)
{
    begin(json, name);
    put(json, "\"");
    for (const char *c = value; *c != '\0';) {
        const size_t size = bench_json_character(c);
        if (size == 0U) {
            put(json, "\\ufffd");
        } else if (*c == '"' || *c == '\\') {
            put(json, "\\%c", *c);
        } else if ((unsigned char)*c < 0x20U) {
            put(json, "\\u%04x", (unsigned)(unsigned char)*c);
        } else {
            put(json, "%.*s", (int)size, c);
        }
        c += (size > 0U) ? size : 1U;
    }
    put(json, "\"");
}

void bench_json_vector(bench_json_t *json, const char *name, const double *values, uint32_t count)
{
    bench_json_open(json, name, '[');
    for (uint32_t i = 0; i < count; i++) {
        bench_json_number(json, NULL, values[i]);
    }
    bench_json_close(json, ']');
}

void bench_json_matrix(bench_json_t *json, const char *name, const double matrix[3][3])
{
    bench_json_open(json, name, '[');
    for (int row = 0; row < 3; row++) {
        bench_json_vector(json, NULL, matrix[row], 3);
    }
    bench_json_close(json, ']');
}

void bench_json_end(bench_json_t *json)
{
    bench_json_close(json, '}');
    if (json->out != NULL) {
        (void)fputc('\n', json->out);
        (void)fflush(json->out);
    }
}
