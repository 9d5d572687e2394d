/* config_keys.h - the keys of a scenario file, each with its type, range and place in the configuration. */
#ifndef TUMBLE_BENCH_CONFIG_KEYS_H
#define TUMBLE_BENCH_CONFIG_KEYS_H

#include <stddef.h>
#include <stdint.h>

typedef enum {
    BENCH_DOUBLE = 0,
    BENCH_FLOAT,
    BENCH_U8,
    BENCH_U16,
    BENCH_U32,
    BENCH_I8,
    BENCH_I32,
    BENCH_BOOL,   /* no, yes */
    BENCH_CHOICE, /* an enum: one of the words, by their order */
    BENCH_TEXT,   /* one word; `high` is the most characters, and behind them there is room for a zero */
} bench_type_t;

typedef struct {
    const char *name;
    bench_type_t type;
    uint8_t count; /* values on the line */
    size_t offset; /* in bench_config_t */
    double low;    /* of a value, both included */
    double high;
    const char *about; /* unit and meaning; of a choice: its words, separated by '|' */
} bench_key_t;

extern const bench_key_t bench_config_keys[];
extern const size_t bench_config_key_count;

#endif
