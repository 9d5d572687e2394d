#include "bench/config_text.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

bool bench_cut_words(char *text, bench_words_t *words)
{
    words->count = 0;
    for (char *word = strtok(text, " \t"); word != NULL; word = strtok(NULL, " \t")) {
        if (words->count == BENCH_MAX_WORDS) {
            return false;
        }
        words->word[words->count++] = word;
    }
    return true;
}

bool bench_number(const char *text, double low, double high, double *value)
{
    char *end = NULL;
    if (*text == '\0' || isspace((unsigned char)*text)) {
        return false;
    }
    const double number = strtod(text, &end);
    if (end == text || *end != '\0' || !isfinite(number) || number < low || number > high) {
        return false;
    }
    *value = number;
    return true;
}

bool bench_whole(const char *text, double low, double high, int64_t *value)
{
    char *end = NULL;
    const char *const digits = (*text == '-' || *text == '+') ? text + 1 : text;
    const bool hexadecimal = digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X');
    if (!isdigit((unsigned char)*digits)) {
        return false;
    }
    errno = 0;
    const long long number = strtoll(text, &end, hexadecimal ? 16 : 10);
    if (errno != 0 || *end != '\0' || (double)number < low || (double)number > high) {
        return false;
    }
    *value = number;
    return true;
}

int bench_choice(const char *text, const char *words)
{
    const size_t length = strlen(text);
    int place = 0;
    for (const char *word = words; word != NULL; place++) {
        const char *const bar = strchr(word, '|');
        const size_t size = (bar != NULL) ? (size_t)(bar - word) : strlen(word);
        if (size == length && strncmp(word, text, size) == 0) {
            return place;
        }
        word = (bar != NULL) ? bar + 1 : NULL;
    }
    return -1;
}
