/* json.h - writes one JSON document to a stream or into memory, on one line.
 *
 * Numbers get 17 digits, so that a reader has the same double; what is not finite becomes null. Names are the program's
 * own; texts are escaped, and bytes in them that are no UTF-8, as a file name may have, become U+FFFD. The writer knows
 * only whether a comma is due.
 */
#ifndef TUMBLE_WORLD_JSON_H
#define TUMBLE_WORLD_JSON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef struct {
    FILE *out;  /* null: */
    char *text; /* into this, as much as there is room for, with a zero behind it */
    size_t room;
    size_t used;
    bool comma;
} bench_json_t;

/* `name` is null within a list and for the document itself. */
void bench_json_open(bench_json_t *json, const char *name, char bracket);
void bench_json_close(bench_json_t *json, char bracket);
void bench_json_number(bench_json_t *json, const char *name, double value);
void bench_json_whole(bench_json_t *json, const char *name, uint64_t value);
void bench_json_flag(bench_json_t *json, const char *name, bool value);
void bench_json_text(bench_json_t *json, const char *name, const char *value);
void bench_json_null(bench_json_t *json, const char *name);

/* A list of numbers; a 3 x 3 matrix as a list of its rows. */
void bench_json_vector(bench_json_t *json, const char *name, const double *values, uint32_t count);
void bench_json_matrix(bench_json_t *json, const char *name, const double matrix[3][3]);

/* The end of a document that is one object; in a stream, a line for somebody who waits for it. */
void bench_json_end(bench_json_t *json);

/* Bytes of the character of UTF-8 that a text begins with, 1 to 4; 0: it begins with none (RFC 3629, section 4). The
 * text is not empty. */
size_t bench_json_character(const char *text);

#endif
