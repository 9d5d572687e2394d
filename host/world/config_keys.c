#include "world/config_keys.h"

#include "navcomp/fields.h"
#include "world/config.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define AT(member) offsetof(bench_config_t, member)
#define STAND(member) AT(scenario.stand.member)
#define BLOCK(member) AT(scenario.block.member)
#define SENSOR(member) AT(scenario.block.sensor.member)
#define TEMPERATURE(member) AT(scenario.block.sensor.temperature.member)
#define DRIVE(member) AT(scenario.drive.member)
#define PERSON(member) AT(scenario.person.member)
#define KEEPING(member) AT(keeping.member)
#define LIMITS(member) AT(keeping.settings.limits.member)

#define BIG 1e9
#define WHOLE_32 4294967295.0

/* What a person may say of a field of the firmware: a row of its table. */
#define PROFILE_KEY(type, member, standard, signs, result, part, key, low, high, about)                                \
    {key, BENCH_##type, 1, AT(profile.member), low, high, about},
#define PROCEDURE_KEY(type, member, standard, signs, result, part, key, low, high, about)                              \
    {key, BENCH_##type, 1, AT(procedure.member), low, high, about},
#define AVERAGING_KEY(type, member, standard, signs, result, part, key, low, high, about)                              \
    {key, BENCH_##type, 1, AT(averaging.member), low, high, about},

_Static_assert(sizeof(sim_law_t) == sizeof(int) && sizeof(tumble_estimate_t) == sizeof(int),
               "a choice is stored as an int");

/* clang-format off */
const bench_key_t bench_config_keys[] = {
    {"stand.axis_tilt_rad", BENCH_F64, 1, STAND(axis_tilt_rad), 0, 1, "rad; limit of alpha1"},
    {"stand.level_rad", BENCH_F64, 1, STAND(level_rad), 0, 1, "rad; limit of alpha2"},
    {"stand.remount_rad", BENCH_F64, 1, STAND(remount_rad), 0, 1, "rad; limit of alpha3"},
    {"stand.angle_rad", BENCH_F64, 1, STAND(angle_rad), 0, 1, "rad; limit of alpha4"},
    {"stand.seat_rad", BENCH_F64, 1, STAND(seat_rad), 0, 1, "rad; limit of theta_h and theta_n of a mounting"},
    {"stand.platform_rad", BENCH_F64, 1, STAND(platform_rad), 0, 1, "rad; limit of theta_h of the platform"},
    {"stand.encoder_rad", BENCH_F64, 1, STAND(encoder_rad), 0, 1, "rad; limit of each number of the encoder's errors"},
    {"stand.drift_v", BENCH_F64, 3, STAND(drift_v), 0, BIG, "V; limit of the drift over the run, by channel"},
    {"stand.limits", BENCH_ENUM, 1, STAND(law), 0, 0, "sigma1|sigma3|uniform"},
    {"stand.remount", BENCH_ENUM, 1, STAND(remount), 0, 0, "independent|common"},

    {"block.k", BENCH_F64, 9, SENSOR(k_v_per_g), -BIG, BIG, "V/g; the true K, row by row; with block.u0"},
    {"block.u0", BENCH_F64, 3, SENSOR(u0_v), -BIG, BIG, "V; the true U0; with block.k"},
    {"block.scale_v_per_g", BENCH_F64, 3, BLOCK(scale_v_per_g), -BIG, BIG,
     "V/g; nominal scale factors, by channel, not 0"},
    {"block.scale_spread", BENCH_F64, 1, BLOCK(scale_spread), 0, 0.5,
     "drawn scale factors lie within this, relative"},
    {"block.misalignment_rad", BENCH_F64, 1, BLOCK(misalignment_rad), 0, 0.5,
     "rad; drawn cross terms lie within this"},
    {"block.bias_v", BENCH_F64, 3, BLOCK(bias_v), 0, BIG, "V; drawn biases lie within this, by channel"},
    {"block.noise_v", BENCH_F64, 3, SENSOR(noise_v), 0, BIG, "V; limit of the noise of one sample, by channel"},
    {"block.noise_correlation", BENCH_F64, 3, SENSOR(noise_correlation), -0.999, 0.999,
     "of the noise of neighbouring samples, by channel; 0: white"},
    {"block.noise_limits", BENCH_ENUM, 1, SENSOR(noise_law), 0, 0, "sigma1|sigma3|uniform"},
    {"block.converter_bits", BENCH_U8, 1, SENSOR(converter_bits), 8, 24, "of the converter"},
    {"block.range_v", BENCH_F64, 1, SENSOR(range_v), 1e-9, BIG, "V; the converter measures up to + and - this"},
    {"block.sample_period_us", BENCH_U32, 1, BLOCK(sample_period_us), 1000, 1e6, "us between samples"},
    {"block.first_sample_us", BENCH_U32, 1, BLOCK(first_sample_us), 0, 1e6, "us from Operational to the first sample"},
    {"block.first_counter", BENCH_U16, 1, BLOCK(first_counter), 0, 65535, "sample counter at power-on"},
    {"block.first_timestamp_ms", BENCH_U16, 1, BLOCK(first_timestamp_ms), 0, 4095, "ms; its clock at power-on"},
    {"block.k2_per_g", BENCH_F64, 3, SENSOR(k2_per_g), -1, 1, "1/g; second order of a channel, relative to its K_ii"},
    {"block.drift_v_per_h", BENCH_F64, 3, SENSOR(drift_v_per_h), -BIG, BIG, "V/h; drift of the outputs"},
    {"block.start_c", BENCH_F64, 1, TEMPERATURE(start_c), -64, 63.5, "degrees C at power-on"},
    {"block.end_c", BENCH_F64, 1, TEMPERATURE(end_c), -64, 63.5, "degrees C in the end"},
    {"block.warm_s", BENCH_F64, 1, TEMPERATURE(tau_s), 0, 1e6,
     "s; time constant of warming up; 0: warm from the start"},
    {"block.reference_c", BENCH_F64, 1, TEMPERATURE(reference_c), -64, 63.5, "degrees C at which K and U0 hold"},
    {"block.bias_v_per_c", BENCH_F64, 3, TEMPERATURE(bias_v_per_c), -BIG, BIG, "V per degree; of the biases"},
    {"block.scale_per_c", BENCH_F64, 3, TEMPERATURE(scale_per_c), -1, 1, "per degree; relative, of the rows of K"},

    {"motion.speed_deg_s", BENCH_F64, 1, DRIVE(speed_deg_s), 1e-3, 1e4,
     "deg/s; the drive's most, and the profile's"},
    {"motion.acceleration_deg_s2", BENCH_F64, 1, DRIVE(acceleration_deg_s2), 1e-3, 1e5, "deg/s2; likewise"},
    {"motion.settling_s", BENCH_F64, 1, DRIVE(axis.settling_s), 0, 1000, "s; until the swing has fallen to 1/1000"},
    {"motion.swing_deg", BENCH_F64, 1, DRIVE(axis.swing_deg), 0, 45, "deg; swing of the table after a stop"},
    {"motion.swing_hz", BENCH_F64, 1, DRIVE(axis.swing_hz), 0, 1000, "Hz; its frequency"},
    {"motion.backlash_deg", BENCH_F64, 1, DRIVE(axis.backlash_deg), 0, 45,
     "deg; play between the motor with its encoder and the table"},

    {"drive.counts_per_turn", BENCH_U32, 1, DRIVE(counts_per_turn), 16, 2147483647.0, "counts per turn of the table"},
    {"drive.sign", BENCH_I32, 1, DRIVE(sign), -1, 1, "1, or -1: counts fall when the table turns upwards"},
    {"drive.wrap_counts", BENCH_U32, 1, DRIVE(wrap_counts), 0, 2147483647.0,
     "positions count modulo this; 0: they do not"},
    {"drive.velocity_per_deg_s", BENCH_F64, 1, DRIVE(velocity_per_deg_s), 1e-3, BIG,
     "its units of velocity per deg/s"},
    {"drive.acceleration_per_deg_s2", BENCH_F64, 1, DRIVE(acceleration_per_deg_s2), 1e-3, BIG, "and per deg/s2"},
    {"drive.power_on_deg", BENCH_F64, 1, DRIVE(power_on_deg), 0, 3600, "deg; wakes up within this of the home mark"},
    {"drive.reaction_us", BENCH_U32, 1, DRIVE(reaction_us), 0, 1e6, "us from a command to its statusword"},
    {"drive.report_us", BENCH_U32, 1, DRIVE(report_us), 100, 1e6, "us; its control cycle while it moves"},
    {"drive.software_limits", BENCH_BOOL, 1, DRIVE(software_limits), 0, 0, "it has 607Dh and keeps to it"},
    {"drive.latches_stale_target", BENCH_BOOL, 1, DRIVE(latches_stale_target), 0, 0,
     "takes the target of the frame before"},
    {"drive.instant_homing", BENCH_BOOL, 1, DRIVE(instant_homing), 0, 0, "at its mark it is home at once"},
    {"drive.fixed_pdos", BENCH_BOOL, 1, DRIVE(fixed_pdos), 0, 0,
     "its PDOs cannot be written; they are those of the standard profile"},
    {"drive.acknowledges_enabling", BENCH_BOOL, 1, DRIVE(acknowledges_enabling), 0, 0,
     "bit 12 is set from Operation enabled on, and the first set-point clears it"},

    TUMBLE_DRIVE_FIELDS(PROFILE_KEY)

    TUMBLE_PROCEDURE_FIELDS(PROCEDURE_KEY)
    TUMBLE_AVERAGING_FIELDS(AVERAGING_KEY)

    {"operator.mount_s", BENCH_F64, 1, PERSON(mount_s), -1, 1e6, "s to mount and confirm; below 0: never confirms"},
    {"operator.turn_s", BENCH_F64, 1, PERSON(turn_s), -1, 1e6, "s to turn a dividing head; below 0: never"},
    {"operator.wrong_mounting", BENCH_U8, 1, PERSON(wrong_mounting), 0, 255, "asked for this mounting, ..."},
    {"operator.mounted_instead", BENCH_U8, 1, PERSON(mounted_instead), 0, 255,
     "... this one is mounted the first time"},
    {"operator.mend_s", BENCH_F64, 1, PERSON(mend_s), -1, 1e6, "s to mend a fault and go on; below 0: does not"},
    {"operator.mends", BENCH_U32, 1, PERSON(mends), 0, WHOLE_32, "how many faults are mended"},
    {"operator.tolerance_deg", BENCH_F64, 1, AT(person.tolerance_deg), 0, 360,
     "deg; a confirmed angle may be so far off"},
    {"operator.timeout_ms", BENCH_U32, 1, AT(person.timeout_ms), 1, WHOLE_32, "ms; of one request"},

    {"bus.bits_per_second", BENCH_U32, 1, AT(scenario.bits_per_second), 125000, 1e6,
     "125000, 250000, 500000 or 1000000"},
    {"firmware.stand", BENCH_ENUM, 1, AT(stand), 0, 0, "drive|operator"},
    {"firmware.loop_us", BENCH_U32, 1, AT(loop_us), 0, 100000, "us; its main loop; 0: looks at every frame at once"},
    {"firmware.heartbeat_ms", BENCH_U16, 1, AT(heartbeat_ms), 1, 65535, "ms; its own"},
    {"firmware.heartbeat_timeout_ms", BENCH_U16, 1, AT(heartbeat_timeout_ms), 1, 65535,
     "ms; silence of drive or block"},
    {"keeper.serial", BENCH_TEXT, 1, KEEPING(serial), 1, TUMBLE_SET_SERIAL_BYTES,
     "the block's serial number; tumble-node --nv needs it"},
    {"keeper.commits", BENCH_BOOL, 1, KEEPING(commits), 0, 0, "good sets become active by themselves"},
    {"keeper.first", BENCH_BOOL, 1, KEEPING(first), 0, 0, "the first set, too"},
    {"keeper.starts", BENCH_BOOL, 1, KEEPING(starts), 0, 0, "a run that is due begins by itself"},
    {"keeper.uncertainty", BENCH_F32, 12, LIMITS(uncertainty), 1e-12, 1,
     "ratio or rad (K row by row), g (U0); the most a set may have to become active"},
    {"keeper.drift_per_month", BENCH_F32, 12, LIMITS(drift_per_month), 0, 1, "likewise; plausible drift a month"},
    {"keeper.drift_per_kelvin", BENCH_F32, 12, LIMITS(drift_per_kelvin), 0, 1, "likewise; and a kelvin"},
    {"keeper.coverage", BENCH_F32, 1, LIMITS(coverage), 1, 10, "standard uncertainties that excuse a change"},
    {"keeper.gravity_m_s2", BENCH_F64, 1, KEEPING(settings.gravity_m_s2), 9.7, 9.9, "m/s2; of the place"},
    {"keeper.interval_s", BENCH_U32, 1, KEEPING(settings.interval_s), 0, WHOLE_32, "s from set to run; 0: never due"},
    {"keeper.pause_s", BENCH_U32, 1, KEEPING(settings.pause_s), TUMBLE_SETS_MIN_PAUSE_S, WHOLE_32,
     "s from one start by itself to the next"},
    {"keeper.temperature_half_c", BENCH_U8, 1, KEEPING(settings.temperature_half_c), 0, 255,
     "half degrees from the active set's that make a run due; 0: none"},
    {"keeper.temperature_samples", BENCH_U16, 1, KEEPING(settings.temperature_samples), 1, 65535, "in a row"},
    {"firmware.starts", BENCH_BOOL, 1, AT(starts), 0, 0,
     "a calibration by itself; no: waits for commands of guests until they have left"},
    {"present.navcomp", BENCH_BOOL, 1, AT(present.navcomp), 0, 0, "is it in this process?"},
    {"present.drive", BENCH_BOOL, 1, AT(present.drive), 0, 0, "likewise"},
    {"present.block", BENCH_BOOL, 1, AT(present.block), 0, 0, "likewise"},
    {"limit.virtual_s", BENCH_F64, 1, AT(virtual_limit_s), 1, BIG,
     "s; a run that lasts longer is a fault of the bench"},
};
/* clang-format on */

const size_t bench_config_key_count = sizeof bench_config_keys / sizeof bench_config_keys[0];

const bench_key_t *bench_find_key(const char *name)
{
    for (size_t i = 0; i < bench_config_key_count; i++) {
        if (bench_config_keys[i].name != NULL && strcmp(name, bench_config_keys[i].name) == 0) {
            return &bench_config_keys[i];
        }
    }
    return NULL;
}

/* Words and numbers. */

bool bench_cut_words(char *text, bench_words_t *words)
{
    words->count = 0;
    static const char BLANKS[] = " \t";
    for (char *word = text + strspn(text, BLANKS); *word != '\0';) {
        char *const end = word + strcspn(word, BLANKS);
        char *const next = end + strspn(end, BLANKS);
        if (words->count == BENCH_MAX_WORDS) {
            return false;
        }
        words->word[words->count++] = word;
        *end = '\0';
        word = next;
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

/* Values. */

static size_t size_of(bench_type_t type)
{
    static const size_t SIZES[] = {
        [BENCH_F64] = sizeof(double),
        [BENCH_F32] = sizeof(float),
        [BENCH_U8] = sizeof(uint8_t),
        [BENCH_U16] = sizeof(uint16_t),
        [BENCH_U32] = sizeof(uint32_t),
        [BENCH_I8] = sizeof(int8_t),
        [BENCH_I32] = sizeof(int32_t),
        [BENCH_BOOL] = sizeof(bool),
        [BENCH_ENUM] = sizeof(int),
        [BENCH_ENUM8] = sizeof(uint8_t),
        [BENCH_TEXT] = 1,
    };
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
    case BENCH_F64:
        return bench_number(text, key->low, key->high, at);
    case BENCH_F32:
        if (!bench_number(text, key->low, key->high, &number)) {
            return false;
        }
        *(float *)at = (float)number;
        return true;
    case BENCH_BOOL:
        choice = bench_choice(text, "no|yes");
        *(bool *)at = choice == 1;
        return choice >= 0;
    case BENCH_ENUM:
        choice = bench_choice(text, key->about);
        (void)memcpy(at, &choice, sizeof choice);
        return choice >= 0;
    case BENCH_ENUM8:
        choice = bench_choice(text, key->about);
        *(uint8_t *)at = (uint8_t)choice;
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

bool bench_store_key(const bench_key_t *key, void *structure, char *const word[], unsigned count)
{
    const bool alike = count == 1U && key->count == TUMBLE_CHANNELS;
    bool good = count == key->count || alike;
    for (unsigned i = 0; good && i < key->count; i++) {
        good = store(key, (char *)structure + key->offset + i * size_of(key->type), word[alike ? 0U : i]);
    }
    return good;
}

static bool is_choice(const bench_key_t *key)
{
    return key->type == BENCH_ENUM || key->type == BENCH_ENUM8;
}

void bench_describe_key(const bench_key_t *key, char *text, size_t size)
{
    if (is_choice(key)) {
        (void)snprintf(text, size, "one of %s", key->about);
    } else if (key->type == BENCH_BOOL) {
        (void)snprintf(text, size, "no or yes");
    } else if (key->type == BENCH_TEXT) {
        (void)snprintf(text, size, "a word of at most %.0f characters", key->high);
    } else {
        const bool whole = key->type != BENCH_F64 && key->type != BENCH_F32;
        const char *one_or = (key->count == TUMBLE_CHANNELS) ? "1 or " : "";
        (void)snprintf(text, size, "%s%u %snumber%s from %.10g to %.10g", one_or, key->count, whole ? "whole " : "",
                       (key->count == 1U) ? "" : "s", key->low, key->high);
    }
}
