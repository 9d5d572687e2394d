/* identity.c - the same random inputs through the core's arithmetic, here and on the target: prints a hash of the bits of all
 * results for every function and every block of inputs. identity.py runs it on both and compares.
 *
 * Inputs come from an integer generator (support.h) and the arithmetic of random_schedule.h, compiled into both.
 */
#include "core/vector.h"
#include "random_schedule.h"
#include "target.h"
#include "tumble/core.h"

#define BLOCKS 120U
#define INPUTS_PER_BLOCK 100U
#define EXTRA_POSITIONS 4U

typedef enum {
    AVERAGED,
    REFINED,
    LEAST_SQUARES,
    GAINS,
    INVERSION,
    GRAVITY_CHECK,
    INTRINSIC,
    ADDITION,
    INCLINED,
    U_INCLINED,
    THERMAL,
    U_THERMAL,
    FUNCTIONS
} function_t;

static const char *const names[FUNCTIONS] = {"averaged",  "refined",       "least_squares", "gains",
                                             "inversion", "gravity_check", "intrinsic",     "addition",
                                             "inclined",  "u_inclined",    "thermal",       "u_thermal"};
static uint64_t hashes[FUNCTIONS];
static uint32_t done[FUNCTIONS]; /* how many of the block's inputs were not refused */
static uint32_t left_out;
static random_schedule_t any;
static random_schedule_t shuffled;
static random_schedule_t bolted;
static tumble_means_t means;
static double gains[TUMBLE_COEFFICIENTS * TUMBLE_CHANNELS * TUMBLE_MAX_POSITIONS];

/* FNV-1a. */
static void hash(function_t function, const void *bytes, size_t size)
{
    const uint8_t *byte = bytes;
    for (size_t i = 0; i < size; i++) {
        hashes[function] = (hashes[function] ^ byte[i]) * UINT64_C(0x100000001B3);
    }
}

#ifdef TUMBLE_CANARY
#define SPOILT(function, input) (((function) == REFINED) && ((input) == 742U)) /* as if one result had a wrong bit */
#else
#define SPOILT(function, input) false
#endif

static uint32_t input;

/* The status, and the result if there is one. */
static void hash_result(function_t function, tumble_status_t status, const void *result, size_t size)
{
    const uint8_t number = (uint8_t)status;
    hash(function, &number, sizeof number);
    if (SPOILT(function, input)) {
        hash(function, "", 1);
    }
    if (status == TUMBLE_OK) {
        hash(function, result, size);
        done[function]++;
    }
}

/* Up to 2^(+-span), any bits of fraction. */
static double random_number(dice_t *dice, int32_t span)
{
    const double fraction = dice_signed_unit(dice);
    const uint64_t bits = (uint64_t)(1023 + dice_between(dice, -span, span)) << 52;
    double scale;
    memcpy(&scale, &bits, sizeof scale);
    return fraction * scale;
}

static void random_means(dice_t *dice, int32_t span)
{
    const bool complete = (dice_below(dice, 4) != 0U);
    for (int p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
        means.measured[p] = complete || (dice_below(dice, 16) != 0U);
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            means.u_v[p][i] = random_number(dice, span);
        }
    }
}

/* The paper's positions in any order, some others between them. */
static void shuffle_paper(dice_t *dice)
{
    uint8_t count = 18;
    memcpy(shuffled.mountings, tumble_schedule_paper.mountings, 2U * sizeof shuffled.mountings[0]);
    memcpy(shuffled.positions, tumble_schedule_paper.positions, 18U * sizeof shuffled.positions[0]);
    for (; count < 18U + EXTRA_POSITIONS; count++) {
        shuffled.positions[count] = (tumble_position_t){(uint8_t)(1U + dice_below(dice, 2)), (uint8_t)(100U + count),
                                                        TUMBLE_USE_FIT, steps_of_7_5_deg[dice_below(dice, STEP_COUNT)]};
    }
    for (uint32_t p = count - 1U; p > 0U; p--) {
        const uint32_t other = dice_below(dice, p + 1U);
        const tumble_position_t held = shuffled.positions[p];
        shuffled.positions[p] = shuffled.positions[other];
        shuffled.positions[other] = held;
    }
    shuffled.schedule = (tumble_schedule_t){shuffled.mountings, shuffled.positions, 2, count};
}

static void try_estimators(dice_t *dice)
{
    tumble_coefficients_t found;
    tumble_status_t status = tumble_estimate_averaged(&shuffled.schedule, &means, &found, NULL);
    hash_result(AVERAGED, status, &found, sizeof found);
    status = tumble_estimate_refined(&shuffled.schedule, &means, &found, NULL);
    hash_result(REFINED, status, &found, sizeof found);
    status = tumble_estimate_least_squares(&any.schedule, &means, &found, NULL);
    hash_result(LEAST_SQUARES, status, &found, sizeof found);
    const tumble_gain_table_t table = {gains, count_fit_positions(&any.schedule), 0.0};
    for (size_t g = 0; g < COUNT_OF(gains); g++) {
        gains[g] = random_number(dice, 8);
    }
    status = tumble_estimate_gains(&table, &any.schedule, &means, &found);
    hash_result(GAINS, status, &found, sizeof found);
}

