/* config_keys.h - the keys of a scenario file, each with its type, range and place in the configuration; and how a value
 * is read from text.
 */
#ifndef TUMBLE_WORLD_CONFIG_KEYS_H
#define TUMBLE_WORLD_CONFIG_KEYS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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
    BENCH_TEXT   /* one word; `high` is the most characters, and behind them there is room for a zero */
} bench_type_t;

typedef struct {
    const char *name; /* null: a field that no line sets */
    bench_type_t type;
    uint8_t count; /* values on the line; of three, which are those of the channels, one may stand for all */
    size_t offset; /* in bench_config_t */
    double low;    /* of a value, both included */
    double high;
    const char *about; /* unit and meaning; of an enum: its words, separated by '|' */
} bench_key_t;

extern const bench_key_t bench_config_keys[];
extern const size_t bench_config_key_count;

/* The key of this name; null: there is none. */
const bench_key_t *bench_find_key(const char *name);

/* Store the values of a key in `structure`, which its offset is in. False: they are not as `bench_describe_key` says. */
bool bench_store_key(const bench_key_t *key, void *structure, char *const word[], unsigned count);

/* The range of a key's values, for people. */
void bench_describe_key(const bench_key_t *key, char *text, size_t size);

#define BENCH_MAX_WORDS 24

/* The words of a value, separated by blanks. */
typedef struct {
    char *word[BENCH_MAX_WORDS];
    unsigned count;
} bench_words_t;

/* Cut `text` into its words, in place. False: too many. */
bool bench_cut_words(char *text, bench_words_t *words);

/* A finite number from low to high; all of `text` must be it. */
bool bench_number(const char *text, double low, double high, double *value);

/* A whole number, decimal or 0x. */
bool bench_whole(const char *text, double low, double high, int64_t *value);

/* Place of `text` among words separated by '|', or -1. */
int bench_choice(const char *text, const char *words);

#endif
