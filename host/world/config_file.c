#include "world/config_file.h"

#include "navcomp/fields.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(list) (sizeof(list) / sizeof((list)[0]))
#define AT(member) offsetof(bench_config_t, member)
#define STAND(member) AT(scenario.stand.member)
#define BLOCK(member) AT(scenario.block.member)
#define SENSOR(member) AT(scenario.block.sensor.member)
#define TEMPERATURE(member) AT(scenario.block.sensor.temperature.member)
#define DRIVE(member) AT(scenario.drive.member)
#define OF_OPERATOR(member) AT(scenario.operator.member)
#define KEEPING(member) AT(keeping.member)
#define LIMITS(member) AT(keeping.settings.limits.member)

#define MAX_ANGLE_DEG 3600.0
#define BIG 1e9
#define WHOLE_32 4294967295.0

/* What a person may say of a field of the firmware: a row of its table. */
#define PROFILE_KEY(type, member, standard, signs, result, part, key, low, high, about)                                \
    {key, BENCH_##type, 1, AT(profile.member), low, high, about},
#define PROCEDURE_KEY(type, member, standard, signs, result, part, key, low, high, about)                              \
    {key, BENCH_##type, 1, AT(procedure.member), low, high, about},
#define AVERAGING_KEY(type, member, standard, signs, result, part, key, low, high, about)                              \
    {key, BENCH_##type, 1, AT(averaging.member), low, high, about},

_Static_assert(sizeof(sim_law_t) == 4U && sizeof(tumble_estimate_t) == 4U && sizeof(tumble_use_t) == 4U &&
                   sizeof(sim_phase_t) == 4U,
               "a choice is stored in four bytes");
_Static_assert(offsetof(sim_fault_t, position) == offsetof(sim_fault_t, mounting) + 1U, "a place is two bytes");

/* clang-format off */
#define STAND_WORD(name, word, kind, type, profile, node) "|" word
static const char STANDS[] = BENCH_STAND_LIST(STAND_WORD);
#undef STAND_WORD

const bench_key_t bench_config_keys[] = {
    {"stand.axis_tilt_rad", BENCH_F64, 1, STAND(axis_tilt_rad), 0, 1, "rad; limit of alpha1"},
    {"stand.level_rad", BENCH_F64, 1, STAND(level_rad), 0, 1, "rad; limit of alpha2"},
    {"stand.remount_rad", BENCH_F64, 1, STAND(remount_rad), 0, 1, "rad; limit of alpha3"},
    {"stand.angle_rad", BENCH_F64, 1, STAND(angle_rad), 0, 1, "rad; limit of alpha4"},
    {"stand.seat_rad", BENCH_F64, 1, STAND(seat_rad), 0, 1, "rad; limit of theta_h and theta_n of a mounting"},
    {"stand.platform_rad", BENCH_F64, 1, STAND(platform_rad), 0, 1, "rad; limit of theta_h of the platform"},
    {"stand.encoder_rad", BENCH_F64, 1, STAND(encoder_rad), 0, 1, "rad; limit of each number of the encoder's errors"},
    {"stand.drift_v", BENCH_F64, 3, STAND(drift_v), 0, BIG, "V; limit of the drift over the run, by channel"},
    {"stand.inclination_rad", BENCH_F64, 1, STAND(inclination_rad), 0, 1,
     "rad; limit of beta and tau of an inclination of one bolting"},
    {"stand.sag_across_rad_per_g", BENCH_F64, 1, STAND(sag_across_rad_per_g), -1, 1,
     "rad/g; the block droops against the axis by the force across it"},
    {"stand.sag_along_rad_per_g", BENCH_F64, 1, STAND(sag_along_rad_per_g), -1, 1,
     "rad/g; it leans about h by the force along the axis"},
    {"stand.limits", BENCH_ENUM, 1, STAND(law), 0, 0, "sigma1|sigma3|uniform"},
    {"stand.of_seed", BENCH_U32, 1, AT(scenario.of_seed), 0, WHOLE_32,
     "block, axis tilt, platform and encoder are those of this seed; 0: of the run's"},
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
    {"block.ramp_c_per_h", BENCH_F64, 1, TEMPERATURE(ramp_c_per_h), -BIG, BIG,
     "degrees C per hour; besides, from power-on"},
    {"block.reference_c", BENCH_F64, 1, TEMPERATURE(reference_c), -64, 63.5, "degrees C at which K and U0 hold"},
    {"block.bias_v_per_c", BENCH_F64, 3, TEMPERATURE(bias_v_per_c), -BIG, BIG, "V per degree; of the biases"},
    {"block.scale_per_c", BENCH_F64, 3, TEMPERATURE(scale_per_c), -1, 1, "per degree; relative, of the rows of K"},
    {"block.k_per_c", BENCH_F64, 9, TEMPERATURE(k_per_c), -BIG, BIG, "V/g per degree; of K, row by row, besides"},
    {"block.k_per_c2", BENCH_F64, 9, TEMPERATURE(k_per_c2), -BIG, BIG, "V/g per degree squared; of K, row by row"},
    {"block.bias_v_per_c2", BENCH_F64, 3, TEMPERATURE(bias_v_per_c2), -BIG, BIG, "V per degree squared; of the biases"},

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

    {"operator.mount_s", BENCH_F64, 1, OF_OPERATOR(mount_s), -1, 1e6, "s to mount and confirm; below 0: never confirms"},
    {"operator.incline_s", BENCH_F64, 1, OF_OPERATOR(incline_s), -1, 1e6,
     "s to incline the stand, the block bolted on, and confirm; below 0: never"},
    {"operator.turn_s", BENCH_F64, 1, OF_OPERATOR(turn_s), -1, 1e6, "s to turn a dividing head; below 0: never"},
    {"operator.wrong_mounting", BENCH_U8, 1, OF_OPERATOR(wrong_mounting), 0, 255, "asked for this mounting, ..."},
    {"operator.mounted_instead", BENCH_U8, 1, OF_OPERATOR(mounted_instead), 0, 255,
     "... this one is mounted the first time"},
    {"operator.mend_s", BENCH_F64, 1, OF_OPERATOR(mend_s), -1, 1e6, "s to mend a fault and go on; below 0: does not"},
    {"operator.mends", BENCH_U32, 1, OF_OPERATOR(mends), 0, WHOLE_32, "how many faults are mended"},
    {"operator.tolerance_deg", BENCH_F64, 1, AT(operator.tolerance_deg), 0, 360,
     "deg; a confirmed angle may be so far off"},
    {"operator.timeout_ms", BENCH_U32, 1, AT(operator.timeout_ms), 1, WHOLE_32, "ms; of one request"},

    {"bus.bits_per_second", BENCH_U32, 1, AT(scenario.bits_per_second), 125000, 1e6,
     "125000, 250000, 500000 or 1000000"},
    {"firmware.stand", BENCH_ENUM, 1, AT(stand), 0, 0, &STANDS[1]},
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

const size_t bench_config_key_count = COUNT(bench_config_keys);

const bench_key_t *bench_find_key(const char *name)
{
    for (size_t i = 0; i < bench_config_key_count; i++) {
        if (bench_config_keys[i].name != NULL && strcmp(name, bench_config_keys[i].name) == 0) {
            return &bench_config_keys[i];
        }
    }
    return NULL;
}

/* The lines that may repeat: what stands on one, in its order and within the element of a list that it fills. A last
 * field of so many values at most (count 0) takes all words that are left, one at least. */

static const bench_key_t MOUNTING[] = {
    {"number", BENCH_U8, 1, offsetof(tumble_mounting_t, number), 1, 255, ""},
    {"tilt", BENCH_F64, 1, offsetof(tumble_mounting_t, tilt.deg), -MAX_ANGLE_DEG, MAX_ANGLE_DEG, "deg"},
    {"sine", BENCH_F64, 1, offsetof(tumble_mounting_t, tilt.sine), -1, 1, ""},
    {"cosine", BENCH_F64, 1, offsetof(tumble_mounting_t, tilt.cosine), -1, 1, ""},
    {"matrix", BENCH_F64, 9, offsetof(tumble_mounting_t, matrix), -1, 1, ""},
    {"bolting", BENCH_U8, 1, offsetof(tumble_mounting_t, bolting), 1, 255, ""},
};
static const bench_key_t POSITION[] = {
    {"mounting", BENCH_U8, 1, offsetof(tumble_position_t, mounting), 1, 255, ""},
    {"number", BENCH_U8, 1, offsetof(tumble_position_t, number), 1, 255, ""},
    {"use", BENCH_ENUM, 1, offsetof(tumble_position_t, use), 0, 0, "fit|check"},
    {"angle", BENCH_F64, 1, offsetof(tumble_position_t, angle.deg), -MAX_ANGLE_DEG, MAX_ANGLE_DEG, "deg"},
    {"sine", BENCH_F64, 1, offsetof(tumble_position_t, angle.sine), -1, 1, ""},
    {"cosine", BENCH_F64, 1, offsetof(tumble_position_t, angle.cosine), -1, 1, ""},
};
static const bench_key_t RECEIVE_PDO[] = {
    {"number", BENCH_U8, 1, offsetof(tumble_drive_pdo_t, number), 0, 255, ""},
    {"cob_id", BENCH_U32, 1, offsetof(tumble_drive_pdo_t, setup.cob_id), 0, TUMBLE_CAN_MAX_ID, ""},
    {"objects", BENCH_OBJECT, 0, offsetof(tumble_drive_pdo_t, setup.map), 0, TUMBLE_MAX_MAPPED, ""},
};
static const bench_key_t TRANSMIT_PDO[] = {
    {"number", BENCH_U8, 1, offsetof(tumble_drive_pdo_t, number), 0, 255, ""},
    {"cob_id", BENCH_U32, 1, offsetof(tumble_drive_pdo_t, setup.cob_id), 0, TUMBLE_CAN_MAX_ID, ""},
    {"inhibit", BENCH_U16, 1, offsetof(tumble_drive_pdo_t, setup.inhibit_100us), 0, 65535, "100 us"},
    {"event", BENCH_U16, 1, offsetof(tumble_drive_pdo_t, setup.event_ms), 0, 65535, "ms"},
    {"objects", BENCH_OBJECT, 0, offsetof(tumble_drive_pdo_t, setup.map), 0, TUMBLE_MAX_MAPPED, ""},
};
static const bench_key_t WRITE[] = {
    {"index", BENCH_INDEX, 1, offsetof(tumble_object_write_t, index), 0, 65535, ""},
    {"subindex", BENCH_U8, 1, offsetof(tumble_object_write_t, subindex), 0, 255, ""},
    {"size", BENCH_U8, 1, offsetof(tumble_object_write_t, size), 1, 4, ""},
    {"value", BENCH_U32, 1, offsetof(tumble_object_write_t, value), -2147483648.0, WHOLE_32, ""},
};
static const bench_key_t LACKS[] = {{"index", BENCH_INDEX, 1, 0, 0, 65535, ""}};

#define INDEX_WORDS "an index is hexadecimal, such as 0x6040"
#define PDO_WORDS                                                                                                      \
    "a PDO is its number (0 to 255), COB-ID, for a transmit PDO inhibit time (100 us) and event timer (ms), and up "   \
    "to eight objects INDEX:SUBINDEX:BITS; " INDEX_WORDS
#define WRITE_WORDS "a write is index, subindex, size (1, 2, 4) and value, at most 16 of them; " INDEX_WORDS
#define LACKS_WORDS "drive.lacks names objects, at most 16 of them; " INDEX_WORDS

typedef struct {
    const char *key;
    const bench_key_t *fields;
    unsigned field_count;
    unsigned needed; /* fields from the first on; those behind may be left out */
    size_t list;     /* offset in bench_config_t */
    size_t bytes;    /* of an element */
    size_t count;    /* offset of how many there are, a byte */
    uint8_t most;
    const char *full;
    const char *wrong;
} line_t;

#define LINE(fields, list, element, count) LINE_WITH(COUNT(fields), fields, list, element, count)
#define LINE_WITH(needed, fields, list, element, count)                                                                \
    fields, COUNT(fields), (needed), AT(list), sizeof(element), AT(count)

/* The first two are the schedule. */
static const line_t LINES[] = {
    {"mounting",
     LINE_WITH(COUNT(MOUNTING) - 1U, MOUNTING, scenario.mountings, tumble_mounting_t, scenario.schedule.mounting_count),
     TUMBLE_MAX_MOUNTINGS, "more mountings than fit",
     "a mounting is a number 1 to 255, tilt (degrees, sine, cosine), nine elements within 1, and if it shares a bolting "
     "that one's number"},
    {"position", LINE(POSITION, scenario.positions, tumble_position_t, scenario.schedule.position_count),
     TUMBLE_MAX_POSITIONS, "more positions than fit",
     "a position is mounting and number (1 to 255), fit or check, and its angle (degrees, sine, cosine)"},
    {"profile.receive_pdo", LINE(RECEIVE_PDO, lists.receive, tumble_drive_pdo_t, profile.receive_count),
     TUMBLE_MAX_RECEIVE_PDOS, "more PDOs than fit", PDO_WORDS},
    {"profile.transmit_pdo", LINE(TRANSMIT_PDO, lists.transmit, tumble_drive_pdo_t, profile.transmit_count),
     TUMBLE_MAX_TRANSMIT_PDOS, "more PDOs than fit", PDO_WORDS},
    {"profile.write", LINE(WRITE, lists.writes, tumble_object_write_t, profile.write_count), BENCH_MAX_WRITES,
     WRITE_WORDS, WRITE_WORDS},
    {"drive.lacks", LINE(LACKS, scenario.drive.lacks, uint16_t, scenario.drive.lack_count), SIM_MAX_LACKS, LACKS_WORDS,
     LACKS_WORDS},
};

/* The fields of a fault, in any order. */
static const bench_key_t FAULT[] = {
    {"at", BENCH_PLACE, 1, offsetof(sim_fault_t, mounting), 1, 255, "MOUNTING.POSITION"},
    {"phase", BENCH_ENUM, 1, offsetof(sim_fault_t, phase), 0, 0, "mount|home|move|settle|average"},
    {"time", BENCH_F64, 1, offsetof(sim_fault_t, time_s), 0, BIG, "s"},
    {"delay", BENCH_F64, 1, offsetof(sim_fault_t, delay_s), 0, BIG, "s"},
    {"duration", BENCH_F64, 1, offsetof(sim_fault_t, duration_s), 0, BIG, "s"},
    {"times", BENCH_U32, 1, offsetof(sim_fault_t, times), 0, UINT32_MAX, ""},
    {"channels", BENCH_CHANNELS, 1, offsetof(sim_fault_t, channels), 0, 0, "of xyz"},
    {"value", BENCH_F64, 1, offsetof(sim_fault_t, value), -BIG, BIG, ""},
    {"count", BENCH_U32, 1, offsetof(sim_fault_t, count), 0, UINT32_MAX, ""},
    {"id", BENCH_U16, 1, offsetof(sim_fault_t, id), 0, TUMBLE_CAN_MAX_ID, ""},
    {"mask", BENCH_U16, 1, offsetof(sim_fault_t, mask), 0, TUMBLE_CAN_MAX_ID, ""},
    {"probability", BENCH_F64, 1, offsetof(sim_fault_t, probability), 0, 1, ""},
};

#define MAX_WORDS 24

typedef struct {
    char *word[MAX_WORDS];
    unsigned count;
} words_t;

/* Words and numbers. */

static bool cut_words(char *text, words_t *words)
{
    words->count = 0;
    static const char BLANKS[] = " \t";
    for (char *word = text + strspn(text, BLANKS); *word != '\0';) {
        char *const end = word + strcspn(word, BLANKS);
        char *const next = end + strspn(end, BLANKS);
        if (words->count == MAX_WORDS) {
            return false;
        }
        words->word[words->count++] = word;
        *end = '\0';
        word = next;
    }
    return true;
}

static bool number(const char *text, double low, double high, double *value)
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

static bool whole(const char *text, double low, double high, int64_t *value)
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

static int choice(const char *text, const char *words)
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

/* 0x and up to four hexadecimal digits. Without 0x what was taken before it was asked for, where it has one reading:
 * four digits in a mapping, where they never were decimal; elsewhere a decimal number of five. */
static bool read_index(const char *text, bool mapped, int64_t *index)
{
    const bool marked = text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    const char *const digits = marked ? text + 2 : text;
    const size_t length = strlen(digits);
    if (!marked && !mapped) {
        return length == 5U && whole(text, 10000, 65535, index);
    }
    *index = strtol(digits, NULL, 16);
    return length > 0U && length <= 4U && (marked || length == 4U) &&
           strspn(digits, "0123456789abcdefABCDEF") == length;
}

/* INDEX:SUBINDEX:BITS */
static bool read_object(char *text, int64_t *object)
{
    char *const first = strchr(text, ':');
    char *const second = (first != NULL) ? strchr(first + 1, ':') : NULL;
    int64_t index = 0;
    int64_t subindex = 0;
    int64_t bits = 0;
    if (second == NULL) {
        return false;
    }
    *first = '\0';
    *second = '\0';
    const bool good =
        read_index(text, true, &index) && whole(first + 1, 0, 255, &subindex) && whole(second + 1, 1, 64, &bits);
    *object = TUMBLE_MAP(index, subindex, bits);
    return good;
}

static bool read_channels(const char *text, int64_t *channels)
{
    *channels = 0;
    for (const char *channel = text; *channel != '\0'; channel++) {
        *channels |= (*channel >= 'x' && *channel <= 'z') ? 1 << (*channel - 'x') : 0;
    }
    return *text != '\0' && strspn(text, "xyz") == strlen(text);
}

/* MOUNTING.POSITION, in two bytes. */
static bool read_place(char *text, uint8_t *place)
{
    char *const dot = strchr(text, '.');
    int64_t mounting = 0;
    int64_t position = 0;
    if (dot == NULL) {
        return false;
    }
    *dot = '\0';
    const bool good = whole(text, 1, 255, &mounting) && whole(dot + 1, 1, 255, &position);
    place[0] = (uint8_t)mounting;
    place[1] = (uint8_t)position;
    return good;
}

static const uint8_t SIZES[] = {
    [BENCH_F64] = 8,  [BENCH_F32] = 4,   [BENCH_U8] = 1,     [BENCH_U16] = 2,      [BENCH_U32] = 4,
    [BENCH_I8] = 1,   [BENCH_I32] = 4,   [BENCH_BOOL] = 1,   [BENCH_ENUM] = 4,     [BENCH_ENUM8] = 1,
    [BENCH_TEXT] = 1, [BENCH_INDEX] = 2, [BENCH_OBJECT] = 4, [BENCH_CHANNELS] = 1, [BENCH_PLACE] = 2,
};

/* A value that is stored as a whole number. */
static bool read_whole(const bench_key_t *key, char *text, int64_t *value)
{
    switch (key->type) {
    case BENCH_BOOL:
    case BENCH_ENUM:
    case BENCH_ENUM8:
        *value = choice(text, (key->type == BENCH_BOOL) ? "no|yes" : key->about);
        return *value >= 0;
    case BENCH_INDEX:
        return read_index(text, false, value);
    case BENCH_OBJECT:
        return read_object(text, value);
    case BENCH_CHANNELS:
        return read_channels(text, value);
    default:
        return whole(text, key->low, key->high, value);
    }
}

static bool store(const bench_key_t *key, void *at, char *text)
{
    double real = 0.0;
    int64_t value = 0;
    bool good = true;
    switch (key->type) {
    case BENCH_F64:
        return number(text, key->low, key->high, at);
    case BENCH_F32:
        good = number(text, key->low, key->high, &real);
        *(float *)at = (float)real;
        return good;
    case BENCH_TEXT:
        return (strlen(text) <= (size_t)key->high) && (strcpy(at, text) != NULL);
    case BENCH_PLACE:
        return read_place(text, at);
    default:
        break;
    }
    good = read_whole(key, text, &value);
    if (SIZES[key->type] == 1U) {
        *(uint8_t *)at = (uint8_t)value;
    } else if (SIZES[key->type] == 2U) {
        *(uint16_t *)at = (uint16_t)value;
    } else {
        *(uint32_t *)at = (uint32_t)value;
    }
    return good;
}

/* All of these words, one value each. */
static bool store_all(const bench_key_t *key, void *structure, char *const word[], unsigned count)
{
    bool good = true;
    for (unsigned i = 0; good && i < count; i++) {
        good = store(key, (char *)structure + key->offset + (size_t)i * SIZES[key->type], word[i]);
    }
    return good;
}

/* The values of a key that comes once; of three, one may stand for all. */
static bool store_key(const bench_key_t *key, bench_config_t *config, words_t *words)
{
    if (words->count == 1U && key->count == TUMBLE_CHANNELS) {
        words->word[1] = words->word[0];
        words->word[2] = words->word[0];
        words->count = TUMBLE_CHANNELS;
    }
    return words->count == key->count && store_all(key, config, words->word, words->count);
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

/* Lines. */

/* An element of a list, from the words at `*from` on. */
static bool take_element(const line_t *line, void *element, const words_t *words, unsigned *from)
{
    bool good = true;
    for (unsigned i = 0; good && i < line->field_count; i++) {
        const bench_key_t *const field = &line->fields[i];
        const unsigned left = words->count - *from;
        if (left == 0U && i >= line->needed) {
            break;
        }
        const unsigned values = (field->count > 0U) ? field->count : left;
        good = values > 0U && values <= left && (field->count > 0U || values <= (unsigned)field->high) &&
               store_all(field, element, &words->word[*from], values);
        *from += good ? values : 0U;
        if (field->type == BENCH_OBJECT) {
            tumble_drive_pdo_t *const pdo = element;
            pdo->setup.type = TUMBLE_PDO_EVENT_PROFILE;
            pdo->setup.count = (uint8_t)values;
        }
    }
    return good;
}

/* The paper's schedule goes with the first line of another one. */
static void begin_schedule(sim_scenario_t *scenario)
{
    if (scenario->schedule.mountings == tumble_schedule_paper.mountings) {
        scenario->schedule = (tumble_schedule_t){scenario->mountings, scenario->positions, 0, 0};
    }
}

/* One element; of drive.lacks as many as there are words. Null, or what is wrong. */
static const char *take_line(bench_config_t *config, const line_t *line, const words_t *words)
{
    uint8_t *const count = (uint8_t *)config + line->count;
    unsigned from = 0;
    if (line < &LINES[2]) {
        begin_schedule(&config->scenario);
    }
    bool more = words->count > 0U || line->fields != LACKS;
    while (more) {
        if (*count == line->most) {
            return line->full;
        }
        if (!take_element(line, (char *)config + line->list + *count * line->bytes, words, &from)) {
            return line->wrong;
        }
        (*count)++;
        more = line->fields == LACKS && from < words->count;
    }
    return (from == words->count) ? NULL : line->wrong;
}

/* One `name=text` of a fault. */
static bool take_fault_field(sim_fault_t *fault, const char *name, char *text)
{
    fault->at_time = fault->at_time || strcmp(name, "time") == 0;
    for (size_t i = 0; i < COUNT(FAULT); i++) {
        if (strcmp(name, FAULT[i].name) == 0) {
            return store_all(&FAULT[i], fault, &text, 1);
        }
    }
    return false;
}

static const char *take_fault(bench_config_t *config, const words_t *words)
{
#define FAULT_WORD(name, of, word, sentence) "|" word
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
    const int kind = (words->count > 0U) ? choice(words->word[0], KINDS + 1) : -1;
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
        if (!take_fault_field(&fault, words->word[i], equals + 1)) {
            return "a field of the fault is unknown or out of range";
        }
    }
    if (fault.at_time == (fault.mounting != 0U)) {
        return "a fault needs either at=MOUNTING.POSITION or time=SECONDS";
    }
    scenario->faults[scenario->fault_count++] = fault;
    return NULL;
}

static bool complain(bench_mistake_t *mistake, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(mistake->what, sizeof mistake->what, format, arguments);
    va_end(arguments);
    return false;
}

static bool take_key(bench_config_t *config, const char *name, words_t *words, bench_seen_t *seen,
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
    if (!store_key(key, config, words)) {
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
    words_t words;
    if (!cut_words(trim(equals + 1), &words)) {
        return complain(mistake, "%.60s has more than %d values", key, MAX_WORDS);
    }
    const line_t *row = NULL;
    for (size_t i = 0; i < COUNT(LINES); i++) {
        row = (strcmp(key, LINES[i].key) == 0) ? &LINES[i] : row;
    }
    if (row == NULL && strcmp(key, "fault") != 0) {
        return take_key(config, key, &words, seen, mistake);
    }
    const char *const wrong = (row != NULL) ? take_line(config, row, &words) : take_fault(config, &words);
    return wrong == NULL || complain(mistake, "%s", wrong);
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
