/* config_file.h - scenario files: one `key = value` a line.
 *
 *     # comment, empty lines
 *     stand.angle_rad = 4e-5
 *     block.u0 = 0.1 -0.02 0.03
 *     fault = stall at=1.3 phase=move duration=2
 *
 * `tumble bench --keys` prints the keys with their ranges, each at most once, and the lines that may repeat. Numbers are decimal (0x... where whole; the INDEX of an INDEX:SUBINDEX:BITS is hexadecimal in any
 * case), separated by blanks; nothing else may stand on a line. Reading stops at the first mistake. A schedule must be
 * given whole: its first line replaces the paper's. A fault whose duration is 0 is for good.
 */
#ifndef TUMBLE_WORLD_CONFIG_FILE_H
#define TUMBLE_WORLD_CONFIG_FILE_H

#include "world/config.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The keys that come once, each with its type, range and place in the configuration. */

/* Those before BENCH_TEXT are named as in the tables of fields (procedure/config_fields.h). */
typedef enum {
    BENCH_F64 = 0,
    BENCH_F32,
    BENCH_U8,
    BENCH_U16,
    BENCH_U32,
    BENCH_I8,
    BENCH_I32,
    BENCH_BOOL,  /* no, yes; from here on words */
    BENCH_ENUM,  /* one of the words, by their order */
    BENCH_ENUM8, /* the same in a byte */
    BENCH_TEXT,  /* one word; `high` is the most characters, and behind them there is room for a zero */
    BENCH_INDEX, /* of an object; from here on of lines that may repeat */
    BENCH_OBJECT,
    BENCH_CHANNELS,
    BENCH_PLACE
} bench_type_t;

typedef struct {
    const char *name; /* null: a field that no line sets */
    bench_type_t type;
    uint8_t count; /* values on the line; of three, which are those of the channels, one may stand for all */
    size_t offset; /* in bench_config_t, or in what the line fills */
    double low;    /* of a value, both included */
    double high;
    const char *about; /* unit and meaning; of an enum: its words, separated by '|' */
} bench_key_t;

extern const bench_key_t bench_config_keys[];
extern const size_t bench_config_key_count;

/* The key of this name; null: there is none. */
const bench_key_t *bench_find_key(const char *name);

/* The range of a key's values, for people. */
void bench_describe_key(const bench_key_t *key, char *text, size_t size);

/* Lines. */

/* What is wrong, for one line to the user. */
typedef struct {
    unsigned line; /* 0: not of one line */
    char what[200];
} bench_mistake_t;

#define BENCH_MAX_KEYS 160

/* Which keys have been given. */
typedef struct {
    bool key[BENCH_MAX_KEYS];
} bench_seen_t;

/* Take one line, which is cut into its words. */
bool bench_config_take(bench_config_t *config, char *line, bench_seen_t *seen, bench_mistake_t *mistake);

/* What no single line can show, once all are taken. */
bool bench_config_check(bench_config_t *config, const bench_seen_t *seen, bench_mistake_t *mistake);

#endif