/* |a|^2 from 2^-33 to 2^-32, where |a|^2 - 1 is a sum that the target's library fails for: its errors of gravity are left out
 * of the hash, and counted. No position of a stand has that (|a| near 1e-5 g). */
static void leave_out_misrounded(const tumble_calibration_t *calibration, tumble_gravity_check_t *check)
{
    for (uint8_t p = 0; p < any.schedule.position_count; p++) {
        double a[TUMBLE_CHANNELS];
        tumble_calibration_apply(calibration, means.u_v[p], a);
        const double square = tumble_dot(a, a);
        if (means.measured[p] && (square >= 0x1p-33) && (square <= 0x1p-32)) {
            check->delta_g_g[p] = 0.0;
            left_out++;
        }
    }
}

static void try_calibration(dice_t *dice, int32_t span)
{
    tumble_coefficients_t coefficients;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            coefficients.k_v_per_g[i][j] = random_number(dice, span) + ((i == j) ? 2.0 : 0.0);
        }
        coefficients.u0_v[i] = random_number(dice, span);
    }
    tumble_intrinsic_t intrinsic;
    tumble_status_t status = tumble_calibration_intrinsic(&coefficients, &intrinsic);
    hash_result(INTRINSIC, status, &intrinsic, sizeof intrinsic);
    tumble_calibration_t calibration;
    status = tumble_calibration_invert(&coefficients, &calibration);
    hash_result(INVERSION, status, &calibration, sizeof calibration);
    if (status == TUMBLE_OK) {
        tumble_gravity_check_t check;
        status = tumble_gravity_check(&any.schedule, &means, &calibration, 3e-4, &check);
        leave_out_misrounded(&calibration, &check);
        hash_result(GRAVITY_CHECK, status, check.delta_g_g, sizeof check.delta_g_g);
    }
}

/* Three or more inclinations of one bolting at four or eight angles each; no inclination is near the level, where
 * 1 - sin^2 is a sum that the target's library fails for (see below). */
static void incline(dice_t *dice)
{
    static const tumble_angle_t tilts[] = {{30.0, 0.5, 0.86602540378443865},
                                           {-30.0, -0.5, 0.86602540378443865},
                                           {-10.0, -0.17364817766693036, 0.98480775301220802},
                                           {20.0, 0.34202014332566871, 0.93969262078590843}};
    const uint8_t inclinations = (uint8_t)(3U + dice_below(dice, 2));
    const uint32_t stride = 6U * (1U + dice_below(dice, 2)); /* 45 or 90 degrees */
    const uint32_t first = dice_below(dice, 6);
    uint8_t count = 0;
    double matrix[3][3];
    random_rotation(dice, matrix);
    for (uint8_t m = 0; m < inclinations; m++) {
        bolted.mountings[m] = (tumble_mounting_t){.number = (uint8_t)(m + 1U), .tilt = tilts[m], .bolting = 1};
        memcpy(bolted.mountings[m].matrix, matrix, sizeof matrix);
        for (uint32_t step = first; step < (first + 48U); step += stride) {
            bolted.positions[count] =
                (tumble_position_t){(uint8_t)(m + 1U), (uint8_t)(count + 1U), TUMBLE_USE_FIT, steps_of_7_5_deg[step]};
            count++;
        }
    }
    bolted.schedule = (tumble_schedule_t){bolted.mountings, bolted.positions, inclinations, count};
}

/* A block, its outputs with some noise, and now and then one that is none of its. */
static void try_inclined(dice_t *dice)
{
    static const tumble_stand_record_t stand = {.remount_rad = 4e-4, .angle_rad = 4e-5, .noise_v = 3e-4, .samples = 50};
    const double weights[TUMBLE_CHANNELS] = {1.0, 1.5 + dice_signed_unit(dice), 3.0};
    tumble_coefficients_t found = random_block(dice);
    tumble_inclinations_t seen;
    incline(dice);
    model_means(&bolted.schedule, &found, &means);
    for (uint8_t p = 0; p < bolted.schedule.position_count; p++) {
        const double noise_v = (dice_below(dice, 400) == 0U) ? 1e3 : 1e-3;
        means.u_v[p][p % 3U] += noise_v * dice_signed_unit(dice);
    }
    tumble_status_t status = tumble_inclined_weighted(&bolted.schedule, &means, weights, &found, &seen, NULL);
    hash_result(INCLINED, status, &found, sizeof found);
    if (status == TUMBLE_OK) {
        tumble_uncertainty_t stated = {0};
        const tumble_judged_run_t run = {.schedule = &bolted.schedule,
                                         .stand = &stand,
                                         .coefficients = &found,
                                         .only = (uint16_t)(1U << (input % TUMBLE_COEFFICIENTS)),
                                         .inclinations = &seen,
                                         .weights = weights};
        status = tumble_uncertainty_inclined(&run, &stated, NULL);
        hash_result(U_INCLINED, status, &stated, sizeof stated);
    }
}

