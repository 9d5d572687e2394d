/* config_text.h - words and numbers of a line of a scenario file (private to the reading of it). */
#ifndef TUMBLE_BENCH_CONFIG_TEXT_H
#define TUMBLE_BENCH_CONFIG_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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
