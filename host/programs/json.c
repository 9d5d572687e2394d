#include "json.h"

#include <inttypes.h>
#include <math.h>

static void begin(bench_json_t *json, const char *name)
{
    if (json->comma) {
        (void)fputc(',', json->out);
    }
    if (name != NULL) {
        (void)fprintf(json->out, "\"%s\":", name);
    }
    json->comma = true;
}

void bench_json_open(bench_json_t *json, const char *name, char bracket)
{
    begin(json, name);
    (void)fputc(bracket, json->out);
    json->comma = false;
}

void bench_json_close(bench_json_t *json, char bracket)
{
    (void)fputc(bracket, json->out);
    json->comma = true;
}

void bench_json_null(bench_json_t *json, const char *name)
{
    begin(json, name);
    (void)fputs("null", json->out);
}

void bench_json_number(bench_json_t *json, const char *name, double value)
{
    if (!isfinite(value)) {
        bench_json_null(json, name);
        return;
    }
    begin(json, name);
    (void)fprintf(json->out, "%.17g", value);
}

void bench_json_whole(bench_json_t *json, const char *name, uint64_t value)
{
    begin(json, name);
    (void)fprintf(json->out, "%" PRIu64, value);
}

void bench_json_flag(bench_json_t *json, const char *name, bool value)
{
    begin(json, name);
    (void)fputs(value ? "true" : "false", json->out);
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
    (void)fputc('"', json->out);
    for (const char *c = value; *c != '\0';) {
        const size_t size = bench_json_character(c);
        if (size == 0U) {
            (void)fputs("\\ufffd", json->out);
        } else if (*c == '"' || *c == '\\') {
            (void)fprintf(json->out, "\\%c", *c);
        } else if ((unsigned char)*c < 0x20U) {
            (void)fprintf(json->out, "\\u%04x", (unsigned)(unsigned char)*c);
        } else {
            (void)fwrite(c, 1, size, json->out);
        }
        c += (size > 0U) ? size : 1U;
    }
    (void)fputc('"', json->out);
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

void bench_json_interface(bench_json_t *json, const can_socket_counters_t *counters)
{
    bench_json_whole(json, "kernel_received", counters->received);
    bench_json_whole(json, "kernel_sent", counters->sent);
    bench_json_whole(json, "kernel_dropped", counters->dropped);
    bench_json_whole(json, "kernel_busy", counters->busy);
    bench_json_whole(json, "error_frames", counters->errors);
    bench_json_whole(json, "bus_offs", counters->bus_offs);
    bench_json_whole(json, "interface_downs", counters->downs);
}

void bench_json_end(bench_json_t *json)
{
    bench_json_close(json, '}');
    (void)fputc('\n', json->out);
    (void)fflush(json->out);
}
