#include "bench/config_file.h"

#include "bench/config_keys.h"
#include "bench/config_lines.h"
#include "bench/config_text.h"

#include <ctype.h>
#include <stdarg.h>
#include <string.h>

#define MAX_LINE 1024
#define MAX_KEYS 160

static bool complain(bench_mistake_t *mistake, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(mistake->what, sizeof mistake->what, format, arguments);
    va_end(arguments);
    return false;
}

static size_t size_of(bench_type_t type)
{
    static const size_t SIZES[] = {sizeof(double), sizeof(float),   sizeof(uint8_t), sizeof(uint16_t), sizeof(uint32_t),
                                   sizeof(int8_t), sizeof(int32_t), sizeof(bool),    sizeof(int),     1};
    return SIZES[type];
}

static void store_whole(bench_type_t type, void *at, int64_t value)
{
    switch (type) {
    case BENCH_U8:
        *(uint8_t *)at = (uint8_t)value;
        break;
    case BENCH_U16:
        *(uint16_t *)at = (uint16_t)value;
        break;
    case BENCH_U32:
        *(uint32_t *)at = (uint32_t)value;
        break;
    case BENCH_I8:
        *(int8_t *)at = (int8_t)value;
        break;
    default:
        *(int32_t *)at = (int32_t)value;
        break;
    }
}

static bool store(const bench_key_t *key, void *at, const char *text)
{
    double number = 0.0;
    int64_t whole = 0;
    int choice = 0;
    switch (key->type) {
    case BENCH_DOUBLE:
        return bench_number(text, key->low, key->high, at);
    case BENCH_FLOAT:
        if (!bench_number(text, key->low, key->high, &number)) {
            return false;
        }
        *(float *)at = (float)number;
        return true;
    case BENCH_BOOL:
        choice = bench_choice(text, "no|yes");
        *(bool *)at = choice == 1;
        return choice >= 0;
    case BENCH_CHOICE:
        choice = bench_choice(text, key->about);
        (void)memcpy(at, &choice, sizeof choice);
        return choice >= 0;
    case BENCH_TEXT:
        return (strlen(text) <= (size_t)key->high) && (strcpy(at, text) != NULL);
    default:
        if (!bench_whole(text, key->low, key->high, &whole)) {
            return false;
        }
        store_whole(key->type, at, whole);
        return true;
    }
}

/* The range of a key's values, for people. */
static void describe(const bench_key_t *key, char *text, size_t size)
{
    if (key->type == BENCH_CHOICE) {
        (void)snprintf(text, size, "one of %s", key->about);
    } else if (key->type == BENCH_BOOL) {
        (void)snprintf(text, size, "no or yes");
    } else if (key->type == BENCH_TEXT) {
        (void)snprintf(text, size, "a word of at most %.0f characters", key->high);
    } else {
        const bool whole = key->type != BENCH_DOUBLE && key->type != BENCH_FLOAT;
        (void)snprintf(text, size, "%u %snumber%s from %.10g to %.10g", key->count, whole ? "whole " : "",
                       (key->count == 1U) ? "" : "s", key->low, key->high);
    }
}

static bool store_key(bench_config_t *config, const bench_key_t *key, const bench_words_t *words,
                      bench_mistake_t *mistake)
{
    bool good = words->count == key->count;
    for (unsigned i = 0; good && i < key->count; i++) {
        good = store(key, (char *)config + key->offset + i * size_of(key->type), words->word[i]);
    }
    if (!good) {
        char range[100];
        describe(key, range, sizeof range);
        return complain(mistake, "%s must be %s", key->name, range);
    }
    return true;
}

static bool take_key(bench_config_t *config, const char *name, const bench_words_t *words, bool seen[MAX_KEYS],
                     bench_mistake_t *mistake)
{
    for (size_t i = 0; i < bench_config_key_count; i++) {
        const bench_key_t *const key = &bench_config_keys[i];
        if (strcmp(name, key->name) == 0) {
            if (seen[i]) {
                return complain(mistake, "%s is given twice", name);
            }
            seen[i] = true;
            return store_key(config, key, words, mistake);
        }
    }
    return complain(mistake, "no such key: %.60s", name);
}

/* Without blanks at either end. */
static char *trim(char *text)
{
    while (isspace((unsigned char)*text)) {
        text++;
    }
    size_t length = strlen(text);
    while (length > 0U && isspace((unsigned char)text[length - 1U])) {
        text[--length] = '\0';
    }
    return text;
}

