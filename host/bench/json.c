#include "bench/json.h"

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

void bench_json_text(bench_json_t *json, const char *name, const char *value)
{
    begin(json, name);
    (void)fputc('"', json->out);
    for (const char *c = value; *c != '\0'; c++) {
        if (*c == '"' || *c == '\\') {
            (void)fprintf(json->out, "\\%c", *c);
        } else if ((unsigned char)*c < 0x20U) {
            (void)fprintf(json->out, "\\u%04x", (unsigned)(unsigned char)*c);
        } else {
            (void)fputc(*c, json->out);
        }
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
