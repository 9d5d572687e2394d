#include "world/profile_lines.h"

#include <stdlib.h>
#include <string.h>

#define INDEX_WORDS "an index is hexadecimal, such as 0x6040"

/* 0x and up to four hexadecimal digits. Without 0x what was taken before it was asked for, where it has one reading:
 * four digits in a mapping, where they never were decimal; elsewhere a decimal number of five. */
static bool read_index(const char *text, bool mapped, uint16_t *index)
{
    const bool marked = text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    const char *const digits = marked ? text + 2 : text;
    const size_t length = strlen(digits);
    int64_t value = 0;
    if (!marked && !mapped) {
        const bool whole = length == 5U && bench_whole(text, 10000, 65535, &value);
        *index = (uint16_t)value;
        return whole;
    }
    if (length == 0U || length > 4U || (!marked && length != 4U) ||
        strspn(digits, "0123456789abcdefABCDEF") != length) {
        return false;
    }
    *index = (uint16_t)strtoul(digits, NULL, 16);
    return true;
}

/* INDEX:SUBINDEX:BITS */
static bool read_object(char *text, uint32_t *object)
{
    char *const first = strchr(text, ':');
    char *const second = (first != NULL) ? strchr(first + 1, ':') : NULL;
    uint16_t index = 0;
    int64_t subindex = 0;
    int64_t bits = 0;
    if (second == NULL) {
        return false;
    }
    *first = '\0';
    *second = '\0';
    if (!read_index(text, true, &index) || !bench_whole(first + 1, 0, 255, &subindex) ||
        !bench_whole(second + 1, 1, 64, &bits)) {
        return false;
    }
    *object = TUMBLE_MAP((uint32_t)index, (uint32_t)subindex, (uint32_t)bits);
    return true;
}

static const char *read_pdo(const bench_words_t *words, bool transmit, tumble_drive_pdo_t *pdo)
{
    static const char WRONG[] =
        "a PDO is its number (0 to 255), COB-ID, for a transmit PDO inhibit time (100 us) and "
        "event timer (ms), and up to eight objects INDEX:SUBINDEX:BITS; " INDEX_WORDS;
    const unsigned first = transmit ? 4U : 2U;
    int64_t value[4] = {0};
    if (words->count <= first || words->count > first + TUMBLE_MAX_MAPPED) {
        return WRONG;
    }
    static const double MOST[4] = {255, TUMBLE_CAN_MAX_ID, 65535, 65535};
    for (unsigned i = 0; i < first; i++) {
        if (!bench_whole(words->word[i], 0, MOST[i], &value[i])) {
            return WRONG;
        }
    }
    pdo->number = (uint8_t)value[0];
    pdo->setup = (tumble_pdo_setup_t){.cob_id = (uint32_t)value[1],
                                      .type = TUMBLE_PDO_EVENT_PROFILE,
                                      .count = (uint8_t)(words->count - first),
                                      .inhibit_100us = (uint16_t)value[2],
                                      .event_ms = (uint16_t)value[3]};
    for (unsigned i = first; i < words->count; i++) {
        if (!read_object(words->word[i], &pdo->setup.map[i - first])) {
            return WRONG;
        }
    }
    return NULL;
}

static const char *read_receive_pdo(bench_config_t *config, const bench_words_t *words)
{
    if (config->profile.receive_count == TUMBLE_MAX_RECEIVE_PDOS) {
        return "more PDOs than fit";
    }
    return read_pdo(words, false, &config->lists.receive[config->profile.receive_count++]);
}

static const char *read_transmit_pdo(bench_config_t *config, const bench_words_t *words)
{
    if (config->profile.transmit_count == TUMBLE_MAX_TRANSMIT_PDOS) {
        return "more PDOs than fit";
    }
    return read_pdo(words, true, &config->lists.transmit[config->profile.transmit_count++]);
}

static const char *read_write(bench_config_t *config, const bench_words_t *words)
{
    static const double LEAST[3] = {0, 1, -2147483648.0};
    static const double MOST[3] = {255, 4, 4294967295.0};
    uint16_t index = 0;
    int64_t value[3] = {0};
    bool good = words->count == 4U && config->profile.write_count < BENCH_MAX_WRITES &&
                read_index(words->word[0], false, &index);
    for (unsigned i = 0; good && i < 3U; i++) {
        good = bench_whole(words->word[i + 1U], LEAST[i], MOST[i], &value[i]);
    }
    if (!good) {
        return "a write is index, subindex, size (1, 2, 4) and value, at most 16 of them; " INDEX_WORDS;
    }
    config->lists.writes[config->profile.write_count++] =
        (tumble_object_write_t){index, (uint8_t)value[0], (uint8_t)value[1], (uint32_t)value[2]};
    return NULL;
}

/* drive.lacks */

static const char *read_lacks(bench_config_t *config, const bench_words_t *words)
{
    sim_drive_config_t *const drive = &config->scenario.drive;
    for (unsigned i = 0; i < words->count; i++) {
        if (drive->lack_count == SIM_MAX_LACKS ||
            !read_index(words->word[i], false, &drive->lacks[drive->lack_count])) {
            return "drive.lacks names objects, at most 16 of them; " INDEX_WORDS;
        }
        drive->lack_count++;
    }
    return NULL;
}

const char *bench_take_profile_line(bench_config_t *config, const char *key, const bench_words_t *words)
{
    switch (bench_choice(key, "profile.receive_pdo|profile.transmit_pdo|profile.write|drive.lacks")) {
    case 0:
        return read_receive_pdo(config, words);
    case 1:
        return read_transmit_pdo(config, words);
    case 2:
        return read_write(config, words);
    case 3:
        return read_lacks(config, words);
    default:
        return "";
    }
}
