/* Scenario files: every key arrives where it belongs, and whatever is wrong is refused with its line. */
#include "sim_bench.h"

#include "world/config_file.h"

#include <math.h>

typedef struct {
    unsigned line; /* 0: of no single line */
    const char *what;
    const char *lines;
} refusal_t;

#define MOUNTING_WORDS                                                                                                   \
    "a mounting is a number 1 to 255, tilt (degrees, sine, cosine), nine elements within 1, and if it shares a bolting " \
    "that one's number"
#define WRITE_WORDS                                                                                                    \
    "a write is index, subindex, size (1, 2, 4) and value, at most 16 of them; an index is hexadecimal, such as "      \
    "0x6040"

static const refusal_t REFUSALS[] = {
    {1, "neither a comment nor key = value", "stand.angle_rad 4e-5\n"},
    {2, "no such key: stand.angle", "\nstand.angle = 1\n"},
    {1, "no such key: ", "= 3\n"},
    {3, "stand.angle_rad is given twice", "stand.angle_rad = 1e-5\n# again\nstand.angle_rad = 1e-5\n"},
    {1, "stand.angle_rad must be 1 number from 0 to 1", "stand.angle_rad = -1e-5\n"},
    {1, "stand.angle_rad must be 1 number from 0 to 1", "stand.angle_rad = nan\n"},
    {1, "stand.angle_rad must be 1 number from 0 to 1", "stand.angle_rad = inf\n"},
    {1, "stand.angle_rad must be 1 number from 0 to 1", "stand.angle_rad = 1e-5x\n"},
    {1, "stand.angle_rad must be 1 number from 0 to 1", "stand.angle_rad = 1,5\n"},
    {1, "stand.angle_rad must be 1 number from 0 to 1", "stand.angle_rad =\n"},
    {1, "stand.angle_rad must be 1 number from 0 to 1", "stand.angle_rad = 1e-5 2e-5\n"},
    {1, "stand.limits must be one of sigma1|sigma3|uniform", "stand.limits = sigma2\n"},
    {1, "stand.limits must be one of sigma1|sigma3|uniform", "stand.limits = sigma\n"},
    {1, "drive.latches_stale_target must be no or yes", "drive.latches_stale_target = true\n"},
    {1, "block.u0 must be 1 or 3 numbers from -1000000000 to 1000000000", "block.u0 = 1 2\n"},
    {1, "procedure.samples must be 1 whole number from 1 to 1048576", "procedure.samples = 0\n"},
    {1, "procedure.samples must be 1 whole number from 1 to 1048576", "procedure.samples = 1.5\n"},
    {1, "procedure.samples must be 1 whole number from 1 to 1048576", "procedure.samples = 99999999999999999999\n"},
    {1, "procedure.samples must be 1 whole number from 1 to 1048576", "procedure.samples = 0x\n"},
    {1, "block.k has more than 24 values", "block.k = 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n"},
    {0, "block.k and block.u0 go together", "block.u0 = 1 2 3\n"},
    {0, "block.scale_v_per_g must not be 0", "block.scale_v_per_g = 0\n"},
    {1, "keeper.serial must be a word of at most 24 characters", "keeper.serial = 1234567890123456789012345\n"},
    {1, "keeper.serial must be a word of at most 24 characters", "keeper.serial = TB 0001\n"},
    {1, "keeper.serial must be a word of at most 24 characters", "keeper.serial =\n"},
    {0, "drive.sign must be 1 or -1", "drive.sign = 0\n"},
    {0, "bus.bits_per_second must be 125000, 250000, 500000 or 1000000", "bus.bits_per_second = 300000\n"},
    {1, MOUNTING_WORDS, "mounting = 1 0 0 1 1 0 0 0 1 0 0 0\n"},
    {1, MOUNTING_WORDS, "mounting = 0 0 0 1 1 0 0 0 1 0 0 0 1\n"},
    {1, MOUNTING_WORDS, "mounting = 1 0 0 1 1 0 0 0 1 0 0 0 1 0\n"}, /* no bolting has this number */
    {1, MOUNTING_WORDS, "mounting = 1 0 0 1 1 0 0 0 1 0 0 0 1 256\n"},
    {1, MOUNTING_WORDS, "mounting = 1 0 0 1 1 0 0 0 1 0 0 0 1 1 1\n"},
    {1, "a position is mounting and number (1 to 255), fit or check, and its angle (degrees, sine, cosine)",
     "position = 1 1 use 0 0 1\n"},
    {1, "no such fault; tumble bench --keys lists them", "fault = meteorite at=1.1\n"},
    {1, "a field of the fault is unknown or out of range", "fault = stall at=1.1 colour=red\n"},
    {1, "a field of the fault is unknown or out of range", "fault = stall at=1\n"},
    {1, "a field of the fault is unknown or out of range", "fault = stuck at=1.1 channels=w\n"},
    {1, "a fault is its kind and fields such as at=1.3", "fault = stall now\n"},
    {1, "a fault needs either at=MOUNTING.POSITION or time=SECONDS", "fault = stall\n"},
    {1, "a fault needs either at=MOUNTING.POSITION or time=SECONDS", "fault = stall at=1.1 time=3\n"},
    {1,
     "a PDO is its number (0 to 255), COB-ID, for a transmit PDO inhibit time (100 us) and event timer (ms), and up "
     "to eight objects INDEX:SUBINDEX:BITS; an index is hexadecimal, such as 0x6040",
     "profile.receive_pdo = 0 0x202 6040.16\n"},
    {1, WRITE_WORDS, "profile.write = 0x6081 0 4\n"},
    {1, WRITE_WORDS, "profile.write = 6081 0 4 1\n"}, /* 0x6081, or 0x17C1? */
    {1, "drive.lacks names objects, at most 16 of them; an index is hexadecimal, such as 0x6040",
     "drive.lacks = 0x6084 6085\n"},
};

