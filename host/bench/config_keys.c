#include "bench/config_keys.h"

#include "bench/config.h"

#define AT(member) offsetof(bench_config_t, member)
#define STAND(member) AT(scenario.stand.member)
#define BLOCK(member) AT(scenario.block.member)
#define SENSOR(member) AT(scenario.block.sensor.member)
#define TEMPERATURE(member) AT(scenario.block.sensor.temperature.member)
#define DRIVE(member) AT(scenario.drive.member)
#define PERSON(member) AT(scenario.person.member)

#define BIG 1e9
#define WHOLE_32 4294967295.0

_Static_assert(sizeof(sim_law_t) == sizeof(int) && sizeof(tumble_estimate_t) == sizeof(int),
               "a choice is stored as an int");

/* clang-format off */
const bench_key_t bench_config_keys[] = {
    {"stand.axis_tilt_rad", BENCH_DOUBLE, 1, STAND(axis_tilt_rad), 0, 1, "rad; limit of alpha1"},
    {"stand.level_rad", BENCH_DOUBLE, 1, STAND(level_rad), 0, 1, "rad; limit of alpha2"},
    {"stand.remount_rad", BENCH_DOUBLE, 1, STAND(remount_rad), 0, 1, "rad; limit of alpha3"},
    {"stand.angle_rad", BENCH_DOUBLE, 1, STAND(angle_rad), 0, 1, "rad; limit of alpha4"},
    {"stand.limits", BENCH_CHOICE, 1, STAND(law), 0, 0, "sigma1|sigma3|uniform"},
    {"stand.remount", BENCH_CHOICE, 1, STAND(remount), 0, 0, "independent|common"},

    {"block.k", BENCH_DOUBLE, 9, SENSOR(k_v_per_g), -BIG, BIG, "V/g; the true K, row by row; with block.u0"},
    {"block.u0", BENCH_DOUBLE, 3, SENSOR(u0_v), -BIG, BIG, "V; the true U0; with block.k"},
    {"block.scale_v_per_g", BENCH_DOUBLE, 1, BLOCK(scale_v_per_g), -BIG, BIG, "V/g; nominal scale factor, not 0"},
    {"block.scale_spread", BENCH_DOUBLE, 1, BLOCK(scale_spread), 0, 0.5, "drawn scale factors lie within this, relative"},
    {"block.misalignment_rad", BENCH_DOUBLE, 1, BLOCK(misalignment_rad), 0, 0.5, "rad; drawn cross terms lie within this"},
    {"block.bias_v", BENCH_DOUBLE, 1, BLOCK(bias_v), 0, BIG, "V; drawn biases lie within this"},
    {"block.noise_v", BENCH_DOUBLE, 3, SENSOR(noise_v), 0, BIG, "V; limit of the noise of one sample, by channel"},
    {"block.noise_limits", BENCH_CHOICE, 1, SENSOR(noise_law), 0, 0, "sigma1|sigma3|uniform"},
    {"block.converter_bits", BENCH_U8, 1, SENSOR(converter_bits), 8, 24, "of the converter"},
    {"block.range_v", BENCH_DOUBLE, 1, SENSOR(range_v), 1e-9, BIG, "V; the converter measures up to + and - this"},
    {"block.sample_period_us", BENCH_U32, 1, BLOCK(sample_period_us), 1000, 1e6, "us between samples"},
    {"block.first_sample_us", BENCH_U32, 1, BLOCK(first_sample_us), 0, 1e6, "us from Operational to the first sample"},
    {"block.first_counter", BENCH_U16, 1, BLOCK(first_counter), 0, 65535, "sample counter at power-on"},
    {"block.first_timestamp_ms", BENCH_U16, 1, BLOCK(first_timestamp_ms), 0, 4095, "ms; its clock at power-on"},
    {"block.drift_v_per_h", BENCH_DOUBLE, 3, SENSOR(drift_v_per_h), -BIG, BIG, "V/h; drift of the outputs"},
    {"block.start_c", BENCH_DOUBLE, 1, TEMPERATURE(start_c), -64, 63.5, "degrees C at power-on"},
    {"block.end_c", BENCH_DOUBLE, 1, TEMPERATURE(end_c), -64, 63.5, "degrees C in the end"},
    {"block.warm_s", BENCH_DOUBLE, 1, TEMPERATURE(tau_s), 0, 1e6, "s; time constant of warming up; 0: warm from the start"},
    {"block.reference_c", BENCH_DOUBLE, 1, TEMPERATURE(reference_c), -64, 63.5, "degrees C at which K and U0 hold"},
    {"block.bias_v_per_c", BENCH_DOUBLE, 3, TEMPERATURE(bias_v_per_c), -BIG, BIG, "V per degree; of the biases"},
    {"block.scale_per_c", BENCH_DOUBLE, 3, TEMPERATURE(scale_per_c), -1, 1, "per degree; relative, of the rows of K"},

    {"motion.speed_deg_s", BENCH_DOUBLE, 1, DRIVE(speed_deg_s), 1e-3, 1e4, "deg/s; the drive's most, and the profile's"},
    {"motion.acceleration_deg_s2", BENCH_DOUBLE, 1, DRIVE(acceleration_deg_s2), 1e-3, 1e5, "deg/s2; likewise"},
    {"motion.settling_s", BENCH_DOUBLE, 1, DRIVE(axis.settling_s), 0, 1000, "s; until the swing has fallen to 1/1000"},
    {"motion.swing_deg", BENCH_DOUBLE, 1, DRIVE(axis.swing_deg), 0, 45, "deg; swing of the table after a stop"},
    {"motion.swing_hz", BENCH_DOUBLE, 1, DRIVE(axis.swing_hz), 0, 1000, "Hz; its frequency"},

    {"drive.counts_per_turn", BENCH_U32, 1, DRIVE(counts_per_turn), 16, 2147483647.0, "counts per turn of the table"},
    {"drive.sign", BENCH_I32, 1, DRIVE(sign), -1, 1, "1, or -1: counts fall when the table turns upwards"},
    {"drive.wrap_counts", BENCH_U32, 1, DRIVE(wrap_counts), 0, 2147483647.0, "positions count modulo this; 0: they do not"},
    {"drive.velocity_per_deg_s", BENCH_DOUBLE, 1, DRIVE(velocity_per_deg_s), 1e-3, BIG, "its units of velocity per deg/s"},
    {"drive.acceleration_per_deg_s2", BENCH_DOUBLE, 1, DRIVE(acceleration_per_deg_s2), 1e-3, BIG, "and per deg/s2"},
    {"drive.power_on_deg", BENCH_DOUBLE, 1, DRIVE(power_on_deg), 0, 3600, "deg; wakes up within this of the home mark"},
    {"drive.reaction_us", BENCH_U32, 1, DRIVE(reaction_us), 0, 1e6, "us from a command to its statusword"},
    {"drive.report_us", BENCH_U32, 1, DRIVE(report_us), 100, 1e6, "us; its control cycle while it moves"},
    {"drive.latches_stale_target", BENCH_BOOL, 1, DRIVE(latches_stale_target), 0, 0, "takes the target of the frame before"},

    {"profile.counts_per_turn", BENCH_DOUBLE, 1, AT(profile.counts_per_revolution), 0, 1e12, "what the firmware believes; 0: right"},
    {"profile.sign", BENCH_I8, 1, AT(profile.sign), -1, 1, "likewise; 0: right, and so is the wrap"},
    {"profile.wrap_counts", BENCH_U32, 1, AT(profile.wrap_counts), 0, 2147483647.0, "likewise, with profile.sign"},
    {"profile.velocity_per_deg_s", BENCH_DOUBLE, 1, AT(profile.velocity_units_per_deg_s), 0, BIG, "likewise; 0: right"},
    {"profile.acceleration_per_deg_s2", BENCH_DOUBLE, 1, AT(profile.acceleration_units_per_deg_s2), 0, BIG, "likewise; 0: right"},
    {"profile.window_counts", BENCH_U32, 1, AT(profile.window_counts), 0, WHOLE_32, "target reached is believed within this; 0: always"},
    {"profile.speed_deg_s", BENCH_DOUBLE, 1, AT(profile.velocity_deg_s), 0, 1e4, "deg/s; 0: motion.speed_deg_s"},
    {"profile.acceleration_deg_s2", BENCH_DOUBLE, 1, AT(profile.acceleration_deg_s2), 0, 1e5, "deg/s2; 0: motion.acceleration_deg_s2"},
    {"profile.homing_fast_deg_s", BENCH_DOUBLE, 1, AT(profile.homing_fast_deg_s), 0, 1e4, "deg/s"},
    {"profile.homing_slow_deg_s", BENCH_DOUBLE, 1, AT(profile.homing_slow_deg_s), 0, 1e4, "deg/s"},
    {"profile.homing_method", BENCH_I8, 1, AT(profile.homing_method), -128, 127, "object 6098h"},
    {"profile.stop", BENCH_CHOICE, 1, AT(stop), 0, 0, "quick_stop|halt"},
    {"profile.heartbeat_ms", BENCH_U16, 1, AT(profile.heartbeat_ms), 1, 65535, "ms; of the drive"},
    {"profile.heartbeat_timeout_ms", BENCH_U16, 1, AT(profile.heartbeat_timeout_ms), 0, 65535, "ms; our silence after which it stops"},
    {"profile.start_timeout_ms", BENCH_U32, 1, AT(profile.start_timeout_ms), 1, WHOLE_32, "ms"},
    {"profile.power_timeout_ms", BENCH_U32, 1, AT(profile.power_timeout_ms), 1, WHOLE_32, "ms"},
    {"profile.handshake_timeout_ms", BENCH_U32, 1, AT(profile.handshake_timeout_ms), 1, WHOLE_32, "ms"},
    {"profile.home_timeout_ms", BENCH_U32, 1, AT(profile.home_timeout_ms), 1, WHOLE_32, "ms"},
    {"profile.move_timeout_ms", BENCH_U32, 1, AT(profile.move_timeout_ms), 1, WHOLE_32, "ms"},
    {"profile.stop_timeout_ms", BENCH_U32, 1, AT(profile.stop_timeout_ms), 1, WHOLE_32, "ms"},

    {"procedure.estimator", BENCH_CHOICE, 1, AT(procedure.estimate), 0, 0, "averaged|refined|least_squares"},
    {"procedure.samples", BENCH_U32, 1, AT(procedure.samples), 1, 1048576, "samples per position"},
    {"procedure.nominal_scale_v_per_g", BENCH_DOUBLE, 1, AT(procedure.nominal_scale_v_per_g), -BIG, BIG, "V/g; 0: block.scale_v_per_g"},
    {"procedure.gravity_limit_g", BENCH_DOUBLE, 1, AT(procedure.gravity_limit_g), 0, BIG, "g; limit of the gravity check"},
    {"procedure.closure_limit_g", BENCH_DOUBLE, 1, AT(procedure.closure_limit_g), 0, BIG, "g; 0: from noise and alpha4, at least 2e-3"},
    {"procedure.position_tolerance_deg", BENCH_DOUBLE, 1, AT(procedure.position_tolerance_deg), 0, 360, "deg"},
    {"procedure.approach_deg", BENCH_DOUBLE, 1, AT(procedure.approach_deg), 0, 360, "deg"},
    {"procedure.cable_min_deg", BENCH_DOUBLE, 1, AT(procedure.cable_min_deg), -1e5, 1e5, "deg"},
    {"procedure.cable_max_deg", BENCH_DOUBLE, 1, AT(procedure.cable_max_deg), -1e5, 1e5, "deg"},
    {"procedure.settle_ms", BENCH_U16, 1, AT(procedure.settle_ms), 0, 65535, "ms"},
    {"procedure.max_corrupted", BENCH_U16, 1, AT(procedure.max_corrupted), 0, 65535, "frames per position"},
    {"procedure.retries", BENCH_U8, 1, AT(procedure.retries), 0, 255, "per position"},
    {"procedure.warm_up_band_half_c", BENCH_I8, 1, AT(procedure.warm_up_band_half_c), -128, 127, "half degrees"},
    {"procedure.warm_up_samples", BENCH_U16, 1, AT(procedure.warm_up_samples), 0, 65535, "in a row; 0: no warm-up"},
    {"procedure.preflight_timeout_ms", BENCH_U32, 1, AT(procedure.preflight_timeout_ms), 0, WHOLE_32, "ms"},
    {"procedure.warm_up_timeout_ms", BENCH_U32, 1, AT(procedure.warm_up_timeout_ms), 0, WHOLE_32, "ms"},
    {"procedure.mounting_timeout_ms", BENCH_U32, 1, AT(procedure.mounting_timeout_ms), 0, WHOLE_32, "ms"},
    {"procedure.home_timeout_ms", BENCH_U32, 1, AT(procedure.home_timeout_ms), 0, WHOLE_32, "ms"},
    {"procedure.move_timeout_ms", BENCH_U32, 1, AT(procedure.move_timeout_ms), 0, WHOLE_32, "ms"},
    {"procedure.settle_timeout_ms", BENCH_U32, 1, AT(procedure.settle_timeout_ms), 0, WHOLE_32, "ms"},
    {"procedure.average_timeout_ms", BENCH_U32, 1, AT(procedure.average_timeout_ms), 0, WHOLE_32, "ms; 0: from the samples"},
    {"procedure.sample_timeout_ms", BENCH_U32, 1, AT(procedure.sample_timeout_ms), 0, WHOLE_32, "ms"},
    {"averaging.max_lost", BENCH_U16, 1, AT(averaging.max_lost), 0, 65535, "samples per position"},
    {"averaging.stuck_run", BENCH_U16, 1, AT(averaging.stuck_run), 0, 65535, "equal values in a row; 0: off"},
    {"averaging.noise_counts", BENCH_FLOAT, 1, AT(averaging.noise_counts), 0, BIG, "declared noise; 0: the block's"},
    {"averaging.stillness_ratio", BENCH_FLOAT, 1, AT(averaging.stillness_ratio), 0, BIG, "scatter over it; 0: from the samples"},

    {"operator.mount_s", BENCH_DOUBLE, 1, PERSON(mount_s), -1, 1e6, "s to mount and confirm; below 0: never confirms"},
    {"operator.turn_s", BENCH_DOUBLE, 1, PERSON(turn_s), -1, 1e6, "s to turn a dividing head; below 0: never"},
    {"operator.wrong_mounting", BENCH_U8, 1, PERSON(wrong_mounting), 0, 255, "asked for this mounting, ..."},
    {"operator.mounted_instead", BENCH_U8, 1, PERSON(mounted_instead), 0, 255, "... this one is mounted the first time"},
    {"operator.mend_s", BENCH_DOUBLE, 1, PERSON(mend_s), -1, 1e6, "s to mend a fault and go on; below 0: does not"},
    {"operator.mends", BENCH_U32, 1, PERSON(mends), 0, WHOLE_32, "how many faults are mended"},
    {"operator.tolerance_deg", BENCH_DOUBLE, 1, AT(person.tolerance_deg), 0, 360, "deg; a confirmed angle may be so far off"},
    {"operator.timeout_ms", BENCH_U32, 1, AT(person.timeout_ms), 1, WHOLE_32, "ms; of one request"},

    {"bus.bits_per_second", BENCH_U32, 1, AT(scenario.bits_per_second), 125000, 1e6, "125000, 250000, 500000 or 1000000"},
    {"firmware.stand", BENCH_CHOICE, 1, AT(stand), 0, 0, "drive|operator"},
    {"firmware.loop_us", BENCH_U32, 1, AT(loop_us), 0, 100000, "us; its main loop; 0: looks at every frame at once"},
    {"firmware.heartbeat_ms", BENCH_U16, 1, AT(heartbeat_ms), 1, 65535, "ms; its own"},
    {"firmware.heartbeat_timeout_ms", BENCH_U16, 1, AT(heartbeat_timeout_ms), 1, 65535, "ms; silence of drive or block"},
    {"present.navcomp", BENCH_BOOL, 1, AT(present.navcomp), 0, 0, "is it in this process?"},
    {"present.drive", BENCH_BOOL, 1, AT(present.drive), 0, 0, "likewise"},
    {"present.block", BENCH_BOOL, 1, AT(present.block), 0, 0, "likewise"},
    {"limit.virtual_s", BENCH_DOUBLE, 1, AT(virtual_limit_s), 1, BIG, "s; a run that lasts longer is a fault of the bench"},
};
/* clang-format on */

const size_t bench_config_key_count = sizeof bench_config_keys / sizeof bench_config_keys[0];
