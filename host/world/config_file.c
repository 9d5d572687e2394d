#include "world/config_file.h"

#include "world/config_keys.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_ANGLE_DEG 3600.0
#define BIG 1e9

/* mounting, position */

static void begin_schedule(sim_scenario_t *scenario)
{
    if (scenario->schedule.mountings == tumble_schedule_paper.mountings) {
        scenario->schedule = (tumble_schedule_t){scenario->mountings, scenario->positions, 0, 0};
    }
}

static bool read_angle(char *const word[3], tumble_angle_t *angle)
{
    return bench_number(word[0], -MAX_ANGLE_DEG, MAX_ANGLE_DEG, &angle->deg) &&
           bench_number(word[1], -1.0, 1.0, &angle->sine) && bench_number(word[2], -1.0, 1.0, &angle->cosine);
}

static const char *read_mounting(bench_config_t *config, const bench_words_t *words)
{
    sim_scenario_t *const scenario = &config->scenario;
    begin_schedule(scenario);
    if (scenario->schedule.mounting_count == TUMBLE_MAX_MOUNTINGS) {
        return "more mountings than fit";
    }
    tumble_mounting_t *const mounting = &scenario->mountings[scenario->schedule.mounting_count];
    int64_t number = 0;
    bool good = words->count == 13U && bench_whole(words->word[0], 1, 255, &number) &&
                read_angle(&words->word[1], &mounting->tilt);
    for (unsigned i = 0; good && i < 9U; i++) {
        good = bench_number(words->word[4U + i], -1.0, 1.0, &mounting->matrix[i / 3U][i % 3U]);
    }
    mounting->number = (uint8_t)number;
    scenario->schedule.mounting_count++;
    return good ? NULL : "a mounting is a number 1 to 255, tilt (degrees, sine, cosine) and nine elements within 1";
}

static const char *read_position(bench_config_t *config, const bench_words_t *words)
{
    sim_scenario_t *const scenario = &config->scenario;
    begin_schedule(scenario);
    if (scenario->schedule.position_count == TUMBLE_MAX_POSITIONS) {
        return "more positions than fit";
    }
    tumble_position_t *const position = &scenario->positions[scenario->schedule.position_count];
    int64_t mounting = 0;
    int64_t number = 0;
    const bool numbers = words->count == 6U && bench_whole(words->word[0], 1, 255, &mounting) &&
                         bench_whole(words->word[1], 1, 255, &number);
    const int use = numbers ? bench_choice(words->word[2], "fit|check") : -1;
    if (use < 0 || !read_angle(&words->word[3], &position->angle)) {
        return "a position is mounting and number (1 to 255), fit or check, and its angle (degrees, sine, cosine)";
    }
    position->mounting = (uint8_t)mounting;
    position->number = (uint8_t)number;
    position->use = (tumble_use_t)use;
    scenario->schedule.position_count++;
    return NULL;
}

/* fault */

static bool read_channels(const char *text, uint8_t *channels)
{
    *channels = 0;
    for (; *text != '\0'; text++) {
        if (*text < 'x' || *text > 'z') {
            return false;
        }
        *channels = (uint8_t)(*channels | 1U << (*text - 'x'));
    }
    return *channels != 0U;
}

static bool read_place(char *text, sim_fault_t *fault)
{
    char *const dot = strchr(text, '.');
    int64_t mounting = 0;
    int64_t position = 0;
    if (dot == NULL) {
        return false;
    }
    *dot = '\0';
    if (!bench_whole(text, 1, 255, &mounting) || !bench_whole(dot + 1, 1, 255, &position)) {
        return false;
    }
    fault->mounting = (uint8_t)mounting;
    fault->position = (uint8_t)position;
    return true;
}

/* The fields that are plain values. */
static const bench_key_t FAULT_FIELDS[] = {
    {"phase", BENCH_ENUM, 1, offsetof(sim_fault_t, phase), 0, 0, "mount|home|move|settle|average"},
    {"time", BENCH_F64, 1, offsetof(sim_fault_t, time_s), 0, BIG, "s"},
    {"delay", BENCH_F64, 1, offsetof(sim_fault_t, delay_s), 0, BIG, "s"},
    {"duration", BENCH_F64, 1, offsetof(sim_fault_t, duration_s), 0, BIG, "s"},
    {"times", BENCH_U32, 1, offsetof(sim_fault_t, times), 0, UINT32_MAX, ""},
    {"value", BENCH_F64, 1, offsetof(sim_fault_t, value), -BIG, BIG, ""},
    {"count", BENCH_U32, 1, offsetof(sim_fault_t, count), 0, UINT32_MAX, ""},
    {"id", BENCH_U16, 1, offsetof(sim_fault_t, id), 0, TUMBLE_CAN_MAX_ID, ""},
    {"mask", BENCH_U16, 1, offsetof(sim_fault_t, mask), 0, TUMBLE_CAN_MAX_ID, ""},
    {"probability", BENCH_F64, 1, offsetof(sim_fault_t, probability), 0, 1, ""},
};