/* What does not go together, found when the whole is there. */
static const refusal_t INCOMPLETE[] = {
    {0, "a fault names a position that the schedule does not have", "fault = stall at=3.1\n"},
    {0, "a fault of the drive needs the simulated drive",
     "firmware.stand = operator\nfault = drive_power_cycle time=5\n"},
    {0, "a fault of the drive needs the simulated drive", "present.drive = no\nfault = homing_endless at=1.1\n"},
    {0, "a fault of the block needs the simulated block", "present.block = no\nfault = block_power_cycle time=5\n"},
    {0, "a fault of the block needs the simulated block", "present.block = no\nfault = saturated time=5\n"},
    {0, "a fault \"swapped\" needs two channels", "fault = swapped time=1 channels=x\n"},
    {0,
     "the drive profile is not usable: units, times, or a PDO that lacks an object it must carry "
     "or has an identifier that is taken",
     "profile.receive_pdo = 0 0x202 6040:0:16\n"},
    {0, "a mounting matrix is not a proper rotation",
     "mounting = 1 0 0 1 1 0 0 0 1 0 0 0 -1\nposition = 1 1 fit 0 0 1\n"},
    {0, "an angle is out of range or disagrees with its sine and cosine",
     "mounting = 1 0 0 1 1 0 0 0 1 0 0 0 1\nposition = 1 1 fit 10 0 1\n"},
    {0, "the schedule has no positions, or more than fit", "mounting = 1 0 0 1 1 0 0 0 1 0 0 0 1\n"},
};

