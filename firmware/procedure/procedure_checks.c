#include "procedure/procedure_internal.h"

#include "core/accumulator.h"
#include "core/arith.h"
#include "core/one_copy.h"
#include "core/vector.h"
#include "procedure/config_fields.h"

#include <stddef.h>
#include <string.h>

#define MAX_TURNS 20
#define TURN_DEG 360.0

/* How far gravity over the nominal scale may lie from where it should, in g: at the first position of a mounting the
 * bias is in it (some 0.3 g a channel), and two of the paper's attitudes lie sqrt 2 apart; between two positions of
 * a mounting the bias is gone, and what is left is the error of the nominal scale over 2 g at most. */
#define FIRST_LIMIT_G 0.7
#define CHANGE_LIMIT_G 0.35

#define LIKELIEST_VALUE 0.3989422804014327 /* 1 / sqrt(2 pi): of a normal distribution, per standard deviation */
#define EQUAL_BY_CHANCE 1e-5
#define MOST_EQUAL_SAMPLES 14U /* with noise of a count */

/* The configuration: which signs a number may have, and where it stands. Column `signs` of the table of fields: of a real
 * number it becomes a row, of a whole one a condition. */

enum { NEGATIVE = 1, ZERO = 2, POSITIVE = 4, NOT_ZERO = NEGATIVE | POSITIVE, NOT_NEGATIVE = ZERO | POSITIVE, ANY = 7 };

typedef struct {
    uint8_t offset;
    uint8_t signs;
} number_row_t;

#define ROW(type, member, standard, signs, result, part, key, low, high, about) type##_ROW(member, signs)
#define F64_ROW(member, signs) {(uint8_t)offsetof(tumble_procedure_config_t, member), (signs)},
#define U32_ROW(member, signs)
#define U16_ROW(member, signs)
#define U8_ROW(member, signs)
#define I8_ROW(member, signs)
#define ENUM_ROW(member, signs)

#define WHOLE(type, member, standard, signs, result, part, key, low, high, about) type##_WHOLE(signs, member)
#define F64_WHOLE(signs, member)
#define U32_WHOLE(signs, member) signs##_WHOLE(member)
#define U16_WHOLE(signs, member) signs##_WHOLE(member)
#define U8_WHOLE(signs, member) signs##_WHOLE(member)
#define I8_WHOLE(signs, member) signs##_WHOLE(member)
#define ENUM_WHOLE(signs, member)
#define ANY_WHOLE(member)
#define POSITIVE_WHOLE(member) &&(config->member > 0)
#define NOT_NEGATIVE_WHOLE(member) &&(config->member >= 0)

/* Of a finite number. */
static unsigned sign_of(double x)
{
    return tumble_is_positive(x) ? POSITIVE : tumble_is_positive(-x) ? NEGATIVE : ZERO;
}

static bool numbers_are_valid(const tumble_procedure_config_t *config)
{
    static const number_row_t number_rows[] = {TUMBLE_PROCEDURE_FIELDS(ROW)};
    bool valid = true;
    for (size_t i = 0; i < (sizeof number_rows / sizeof number_rows[0]); i++) {
        double x;
        (void)memcpy(&x, (const unsigned char *)config + number_rows[i].offset, sizeof x);
        valid = valid && tumble_is_finite(x) && ((sign_of(x) & number_rows[i].signs) != 0U);
    }
    return valid && tumble_exceeds(config->cable_max_deg, config->cable_min_deg);
}

static bool whole_numbers_are_valid(const tumble_procedure_config_t *config)
{
    return (config->settle_timeout_ms > config->settle_ms) && (config->settle_ms < TUMBLE_TIMESTAMP_PERIOD_MS)
                                                                  TUMBLE_PROCEDURE_FIELDS(WHOLE);
}

/* So many equal samples that noise makes them by chance in one of 100,000 at most. With noise of s counts no
 * value is likelier than 1 / (s sqrt(2 pi)), so n equal samples have the probability 0.399^(n-1) / s^(n-1) at most. Noise
 * that is not declared, or under a count, counts as one. */
static uint32_t samples_that_tell(const tumble_averaging_config_t *averaging)
{
    const double beyond_one = (double)averaging->noise_counts - 1.0;
    const double noise_counts = 1.0 + (tumble_is_positive(beyond_one) ? beyond_one : 0.0);
    double chance = 1.0;
    bool tells = false;
    uint32_t samples;
    for (samples = 1; !tells && (samples < MOST_EQUAL_SAMPLES); samples++) {
        chance *= LIKELIEST_VALUE / noise_counts;
        tells = tumble_within(chance, EQUAL_BY_CHANCE);
    }
    return samples;
}

/* Do the positions have samples enough to show that a channel is stuck, if that is asked? */
static bool stuck_shows(const tumble_procedure_config_t *config)
{
    const tumble_averaging_config_t *averaging = config->averaging;
    const uint32_t least = tumble_is_positive(config->error_budget_v) ? averaging->min_samples : config->samples;
    return (least >= averaging->stuck_run) || (least >= samples_that_tell(averaging));
}

