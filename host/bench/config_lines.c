#include "bench/config_lines.h"

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

/* profile.receive_pdo, profile.transmit_pdo, profile.write */

/* INDEX:SUBINDEX:BITS, the index hexadecimal. */
static bool read_object(char *text, uint32_t *object)
{
    static const char DIGITS[] = "0123456789abcdef";
    char *const first = strchr(text, ':');
    char *const second = (first != NULL) ? strchr(first + 1, ':') : NULL;
    int64_t subindex = 0;
    int64_t bits = 0;
    if (second == NULL || first - text != 4) {
        return false;
    }
    *first = '\0';
    *second = '\0';
    uint32_t index = 0;
    for (const char *c = text; *c != '\0'; c++) {
        const char *const digit = strchr(DIGITS, (*c >= 'A' && *c <= 'F') ? *c - 'A' + 'a' : *c);
        if (digit == NULL) {
            return false;
        }
        index = index << 4 | (uint32_t)(digit - DIGITS);
    }
    if (!bench_whole(first + 1, 0, 255, &subindex) || !bench_whole(second + 1, 1, 64, &bits)) {
        return false;
    }
    *object = TUMBLE_MAP(index, (uint32_t)subindex, (uint32_t)bits);
    return true;
}

static const char *read_pdo(const bench_words_t *words, bool transmit, tumble_drive_pdo_t *pdo)
{
    static const char WRONG[] = "a PDO is its number (0 to 511), COB-ID, for a transmit PDO inhibit time (100 us) and "
                                "event timer (ms), and up to eight objects INDEX:SUBINDEX:BITS";
    const unsigned first = transmit ? 4U : 2U;
    int64_t value[4] = {0};
    if (words->count <= first || words->count > first + TUMBLE_MAX_MAPPED) {
        return WRONG;
    }
    static const double MOST[4] = {511, TUMBLE_CAN_MAX_ID, 65535, 65535};
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
    static const double MOST[4] = {65535, 255, 4, 4294967295.0};
    int64_t value[4] = {0};
    bool good = words->count == 4U && config->profile.write_count < BENCH_MAX_WRITES;
    for (unsigned i = 0; good && i < 4U; i++) {
        good = bench_whole(words->word[i], (i < 2U) ? 0 : (i == 2U) ? 1 : -2147483648.0, MOST[i], &value[i]);
    }
    if (!good) {
        return "a write is index, subindex, size (1, 2, 4) and value; at most 16 of them";
    }
    config->lists.writes[config->profile.write_count++] =
        (tumble_object_write_t){(uint16_t)value[0], (uint8_t)value[1], (uint8_t)value[2], (uint32_t)value[3]};
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

static bool read_whole_field(const char *text, double most, uint32_t *field)
{
    int64_t value = 0;
    const bool good = bench_whole(text, 0, most, &value);
    *field = (uint32_t)value;
    return good;
}

/* One `name=text` of a fault. */
static bool read_fault_field(sim_fault_t *fault, const char *name, char *text)
{
    uint32_t whole = 0;
    switch (bench_choice(name, "at|phase|time|delay|duration|times|channels|value|count|id|mask|probability")) {
    case 0:
        return read_place(text, fault);
    case 1: {
        const int phase = bench_choice(text, "mount|home|move|settle|average");
        fault->phase = (sim_phase_t)phase;
        return phase >= 0;
    }
    case 2:
        fault->at_time = true;
        return bench_number(text, 0.0, BIG, &fault->time_s);
    case 3:
        return bench_number(text, 0.0, BIG, &fault->delay_s);
    case 4:
        return bench_number(text, 0.0, BIG, &fault->duration_s);
    case 5:
        return read_whole_field(text, 4294967295.0, &fault->times);
    case 6:
        return read_channels(text, &fault->channels);
    case 7:
        return bench_number(text, -BIG, BIG, &fault->value);
    case 8:
        return read_whole_field(text, 4294967295.0, &fault->count);
    case 9:
    case 10: {
        const bool good = read_whole_field(text, TUMBLE_CAN_MAX_ID, &whole);
        *((name[0] == 'i') ? &fault->id : &fault->mask) = (uint16_t)whole;
        return good;
    }
    case 11:
        return bench_number(text, 0.0, 1.0, &fault->probability);
    default:
        return false;
    }
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
        return "no such fault; tumble-bench --keys lists them";
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

const char *bench_config_line(bench_config_t *config, const char *key, const bench_words_t *words)
{
    switch (bench_choice(key, "mounting|position|fault|profile.receive_pdo|profile.transmit_pdo|profile.write")) {
    case 0:
        return read_mounting(config, words);
    case 1:
        return read_position(config, words);
    case 2:
        return read_fault(config, words);
    case 3:
        return read_receive_pdo(config, words);
    case 4:
        return read_transmit_pdo(config, words);
    case 5:
        return read_write(config, words);
    default:
        return "";
    }
}