static bool take_line(bench_config_t *config, char *line, bool seen[MAX_KEYS], bench_mistake_t *mistake)
{
    char *const text = trim(line);
    if (*text == '\0' || *text == '#') {
        return true;
    }
    char *const equals = strchr(text, '=');
    if (equals == NULL) {
        return complain(mistake, "neither a comment nor key = value");
    }
    *equals = '\0';
    char *const key = trim(text);
    bench_words_t words;
    if (!bench_cut_words(trim(equals + 1), &words)) {
        return complain(mistake, "%.60s has more than %d values", key, BENCH_MAX_WORDS);
    }
    const char *const wrong = bench_config_line(config, key, &words);
    if (wrong == NULL) {
        return true;
    }
    return (*wrong != '\0') ? complain(mistake, "%s", wrong) : take_key(config, key, &words, seen, mistake);
}

static bool is_given(const bool seen[MAX_KEYS], const char *name)
{
    for (size_t i = 0; i < bench_config_key_count; i++) {
        if (strcmp(bench_config_keys[i].name, name) == 0) {
            return seen[i];
        }
    }
    return false;
}

/* What no single line can show. */
static bool check_whole(bench_config_t *config, const bool seen[MAX_KEYS], bench_mistake_t *mistake)
{
    sim_scenario_t *const scenario = &config->scenario;
    const uint32_t rate = scenario->bits_per_second;
    mistake->line = 0;
    if (is_given(seen, "block.k") != is_given(seen, "block.u0")) {
        return complain(mistake, "block.k and block.u0 go together");
    }
    scenario->block.given = is_given(seen, "block.k");
    if (scenario->block.scale_v_per_g == 0.0) {
        return complain(mistake, "block.scale_v_per_g must not be 0");
    }
    if (scenario->drive.sign == 0) {
        return complain(mistake, "drive.sign must be 1 or -1");
    }
    if (rate != 125000U && rate != 250000U && rate != 500000U && rate != 1000000U) {
        return complain(mistake, "bus.bits_per_second must be 125000, 250000, 500000 or 1000000");
    }
    return true;
}

bool bench_config_read(bench_config_t *config, FILE *file, bench_mistake_t *mistake)
{
    bool seen[MAX_KEYS] = {false};
    char line[MAX_LINE];
    for (mistake->line = 1; fgets(line, sizeof line, file) != NULL; mistake->line++) {
        if (strchr(line, '\n') == NULL && feof(file) == 0) {
            return complain(mistake, "longer than %d characters, or no text", MAX_LINE - 2);
        }
        if (!take_line(config, line, seen, mistake)) {
            return false;
        }
    }
    if (ferror(file) != 0) {
        return complain(mistake, "cannot be read further");
    }
    return check_whole(config, seen, mistake);
}

void bench_config_print_keys(FILE *out)
{
    (void)fprintf(out, "Scenario files: one `key = value` a line, # comments.\n\n");
    for (size_t i = 0; i < bench_config_key_count; i++) {
        const bench_key_t *const key = &bench_config_keys[i];
        char range[100];
        describe(key, range, sizeof range);
        (void)fprintf(out, "%-34s %s%s%s\n", key->name, range, (key->type == BENCH_CHOICE) ? "" : "; ",
                      (key->type == BENCH_CHOICE) ? "" : key->about);
    }
    (void)fprintf(out, "\nLines that may repeat:\n"
                       "mounting = NUMBER  TILT_DEG SINE COSINE  M11 M12 M13 M21 M22 M23 M31 M32 M33\n"
                       "position = MOUNTING NUMBER fit|check  ANGLE_DEG SINE COSINE\n"
                       "profile.receive_pdo = NUMBER COB_ID INDEX:SUBINDEX:BITS ...\n"
                       "profile.transmit_pdo = NUMBER COB_ID INHIBIT_100US EVENT_MS INDEX:SUBINDEX:BITS ...\n"
                       "profile.write = INDEX SUBINDEX SIZE VALUE\n"
                       "fault = KIND at=MOUNTING.POSITION [phase=mount|home|move|settle|average] | time=SECONDS\n"
                       "        [delay=S] [duration=S] [times=N] [channels=xyz] [value=X] [count=N] [id=N] [mask=N]\n"
                       "        [probability=P]\n\nKinds of faults:\n");
#define PRINT_FAULT(name, word, sentence) (void)fprintf(out, "%-20s %s\n", word, sentence);
    SIM_FAULT_LIST(PRINT_FAULT)
#undef PRINT_FAULT
}