static void test_mistakes_are_refused_with_their_line(void)
{
    for (size_t i = 0; i < COUNT_OF(REFUSALS); i++) {
        const char *const wrong = read_lines(REFUSALS[i].lines);
        TEST_ASSERT_NOT_NULL_MESSAGE(wrong, REFUSALS[i].lines);
        TEST_ASSERT_EQUAL_STRING_MESSAGE(REFUSALS[i].what, wrong, REFUSALS[i].lines);
        TEST_ASSERT_EQUAL_UINT_MESSAGE(REFUSALS[i].line, mistake.line, REFUSALS[i].lines);
    }
    for (size_t i = 0; i < COUNT_OF(INCOMPLETE); i++) {
        const char *const wrong = read_lines(INCOMPLETE[i].lines);
        TEST_ASSERT_NOT_NULL_MESSAGE(wrong, INCOMPLETE[i].lines);
        TEST_ASSERT_EQUAL_STRING_MESSAGE(INCOMPLETE[i].what, wrong, INCOMPLETE[i].lines);
    }
}

static void test_faults_that_need_no_drive_or_block_are_taken(void)
{
    TEST_ASSERT_NULL(read_lines("firmware.stand = operator\nfault = stall time=5\nfault = slip time=6\n"));
    TEST_ASSERT_NULL(
        read_lines("present.drive = no\npresent.block = no\nfault = bus_off time=5\n"
                   "fault = frame_drop time=5 duration=1\n"));
}

static void test_what_the_firmware_would_refuse_is_known_before(void)
{
    static const refusal_t REFUSED[] = {
        {0, "the configuration is out of range", "procedure.cable_min_deg = 90\nprocedure.cable_max_deg = 90\n"},
        {0, "the configuration is out of range", "procedure.settle_ms = 4096\nprocedure.settle_timeout_ms = 9999\n"},
        {0, "the next position lies beyond the cable's limit", "procedure.cable_max_deg = 20\n"},
        {0, "the schedule is not valid or cannot identify the coefficients",
         "mounting = 1  0 0 1  1 0 0 0 1 0 0 0 1\nposition = 1 1 fit  0 0 1\nprocedure.estimator = least_squares\n"},
    };
    for (size_t i = 0; i < COUNT_OF(REFUSED); i++) {
        TEST_ASSERT_NULL_MESSAGE(read_lines(REFUSED[i].lines), REFUSED[i].lines);
        TEST_ASSERT_EQUAL_STRING_MESSAGE(REFUSED[i].what, bench_config_refused(&config), REFUSED[i].lines);
        config.present.navcomp = false; /* nobody there to refuse it */
        TEST_ASSERT_NULL(bench_config_refused(&config));
    }
    TEST_ASSERT_NULL(read_lines("procedure.settle_ms = 4095\nprocedure.settle_timeout_ms = 9999\n"));
    TEST_ASSERT_NULL(bench_config_refused(&config));
}

static void test_a_line_too_long_is_refused(void)
{
    char lines[1300];
    memset(lines, 'x', sizeof lines);
    lines[sizeof lines - 2U] = '\n';
    lines[sizeof lines - 1U] = '\0';
    TEST_ASSERT_NOT_NULL(read_lines(lines));
    TEST_ASSERT_EQUAL_UINT(1, mistake.line);
}

static void test_more_than_fits_is_refused(void)
{
    char lines[4000] = "";
    for (int i = 0; i < SIM_MAX_FAULTS + 1; i++) {
        (void)strcat(lines, "fault = stall at=1.1\n");
    }
    TEST_ASSERT_EQUAL_STRING("more faults than fit", read_lines(lines));
    TEST_ASSERT_EQUAL_UINT(SIM_MAX_FAULTS + 1U, mistake.line);
}

static void test_blanks_comments_and_the_missing_newline(void)
{
    TEST_ASSERT_NULL(read_lines("  # a comment\n\n\t\n stand.angle_rad\t=  1e-3  \r\nprocedure.samples = 0x20"));
    ASSERT_SAME_DOUBLE(1e-3, config.scenario.stand.angle_rad);
    TEST_ASSERT_EQUAL_UINT32(32, config.procedure.samples);
}