/* Sums next to a power of two, where the library of the target is known to fail for one difference of the exponents, 33:
 * that one is left out here, and looked at by misrounded_sums. */
static void random_twelve(dice_t *dice, void *twelve, double size, bool positive)
{
    double numbers[TUMBLE_COEFFICIENTS];
    for (int c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const double number = size * random_number(dice, 3);
        numbers[c] = positive ? magnitude(number) : number;
    }
    memcpy(twelve, numbers, sizeof numbers);
}

/* A run moves the polynomials, and these give a calibration elsewhere. */
static void try_thermal(dice_t *dice)
{
    tumble_thermal_t thermal = {.reference_c = 20.0 * dice_signed_unit(dice), .lowest_c = -64.0, .highest_c = 63.5};
    tumble_coefficients_t coefficients;
    tumble_uncertainty_t u;
    tumble_uncertainty_t growth;
    tumble_uncertainty_t u_run;
    tumble_calibration_t calibration;
    for (int m = 0; m < TUMBLE_THERMAL_POWERS; m++) {
        random_twelve(dice, &thermal.power[m], (m == 0) ? 1.0 : (m == 1) ? 0x1p-13 : 0x1p-21, false);
    }
    random_twelve(dice, &coefficients, 1.0, false);
    random_twelve(dice, &u, 1e-5, true);
    random_twelve(dice, &growth, 1e-5, true);
    random_twelve(dice, &u_run, 1e-5, true);
    const tumble_thermal_run_t run = {70.0 * dice_signed_unit(dice), &coefficients, &u_run};
    tumble_status_t status = tumble_thermal_update(&thermal, &u, &growth, &run);
    hash_result(U_THERMAL, status, &u, sizeof u);
    status = tumble_thermal_calibration(&thermal, 70.0 * dice_signed_unit(dice), &calibration);
    hash_result(THERMAL, status, &calibration, sizeof calibration);
}

static void try_additions(dice_t *dice)
{
    for (int32_t difference = 0; difference < 64; difference++) {
        const uint64_t small_bits = ((uint64_t)(1023 - difference) << 52) | (dice_u64(dice) >> 12);
        double small;
        memcpy(&small, &small_bits, sizeof small);
        volatile double x = 1.0 + (double)dice_below(dice, 2) * 0x1p-52;
        volatile double y = (dice_below(dice, 2) == 0U) ? small : -small;
        const double sum = (difference == 33) ? 0.0 : (x + y);
        hash_result(ADDITION, TUMBLE_OK, &sum, sizeof sum);
    }
}

/* Of 4096 differences 1 - y with y from 2^-33 to 2^-32, those that are not the nearest double. All is exact in integers:
 * y = fraction / 2^85, and the ulp below 1 is 2^-53. */
static uint32_t misrounded_sums(dice_t *dice)
{
    uint32_t wrong = 0;
    for (int i = 0; i < 4096; i++) {
        const uint64_t fraction = (UINT64_C(1) << 52) | (dice_u64(dice) >> 12);
        const uint64_t bits = ((uint64_t)(1023 - 33) << 52) | (fraction & ((UINT64_C(1) << 52) - 1U));
        double small;
        memcpy(&small, &bits, sizeof small);
        volatile double y = small;
        volatile double difference = 1.0 - y;
        const uint64_t half = UINT64_C(1) << 31;
        const uint64_t down = (fraction + half) >> 32; /* in units of 2^-53, ties aside */
        const bool tie = ((fraction + half) & 0xFFFFFFFFU) == 0U;
        wrong += (!tie && (difference != 1.0 - (double)down * 0x1p-53)) ? 1U : 0U;
    }
    return wrong;
}

static void put(const char *text)
{
    for (; *text != '\0'; text++) {
        target_put(*text);
    }
}

static void put_number(uint64_t number, int digits)
{
    put(" ");
    for (int digit = digits - 1; digit >= 0; digit--) {
        target_put("0123456789abcdef"[(number >> (4 * digit)) & 15U]);
    }
}

int main(void)
{
    for (uint32_t block = 0; block < BLOCKS; block++) {
        memset(hashes, 0xCB, sizeof hashes);
        memset(done, 0, sizeof done);
        for (input = block * INPUTS_PER_BLOCK; input < (block + 1U) * INPUTS_PER_BLOCK; input++) {
            dice_t dice = {input};
            const int32_t span = (dice_below(&dice, 4) == 0U) ? 60 : 3;
            random_schedule(&dice, &any);
            shuffle_paper(&dice);
            random_means(&dice, span);
            try_estimators(&dice);
            try_calibration(&dice, (span == 60) ? 12 : 0);
            try_additions(&dice);
            try_inclined(&dice);
            try_thermal(&dice);
        }
        for (int function = 0; function < FUNCTIONS; function++) {
            put(names[function]);
            put_number(block, 4);
            put_number(done[function], 4);
            put_number(hashes[function], 16);
            put("\n");
        }
    }
    dice_t dice = {33};
    put("left_out");
    put_number(left_out, 4);
    put("\nmisrounded");
    put_number(misrounded_sums(&dice), 4);
    put("\n");
    return 0;
}