/* Which estimators need what, a bit for each. */
enum {
#define NOBODY(number, name, needs)
#define BIT(number, name, needs, estimate, uncertainty)                                                                \
    | ((TUMBLE_NEEDS_##needs == TUMBLE_NEEDS_HARMONIC) ? (1 << TUMBLE_ESTIMATE_##number) : 0)
    NEED_HARMONIC = 0 TUMBLE_ESTIMATOR_LIST(BIT, NOBODY),
#undef BIT
#define BIT(number, name, needs, estimate, uncertainty)                                                                \
    | ((TUMBLE_NEEDS_##needs == TUMBLE_NEEDS_RANK) ? (1 << TUMBLE_ESTIMATE_##number) : 0)
    NEED_RANK = 0 TUMBLE_ESTIMATOR_LIST(BIT, NOBODY)
};

TUMBLE_ONE_COPY const tumble_lent_t *tumble_procedure_lent(const tumble_procedure_config_t *config)
{
    const tumble_lent_t *lent = config->lent;
    while ((lent != NULL) && (lent->estimator != config->estimate)) {
        lent = lent->next;
    }
    return lent;
}

static bool is_one_of(const tumble_procedure_config_t *config, unsigned estimators)
{
    return ((estimators >> (unsigned)config->estimate) & 1U) != 0U;
}

static bool is_valid(const tumble_procedure_config_t *config, const tumble_lent_t *lent)
{
    return (config->schedule != NULL) && (config->averaging != NULL) &&
           ((unsigned)config->estimate < (unsigned)TUMBLE_ESTIMATE_COUNT) &&
           (is_one_of(config, NEED_HARMONIC | NEED_RANK) || (lent != NULL)) &&
           ((int64_t)config->samples <= TUMBLE_MAX_SAMPLES) && (config->samples >= config->averaging->min_samples) &&
           numbers_are_valid(config) && whole_numbers_are_valid(config) && stuck_shows(config);
}

static tumble_status_t examine_schedule(const tumble_procedure_config_t *config)
{
    tumble_status_t status = tumble_schedule_validate(config->schedule, NULL);
    if ((status == TUMBLE_OK) && is_one_of(config, NEED_RANK)) {
        status = tumble_schedule_identify(config->schedule, NULL, NULL);
    } else if ((status == TUMBLE_OK) && is_one_of(config, NEED_HARMONIC)) {
        tumble_harmonic_map_t map;
        status = tumble_schedule_harmonic(config->schedule, NULL, &map, NULL);
    }
    return status;
}

static bool cable_reaches_all(const tumble_procedure_config_t *config)
{
    bool reaches = true;
    for (uint8_t p = 0; p < config->schedule->position_count; p++) {
        double unused;
        reaches = reaches && tumble_choose_turn(config, config->schedule->positions[p].angle.deg, &unused);
    }
    return reaches;
}

TUMBLE_ONE_COPY tumble_status_t tumble_procedure_validate(const tumble_procedure_config_t *config,
                                                          tumble_reason_t *reason)
{
    tumble_reason_t unused;
    tumble_reason_t *why = (reason != NULL) ? reason : &unused;
    const tumble_lent_t *lent = (config != NULL) ? tumble_procedure_lent(config) : NULL;
    *why = TUMBLE_REASON_CONFIGURATION;
    if ((config == NULL) || !is_valid(config, lent)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_status_t status = examine_schedule(config);
    if (status != TUMBLE_OK) {
        *why = TUMBLE_REASON_SCHEDULE;
        return status;
    }
    if (lent != NULL) {
        status = lent->check(lent->source, config->schedule);
    }
    if (status != TUMBLE_OK) {
        *why = (status == TUMBLE_E_NOT_INCLINED) ? TUMBLE_REASON_SCHEDULE : TUMBLE_REASON_CONFIGURATION;
        return status;
    }
    if (!cable_reaches_all(config)) {
        *why = TUMBLE_REASON_CABLE_LIMIT;
        return TUMBLE_E_ARGUMENT;
    }
    *why = TUMBLE_REASON_NONE;
    return TUMBLE_OK;
}

/* The cable. */

static bool is_within_cable(const tumble_procedure_config_t *config, double angle_deg)
{
    return !tumble_exceeds(config->cable_min_deg, angle_deg - config->approach_deg) &&
           !tumble_exceeds(angle_deg, config->cable_max_deg);
}

/* Itself, one turn back, one on, two back, ... */
bool tumble_choose_turn(const tumble_procedure_config_t *config, double scheduled_deg, double *angle_deg)
{
    bool found = false;
    for (int turns = 0; !found && (turns <= MAX_TURNS); turns = (turns < 0) ? -turns : (-turns - 1)) {
        const double deg = scheduled_deg + (TURN_DEG * (double)turns);
        if (is_within_cable(config, deg)) {
            found = true;
            *angle_deg = deg;
        }
    }
    return found;
}

/* The direction of gravity. */

static void subtract(const double a[TUMBLE_CHANNELS], const double b[TUMBLE_CHANNELS],
                     double difference[TUMBLE_CHANNELS])
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        difference[i] = a[i] - b[i];
    }
}

static double distance_g(const double a[TUMBLE_CHANNELS], const double b[TUMBLE_CHANNELS])
{
    double difference[TUMBLE_CHANNELS];
    subtract(a, b, difference);
    return tumble_sqrt(tumble_dot(difference, difference));
}

void tumble_seen_g(const tumble_procedure_t *procedure, uint8_t index, double seen[TUMBLE_CHANNELS])
{
    const tumble_procedure_config_t *config = procedure->config;
    tumble_average_mean(&procedure->averaging.averages[index], seen, config->v_per_count);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double own_v_per_g = config->channel_scale_v_per_g[i];
        seen[i] /= tumble_within(own_v_per_g, 0.0) ? config->nominal_scale_v_per_g : own_v_per_g;
    }
}

/* What the position at `index` would show in another mounting. */
static void attitude_in(const tumble_schedule_t *schedule, uint8_t index, uint8_t mounting_index,
                        double a_g[TUMBLE_CHANNELS])
{
    tumble_position_t position = schedule->positions[index];
    position.mounting = schedule->mountings[mounting_index].number;
    const tumble_schedule_t alone = {schedule->mountings, &position, schedule->mounting_count, 1};
    tumble_schedule_attitude(&alone, 0, a_g);
}

/* What it would show there less what the position at `reference` would; the attitude itself without a reference. */
static void expected_g(const tumble_schedule_t *schedule, uint8_t index, uint8_t reference, uint8_t mounting_index,
                       double expected[TUMBLE_CHANNELS])
{
    attitude_in(schedule, index, mounting_index, expected);
    if (reference != schedule->position_count) {
        double earlier[TUMBLE_CHANNELS];
        attitude_in(schedule, reference, mounting_index, earlier);
        subtract(expected, earlier, expected);
    }
}

static void sort_sizes(const double v[TUMBLE_CHANNELS], double sorted[TUMBLE_CHANNELS])
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double size = tumble_abs(v[i]);
        int place = i;
        while ((place > 0) && tumble_exceeds(sorted[place - 1], size)) {
            sorted[place] = sorted[place - 1];
            place--;
        }
        sorted[place] = size;
    }
}