/* Every key takes its lowest and its highest value, alone in its file, and each key's name is there once. */
static void test_every_key_takes_its_whole_range(void)
{
    for (size_t i = 0; i < bench_config_key_count; i++) {
        const bench_key_t *const key = &bench_config_keys[i];
        if (key->name == NULL) {
            continue;
        }
        TEST_ASSERT_EQUAL_PTR_MESSAGE(key, bench_find_key(key->name), key->name);
        if (key->type >= BENCH_BOOL) {
            continue;
        }
        const double ends[] = {key->low, key->high};
        for (size_t end = 0; end < COUNT_OF(ends); end++) {
            char lines[400];
            int length = snprintf(lines, sizeof lines, "%s =", key->name);
            for (int n = 0; n < key->count; n++) {
                length += snprintf(lines + length, sizeof lines - (size_t)length, " %.10g", ends[end]);
            }
            (void)read_lines(lines);
            TEST_ASSERT_TRUE_MESSAGE(mistake.what[0] == '\0' || mistake.line == 0U, lines);
        }
    }
}

/* One key of every type, and the lines that may repeat. */
static void test_values_arrive(void)
{
    bench_config_defaults(&config);
    TEST_ASSERT_EQUAL_STRING("", config.keeping.serial); /* not told */
    TEST_ASSERT_NULL(
        read_lines("stand.limits = uniform\nstand.remount = common\nblock.k = 1 2 3 4 5 6 7 8 9\n"
                   "block.u0 = -1 0 1e-3\naveraging.stillness_ratio = 2.5\nprofile.sign = -1\n"
                   "drive.latches_stale_target = no\nblock.first_counter = 65535\n"
                   "firmware.stand = operator\nprofile.stop = halt\nprocedure.estimator = averaged\n"
                   "profile.transmit_pdo = 1 0x282 20 500 6041:0:16 6064:0:32 6061:0:8\n"
                   "profile.receive_pdo = 3 0x502 607a:0:32 6040:0:16\n"
                   "profile.write = 0x6065 0 4 -1\nkeeper.serial = 123456789012345678901234\n"
                   "keeper.commits = no\nkeeper.first = yes\nkeeper.starts = yes\n"
                   "keeper.drift_per_month = 1 2e-1 3e-1 4e-1 5e-1 6e-1 7e-1 8e-1 9e-1 0 0 0.5\n"));
    TEST_ASSERT_EQUAL_STRING("123456789012345678901234", config.keeping.serial);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_COMMIT_FIRST, config.keeping.settings.limits.flags);
    TEST_ASSERT_EQUAL_HEX8(TUMBLE_SETS_STARTS, config.keeping.settings.flags);
    TEST_ASSERT_TRUE(config.keeping.settings.limits.drift_per_month[11] == 0.5F);
    TEST_ASSERT_EQUAL_INT(SIM_LAW_UNIFORM, config.scenario.stand.law);
    TEST_ASSERT_EQUAL_INT(SIM_REMOUNT_COMMON, config.scenario.stand.remount);
    ASSERT_SAME_DOUBLE(6.0, config.scenario.block.sensor.k_v_per_g[1][2]);
    ASSERT_SAME_DOUBLE(1e-3, config.scenario.block.sensor.u0_v[2]);
    TEST_ASSERT_TRUE(config.scenario.block.given);
    TEST_ASSERT_TRUE(config.averaging.stillness_ratio == 2.5F);
    TEST_ASSERT_EQUAL_INT(-1, config.profile.sign);
    TEST_ASSERT_FALSE(config.scenario.drive.latches_stale_target);
    TEST_ASSERT_EQUAL_UINT16(65535, config.scenario.block.first_counter);
    TEST_ASSERT_EQUAL_INT(BENCH_STAND_OPERATOR, config.stand);
    TEST_ASSERT_EQUAL_UINT8(TUMBLE_STOP_BY_HALT, config.profile.stop);
    TEST_ASSERT_EQUAL_INT(TUMBLE_ESTIMATE_AVERAGED, config.procedure.estimate);
    TEST_ASSERT_EQUAL_UINT8(1, config.profile.transmit_count);
    TEST_ASSERT_EQUAL_UINT8(1, config.profile.transmit[0].number);
    TEST_ASSERT_EQUAL_HEX32(0x282, config.profile.transmit[0].setup.cob_id);
    TEST_ASSERT_EQUAL_UINT16(500, config.profile.transmit[0].setup.event_ms);
    TEST_ASSERT_EQUAL_HEX32(0x60610008, config.profile.transmit[0].setup.map[2]);
    TEST_ASSERT_EQUAL_HEX32(0x607A0020, config.profile.receive[0].setup.map[0]);
    TEST_ASSERT_EQUAL_HEX32(0xFFFFFFFF, config.profile.writes[0].value);
}