/* One `name=text` of a fault. */
static bool read_fault_field(sim_fault_t *fault, const char *name, char *text)
{
    if (strcmp(name, "at") == 0) {
        return read_place(text, fault);
    }
    if (strcmp(name, "channels") == 0) {
        return read_channels(text, &fault->channels);
    }
    fault->at_time = fault->at_time || strcmp(name, "time") == 0;
    for (size_t i = 0; i < sizeof FAULT_FIELDS / sizeof FAULT_FIELDS[0]; i++) {
        if (strcmp(name, FAULT_FIELDS[i].name) == 0) {
            return bench_store_key(&FAULT_FIELDS[i], fault, &text, 1);
        }
    }
    return false;
}

static const char *read_fault(bench_config_t *config, const bench_words_t *words)
{
#define FAULT_WORD(name, word, sentence) "|" word
    static const char KINDS[] = SIM_FAULT_LIST(FAULT_WORD);
#undef FAULT_WORD
    sim_scenario_t *const scenario = &config->scenario;
    sim_fault_t fault = {.phase = SIM_PHASE_AVERAGE,
                         .times = 1,
                         .channels = 1,
                         .count = UINT32_MAX,
                         .probability = 1.0,
                         .mask = TUMBLE_CAN_MAX_ID};
    if (scenario->fault_count == SIM_MAX_FAULTS) {
        return "more faults than fit";
    }
    const int kind = (words->count > 0U) ? bench_choice(words->word[0], KINDS + 1) : -1;
    if (kind < 0) {
        return "no such fault; tumble bench --keys lists them";
    }
    fault.kind = (sim_fault_kind_t)kind;
    for (unsigned i = 1; i < words->count; i++) {
        char *const equals = strchr(words->word[i], '=');
        if (equals == NULL) {
            return "a fault is its kind and fields such as at=1.3";
        }
        *equals = '\0';
        if (!read_fault_field(&fault, words->word[i], equals + 1)) {
            return "a field of the fault is unknown or out of range";
        }
    }
    if (fault.at_time == (fault.mounting != 0U)) {
        return "a fault needs either at=MOUNTING.POSITION or time=SECONDS";
    }
    scenario->faults[scenario->fault_count++] = fault;
    return NULL;
}

/* The drive: its process data and objects. */

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

static const char *take_profile_line(bench_config_t *config, const char *key, const bench_words_t *words)
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

/* Take such a line. Null: taken. "": not a key of these. Else what is wrong with it. */
static const char *take_repeated(bench_config_t *config, const char *key, const bench_words_t *words)
{
    switch (bench_choice(key, "mounting|position|fault")) {
    case 0:
        return read_mounting(config, words);
    case 1:
        return read_position(config, words);
    case 2:
        return read_fault(config, words);
    default:
        return take_profile_line(config, key, words);
    }
}

/* All lines. */

static bool complain(bench_mistake_t *mistake, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(mistake->what, sizeof mistake->what, format, arguments);
    va_end(arguments);
    return false;
}

static bool take_key(bench_config_t *config, const char *name, const bench_words_t *words, bench_seen_t *seen,
                     bench_mistake_t *mistake)
{
    const bench_key_t *const key = bench_find_key(name);
    if (key == NULL) {
        return complain(mistake, "no such key: %.60s", name);
    }
    if (seen->key[key - bench_config_keys]) {
        return complain(mistake, "%s is given twice", name);
    }
    seen->key[key - bench_config_keys] = true;
    if (!bench_store_key(key, config, words->word, words->count)) {
        char range[100];
        bench_describe_key(key, range, sizeof range);
        return complain(mistake, "%s must be %s", key->name, range);
    }
    return true;
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

bool bench_config_take(bench_config_t *config, char *line, bench_seen_t *seen, bench_mistake_t *mistake)
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
    const char *const wrong = take_repeated(config, key, &words);
    if (wrong == NULL) {
        return true;
    }
    return (*wrong != '\0') ? complain(mistake, "%s", wrong) : take_key(config, key, &words, seen, mistake);
}

static bool is_given(const bench_seen_t *seen, const char *name)
{
    return seen->key[bench_find_key(name) - bench_config_keys];
}

bool bench_config_check(bench_config_t *config, const bench_seen_t *seen, bench_mistake_t *mistake)
{
    sim_scenario_t *const scenario = &config->scenario;
    const uint32_t rate = scenario->bits_per_second;
    mistake->line = 0;
    if (is_given(seen, "block.k") != is_given(seen, "block.u0")) {
        return complain(mistake, "block.k and block.u0 go together");
    }
    scenario->block.given = is_given(seen, "block.k");
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        if (scenario->block.scale_v_per_g[i] == 0.0) {
            return complain(mistake, "block.scale_v_per_g must not be 0");
        }
    }
    if (scenario->drive.sign == 0) {
        return complain(mistake, "drive.sign must be 1 or -1");
    }
    if (rate != 125000U && rate != 250000U && rate != 500000U && rate != 1000000U) {
        return complain(mistake, "bus.bits_per_second must be 125000, 250000, 500000 or 1000000");
    }
    return true;
}