/* Sizes in order are all that is left when channels may change places and signs. */
static bool is_permuted(const double seen[TUMBLE_CHANNELS], const double expected[TUMBLE_CHANNELS], double limit_g)
{
    double sizes_seen[TUMBLE_CHANNELS];
    double sizes_expected[TUMBLE_CHANNELS];
    sort_sizes(seen, sizes_seen);
    sort_sizes(expected, sizes_expected);
    return tumble_within(distance_g(sizes_seen, sizes_expected), limit_g);
}

static bool fits_another_mounting(const tumble_schedule_t *schedule, uint8_t index, uint8_t reference,
                                  const double seen[TUMBLE_CHANNELS], double limit_g)
{
    bool fits = false;
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        double expected[TUMBLE_CHANNELS];
        expected_g(schedule, index, reference, m, expected);
        fits = fits || tumble_within(distance_g(seen, expected), limit_g);
    }
    return fits;
}

/* A measured position of the same mounting to compare with; position_count if this is its first. */
static uint8_t find_reference(const tumble_procedure_t *procedure, uint8_t index)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    uint8_t p = 0;
    while ((p < schedule->position_count) &&
           ((p == index) || (schedule->positions[p].mounting != schedule->positions[index].mounting) ||
            !tumble_is_measured(procedure, p))) {
        p++;
    }
    return p;
}

tumble_reason_t tumble_check_direction(const tumble_procedure_t *procedure, uint8_t index)
{
    const tumble_schedule_t *schedule = procedure->config->schedule;
    const uint8_t reference = find_reference(procedure, index);
    const bool is_first = (reference == schedule->position_count);
    const double limit_g = is_first ? FIRST_LIMIT_G : CHANGE_LIMIT_G;
    double seen[TUMBLE_CHANNELS];
    tumble_seen_g(procedure, index, seen);
    if (!is_first) {
        double earlier[TUMBLE_CHANNELS];
        tumble_seen_g(procedure, reference, earlier);
        subtract(seen, earlier, seen);
    }
    double expected[TUMBLE_CHANNELS];
    expected_g(schedule, index, reference, tumble_mounting_index(schedule, index), expected);
    if (tumble_within(distance_g(seen, expected), limit_g)) {
        return TUMBLE_REASON_NONE;
    }
    if (fits_another_mounting(schedule, index, reference, seen, limit_g)) {
        return TUMBLE_REASON_WRONG_MOUNTING;
    }
    return (is_first || is_permuted(seen, expected, limit_g)) ? TUMBLE_REASON_SWAPPED_CHANNELS : TUMBLE_REASON_SLIP;
}

/* Closure. */

tumble_reason_t tumble_check_closure(const tumble_procedure_t *procedure, uint8_t index)
{
    const uint8_t mounting = tumble_mounting_index(procedure->config->schedule, index);
    const double closure_g = tumble_procedure_closure_g(procedure, mounting);
    return tumble_exceeds(closure_g, procedure->config->closure_limit_g) ? TUMBLE_REASON_SLIP : TUMBLE_REASON_NONE;
}