static void test_a_fault_line_arrives(void)
{
    TEST_ASSERT_NULL(
        read_lines("fault = noisy at=2.9 phase=settle delay=0.5 duration=2 times=3 channels=xz value=0.25 "
                   "count=7 id=0x683 mask=0x7EF probability=0.5\n"));
    const sim_fault_t *const fault = &config.scenario.faults[0];
    TEST_ASSERT_EQUAL_UINT32(1, config.scenario.fault_count);
    TEST_ASSERT_EQUAL_INT(SIM_FAULT_NOISY, fault->kind);
    TEST_ASSERT_EQUAL_UINT8(2, fault->mounting);
    TEST_ASSERT_EQUAL_UINT8(9, fault->position);
    TEST_ASSERT_EQUAL_INT(SIM_PHASE_SETTLE, fault->phase);
    ASSERT_SAME_DOUBLE(0.5, fault->delay_s);
    ASSERT_SAME_DOUBLE(2.0, fault->duration_s);
    TEST_ASSERT_EQUAL_UINT32(3, fault->times);
    TEST_ASSERT_EQUAL_UINT8(5, fault->channels);
    ASSERT_SAME_DOUBLE(0.25, fault->value);
    TEST_ASSERT_EQUAL_UINT32(7, fault->count);
    TEST_ASSERT_EQUAL_HEX16(0x683, fault->id);
    TEST_ASSERT_EQUAL_HEX16(0x7EF, fault->mask);
    ASSERT_SAME_DOUBLE(0.5, fault->probability);
}

/* A schedule of its own replaces the paper's; its numbers are taken as they are, bit for bit. */
static void test_a_schedule_arrives(void)
{
    TEST_ASSERT_NULL(
        read_lines("mounting = 7  0 0 1  0 1 0  0 0 1  1 0 0\n"
                   "position = 7 1 fit  45 0.70710678118654757 0.70710678118654746\n"
                   "position = 7 2 check  -90 -1 0\n"));
    const tumble_schedule_t *const schedule = config.procedure.schedule;
    TEST_ASSERT_EQUAL_UINT8(1, schedule->mounting_count);
    TEST_ASSERT_EQUAL_UINT8(2, schedule->position_count);
    TEST_ASSERT_EQUAL_UINT8(7, schedule->mountings[0].number);
    TEST_ASSERT_EQUAL_UINT8(0, schedule->mountings[0].bolting);
    ASSERT_SAME_DOUBLE(1.0, schedule->mountings[0].matrix[0][1]);
    ASSERT_SAME_DOUBLE(0.70710678118654757, schedule->positions[0].angle.sine);
    TEST_ASSERT_EQUAL_INT(TUMBLE_USE_CHECK, schedule->positions[1].use);
}

/* The bolting is the one number of a mounting that may be left out. */
static void test_a_bolting_arrives(void)
{
    TEST_ASSERT_NULL(
        read_lines("mounting = 7  0 0 1  1 0 0  0 1 0  0 0 1  255\n"
                   "mounting = 8  0 0 1  1 0 0  0 1 0  0 0 1\n"
                   "position = 7 1 fit  0 0 1\nposition = 8 1 fit  0 0 1\n"
                   "stand.inclination_rad = 5e-3\nstand.sag_across_rad_per_g = -1e-5\n"
                   "stand.sag_along_rad_per_g = 2e-5\n"));
    const tumble_schedule_t *const schedule = config.procedure.schedule;
    TEST_ASSERT_EQUAL_UINT8(2, schedule->mounting_count);
    TEST_ASSERT_EQUAL_UINT8(255, schedule->mountings[0].bolting);
    TEST_ASSERT_EQUAL_UINT8(0, schedule->mountings[1].bolting);
    ASSERT_SAME_DOUBLE(5e-3, config.scenario.stand.inclination_rad);
    ASSERT_SAME_DOUBLE(-1e-5, config.scenario.stand.sag_across_rad_per_g);
    ASSERT_SAME_DOUBLE(2e-5, config.scenario.stand.sag_along_rad_per_g);
}

/* What is left open follows from the rest. */
static void test_the_rest_follows(void)
{
    TEST_ASSERT_NULL(
        read_lines("drive.counts_per_turn = 65536\ndrive.sign = -1\nblock.converter_bits = 16\n"
                   "block.range_v = 5\nblock.noise_v = 1e-3 3e-3 2e-3\nblock.noise_limits = sigma3\n"));
    ASSERT_SAME_DOUBLE(65536.0, config.profile.counts_per_revolution);
    TEST_ASSERT_EQUAL_INT(-1, config.profile.sign);
    ASSERT_SAME_DOUBLE(90.0, config.profile.velocity_deg_s);
    ASSERT_SAME_DOUBLE(-2.0, config.procedure.nominal_scale_v_per_g);
    ASSERT_SAME_DOUBLE(10.0 / 65536.0, config.procedure.v_per_count);
    TEST_ASSERT_EQUAL_INT32(32767, config.averaging.saturation_counts);
    const double noise_counts = 1e-3 / (10.0 / 65536.0); /* the largest limit, a third of it */
    TEST_ASSERT_TRUE(fabs((double)config.averaging.noise_counts - sqrt(noise_counts * noise_counts + 1.0 / 12.0)) <
                     1e-5);
    TEST_ASSERT_NULL(read_lines("block.noise_v = 0 0 0\n"));
    TEST_ASSERT_EQUAL_UINT16(0, config.averaging.stuck_run); /* a quiet block may repeat one value */
}

/* By itself it is a hundred samples; never so long that silence could hide a wrap of the block's counter. */
static void test_the_sample_timeout_follows_from_the_rate(void)
{
    static const struct {
        const char *lines;
        uint32_t expected_ms; /* 0: refused */
    } CASES[] = {
        {"", 1000},
        {"block.sample_period_us = 1000000\n", 100000},
        {"block.sample_period_us = 1000\n", 27},
        {"block.sample_period_us = 1000\nfirmware.heartbeat_ms = 126\n", 1},
        {"block.sample_period_us = 1000\nfirmware.heartbeat_ms = 127\n", 0},
        {"procedure.sample_timeout_ms = 1170\n", 1170},
        {"procedure.sample_timeout_ms = 1171\n", 0},
        {"procedure.sample_timeout_ms = 4294967295\n", 0},
    };
    for (size_t i = 0; i < COUNT_OF(CASES); i++) {
        const char *const wrong = read_lines(CASES[i].lines);
        if (CASES[i].expected_ms == 0U) {
            TEST_ASSERT_NOT_NULL_MESSAGE(wrong, CASES[i].lines);
            TEST_ASSERT_NOT_NULL_MESSAGE(strstr(wrong, "procedure.sample_timeout_ms"), wrong);
        } else {
            TEST_ASSERT_NULL_MESSAGE(wrong, CASES[i].lines);
            TEST_ASSERT_EQUAL_UINT32(CASES[i].expected_ms, config.procedure.sample_timeout_ms);
        }
    }
}
