/* tumble/core.h - the mathematics of a calibration: from raw samples to coefficients that are checked and known to be
 * good.
 *
 * A block puts out U = U0 + K a: three outputs U (V), a 3 x 3 matrix K (V per g), a bias U0 (V), the specific force a
 * (g). The twelve coefficients come from mean outputs at known test positions in gravity. In the order of use:
 *
 *     schedule       the test positions: mountings of the block, angles of the table
 *     averaging      samples of a position to a mean, by exact integer sums, through gates
 *     blocks         samples of a run to the standard errors of its means, if their noise is not white
 *     estimators     means to K and U0: averaged, refined, least_squares, or optimal by a gain record
 *     calibration    K and U0 inverted: outputs to specific force
 *     over temperature    K and U0 as polynomials of the block's temperature
 *     verification   the gravity check: does the calibrated block find 1 g at every position?
 *     uncertainty    how far K and U0 may be from the truth, from what the stand is declared to be
 *     the stand seen, the whole model, misfit    what the run itself says about the stand
 *
 * The shortest program, for means that have been measured already:
 *
 *     tumble_means_t means = {0};                       // u_v in V, measured = true, position by position
 *     tumble_coefficients_t found;
 *     tumble_calibration_t calibration;
 *     tumble_gravity_check_t check;
 *     if ((tumble_estimate_refined(&tumble_schedule_paper, &means, &found, NULL) == TUMBLE_OK) &&
 *         (tumble_calibration_invert(&found, &calibration) == TUMBLE_OK) &&
 *         (tumble_gravity_check(&tumble_schedule_paper, &means, &calibration, 3e-4, &check) == TUMBLE_OK) &&
 *         check.pass) {
 *         double a_g[TUMBLE_CHANNELS];
 *         tumble_calibration_apply(&calibration, means.u_v[0], a_g);
 *     }
 *
 * All functions are pure: no clock, no I/O, no allocation, no libm but the square root. They keep nothing outside the
 * memory that the caller owns. They may be called from anywhere, also at the same time on different objects. A function
 * that refuses leaves its outputs as they were, unless its own comment says otherwise. No pointer may be null unless its
 * comment says that it may; a null is refused, with TUMBLE_E_ARGUMENT, only where the comment says so. Formulas in
 * brackets, such as (7), are those of Chernyak, Rybak, Paliushok, "Ensuring the given accuracy of calibrating a three-axis
 * block of navigation accelerometers on a single-axis rotary stand"; docs/method.md derives the others.
 */
#ifndef TUMBLE_CORE_H
#define TUMBLE_CORE_H

#include "tumble/status.h"
#include "tumble/version.h"

#include <assert.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- The compiler's arithmetic. */

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "compile without -ffast-math and -ffinite-math-only: results would differ, and what is not a number would pass"
#endif

static_assert(sizeof(double) == 8U, "a double has 64 bits");
static_assert(sizeof(1.0) == sizeof(double), "compile without -fsingle-precision-constant: results would differ");

/* ---- Sizes: compile-time constants, and the relations between them that must hold. ---- */

#define TUMBLE_CHANNELS 3
#define TUMBLE_COEFFICIENTS 12 /* K row by row, then U0 */
#define TUMBLE_UNKNOWNS 4      /* of one channel: K_ix, K_iy, K_iz, U0_i */
#define TUMBLE_MAX_POSITIONS 36
#define TUMBLE_MAX_MOUNTINGS TUMBLE_MAX_POSITIONS /* each position may have one of its own: any attitudes */
#define TUMBLE_MAX_YAWS 6 /* mountings of a schedule, where each has unknowns: optimal, the fit of the stand seen */

/* Averaging. A raw count is any int32; a sample may lie this far from the first one of its position. */
#define TUMBLE_MAX_SAMPLES (INT64_C(1) << 20)
#define TUMBLE_MAX_DEVIATION_COUNTS (INT64_C(1) << 21)

static_assert(TUMBLE_MAX_POSITIONS >= 18, "the default schedule must fit");
static_assert(TUMBLE_MAX_POSITIONS <= UINT8_MAX, "a position index is one byte");

/* The sum of counts must be exact as a double, or the mean would be rounded twice. */
static_assert(TUMBLE_MAX_SAMPLES <= (INT64_C(1) << 53) / (INT64_C(1) << 31),
              "a sum of int32 counts must stay within 2^53");

/* The sum of squared deviations must fit 64 bits for any allowed number of samples. */
static_assert(TUMBLE_MAX_SAMPLES <= INT64_MAX / (TUMBLE_MAX_DEVIATION_COUNTS * TUMBLE_MAX_DEVIATION_COUNTS),
              "a sum of squared deviations must fit an int64");

/* ---- Schedules: test positions: how the block is mounted and how far the table is turned.
 *
 * A schedule is constant data that the caller owns; these functions only read it.
 *
 * Frames. The table frame turns with the table: h horizontal across the axis, n along the axis, v up at angle 0.
 * There the specific force of gravity, in units of local g, is the unit vector
 *
 *     f = (cos t sin p,  sin t,  cos t cos p)       p: table angle, t: known tilt of the axis (0 on a level stand)
 *
 * and the block feels a = M f, with M the matrix of the mounting: its rows are the block axes x, y, z in (h, n, v).
 *
 * The core has no trigonometry (libraries differ in the last bit): every angle comes with its sine and cosine as
 * data, and validation checks that the three agree.
 */

/* An angle as data. Range -3600 to 3600 degrees; sine and cosine good to 1e-12. */
typedef struct {
    double deg;
    double sine;
    double cosine;
} tumble_angle_t;

/* `bolting` stands last, so that initialisers by position from before it stay good. */
typedef struct {         /* NOLINT(clang-analyzer-optin.performance.Padding) */
    uint8_t number;      /* what people call it: 1, 2, ... unique in the schedule */
    double matrix[3][3]; /* proper rotation, orthonormal to 1e-9; rows: block axes x, y, z; columns: h, n, v */
    tumble_angle_t tilt; /* known tilt of the axis out of the horizontal; {0, 0, 1} on a level stand */
    uint8_t bolting; /* mountings in a row with the same number, above 0, are inclinations of a block that is bolted on
                      * once: one matrix, one seat, one yaw. 0: bolted on for itself */
} tumble_mounting_t;

typedef enum {
    TUMBLE_USE_FIT = 0,  /* measured, used by the estimator, judged */
    TUMBLE_USE_CHECK = 1 /* measured and judged only */
} tumble_use_t;

typedef struct {
    uint8_t mounting; /* number of a mounting of this schedule */
    uint8_t number;   /* unique within its mounting */
    tumble_use_t use;
    tumble_angle_t angle;
} tumble_position_t;

typedef struct {
    const tumble_mounting_t *mountings;
    const tumble_position_t *positions;
    uint8_t mounting_count; /* 1 to TUMBLE_MAX_MOUNTINGS */
    uint8_t position_count; /* 1 to TUMBLE_MAX_POSITIONS */
} tumble_schedule_t;

/* The mean outputs of a run, one row per position of the schedule, in the schedule's order. A row is read only where
 * `measured` is true. The unit is the caller's (volts here); the coefficients come out in that unit. */
typedef struct {
    double u_v[TUMBLE_MAX_POSITIONS][TUMBLE_CHANNELS];
    bool measured[TUMBLE_MAX_POSITIONS];
} tumble_means_t;

/* The schedule of the paper: two mountings, nine positions each, table angle (l - 1) * 45 degrees for l = 1..9. Order:
 * mounting 1 at 0, 45, ... 360 degrees, then mounting 2 likewise.
 * Mounting 1: block axes x, y, z along h, n, v (the identity). Mounting 2: x, y, z along -h, v, n; that is mounting 1
 * turned by 180 degrees about the bisector of the block's y and z axes. */
extern const tumble_schedule_t tumble_schedule_paper;

/* The paper's schedule and a third mounting like it, x, y, z along n, v, h: every pair of block axes shares a circle, so
 * the length of a measured acceleration does not depend on how square stand and block are (docs/method.md). 27 positions.
 */
extern const tumble_schedule_t tumble_schedule_three_mountings;

/* The same three mountings, each at 45, 135, 225 and 315 degrees: as good on a square stand as the paper's, with 12
 * positions. With a closure: at the end of each mounting 45 degrees once more, to check only. */
extern const tumble_schedule_t tumble_schedule_diagonal;
extern const tumble_schedule_t tumble_schedule_diagonal_closed;

/* A block that is laid by hand on its six faces, without a stand: x up, x down, y up, y down, z up, z down, each a mounting
 * of its own with one position. Only tumble_estimate_least_squares and gains solve it. */
extern const tumble_schedule_t tumble_schedule_hand_laid;

/* Each face of the block up once, in the paper's two mountings, with the numbers that these positions have there. Only
 * tumble_estimate_least_squares and gains solve it. */
extern const tumble_schedule_t tumble_schedule_six_faces;

/* A block that is bolted on once, as in mounting 1, on a stand that is inclined: to 0, 45 and -45 degrees,
 * not measured, as mountings 1 to 3 of one bolting; each at 0, 45, ... 315 degrees, and 360 to check. `closed`: at the end
 * level again, as a fourth. Only tumble_estimate_inclined and gains solve them. */
extern const tumble_schedule_t tumble_schedule_inclined;
extern const tumble_schedule_t tumble_schedule_inclined_closed;

/* Is this schedule usable data? Checks the sizes, then every mounting (number, rotation, tilt), then every position
 * (mounting, number, use, angle), and stops at the first fault. `where` (may be null) then receives the index of that
 * mounting or position; it is left alone when the fault has no place.
 * Returns TUMBLE_OK, TUMBLE_E_SCHEDULE_SIZE, TUMBLE_E_SCHEDULE_ROTATION, TUMBLE_E_SCHEDULE_ANGLE,
 * TUMBLE_E_SCHEDULE_MOUNTING, TUMBLE_E_SCHEDULE_DUPLICATE, or TUMBLE_E_ARGUMENT (null, or a `use` outside its list).
 * Every other function expects a schedule that passed. */
tumble_status_t tumble_schedule_validate(const tumble_schedule_t *schedule, uint8_t *where);

/* Index of the position with these numbers, or position_count if there is none. */
uint8_t tumble_schedule_find(const tumble_schedule_t *schedule, uint8_t mounting, uint8_t position);

/* Index of a mounting by its number, or mounting_count if there is none. */
uint8_t tumble_schedule_find_mounting(const tumble_schedule_t *schedule, uint8_t number);

/* The mounting that the position at `index` is measured in. `index` below position_count, validated schedule. */
const tumble_mounting_t *tumble_schedule_mounting_of(const tumble_schedule_t *schedule, uint8_t index);

/* Does the block stay bolted on from the mounting before to the mounting at `index`, so that the stand is inclined only?
 * Their boltings are one number above 0. `index` below mounting_count. */
bool tumble_schedule_stays_bolted(const tumble_schedule_t *schedule, uint8_t index);

/* At how many mountings does it stay bolted on? All but the first: it is bolted on once, and the stand is inclined. */
uint8_t tumble_schedule_count_bolted(const tumble_schedule_t *schedule);

/* Specific force a (g) on the block axes x, y, z at the position at `index`, on the ideal stand. */
void tumble_schedule_attitude(const tumble_schedule_t *schedule, uint8_t index, double a_g[TUMBLE_CHANNELS]);

/* Can these positions identify all twelve coefficients? Uses the fit positions, and of those only the measured ones
 * when `measured` is not null (one flag per position). The three channels share one design, so the answer is four bits:
 * bit 0..2 for K_ix, K_iy, K_iz, bit 3 for U0_i of every channel i; set in `unidentified` (may be null) when that
 * coefficient is not determined.
 * Returns TUMBLE_OK, TUMBLE_E_RANK, or TUMBLE_E_ARGUMENT (null schedule). */
tumble_status_t tumble_schedule_identify(const tumble_schedule_t *schedule, const bool *measured,
                                         uint8_t *unidentified);

/* Identification takes the columns of the design one by one: first the strongest, then always the one that those taken
 * before explain least. A coefficient counts as identified if the unexplained rest of its column has at least this root
 * mean square over the positions. Below it the noise of a mean would be magnified about a thousandfold. */
#define TUMBLE_MIN_SENSITIVITY_G 1e-3

#define TUMBLE_STEPS 9U /* 0, 45, ... 360 degrees */
#define TUMBLE_MAX_CIRCLES (TUMBLE_MAX_POSITIONS / 4)

/* One of the circles that a schedule holds for the closed forms: what a mounting offers to them. */
typedef struct {
    uint8_t index[TUMBLE_STEPS]; /* by step: of the position in the schedule */
    uint8_t stride;              /* 1: all nine steps count; 2: the diagonals alone, every second from 45 degrees on */
    uint8_t normal;              /* the block axis along the stand's axis, normal to the circle */
    uint8_t mounting;            /* by its index */
} tumble_circle_t;

/* All of them. It is the same for every run of a schedule, so a program may keep it, together with the schedule. */
typedef struct {
    const tumble_schedule_t *schedule;
    uint8_t circles[TUMBLE_CHANNELS]; /* how many have the block's x, y, z normal to them */
    uint8_t count;
    tumble_circle_t circle[TUMBLE_MAX_CIRCLES];
} tumble_harmonic_map_t;

/* Find the circles of a schedule by geometry (matrix, tilt, angle), whatever their numbers. A mounting is one if a block
 * axis lies along the level axis of the stand, so that the circle lies in the two others, and if its fit positions hold
 * either all nine table angles 0, 45, ... 360 degrees or of these exactly the four diagonals 45, 135, 225, 315. Other
 * positions and mountings do no harm. Every block axis must lie in some circle: two different ones are enough. With
 * `measured` (may be null) only measured positions count; of several at one angle the first does.
 * `map` means something on TUMBLE_OK alone. `missing` (may be null) receives one bit for every position of the schedule
 * that is needed and was not measured, by its index, also on a refusal.
 * Returns TUMBLE_OK; TUMBLE_E_NOT_HARMONIC when the schedule itself lacks circles; TUMBLE_E_MISSING_POSITION when it has
 * them but not all positions are measured; TUMBLE_E_ARGUMENT (null). */
tumble_status_t tumble_schedule_harmonic(const tumble_schedule_t *schedule, const bool *measured,
                                         tumble_harmonic_map_t *map, uint64_t *missing);

/* What a schedule offers to the estimator `inclined`: the inclinations of one bolting that positions are fitted at, in the
 * schedule's order. */
typedef struct {
    const tumble_schedule_t *schedule;
    uint8_t count;
    uint8_t highest; /* places below `count`: of the largest and of the smallest nominal inclination */
    uint8_t lowest;
    uint8_t mounting[TUMBLE_MAX_YAWS]; /* by their indices in the schedule */
    uint8_t positions[TUMBLE_MAX_YAWS];
} tumble_inclined_map_t;

/* Find them: three or more mountings of one `bolting`, with tilts on both sides of the level, whose fit positions divide a
 * turn of the table equally; fit positions in other mountings must not be there. `measured` and `missing` as for
 * tumble_schedule_harmonic.
 * Returns TUMBLE_OK; TUMBLE_E_NOT_INCLINED when the schedule has them not; TUMBLE_E_MISSING_POSITION; TUMBLE_E_ARGUMENT
 * (null). */
tumble_status_t tumble_schedule_inclinations(const tumble_schedule_t *schedule, const bool *measured,
                                             tumble_inclined_map_t *map, uint64_t *missing);

/* ---- Averaging: exact integer averaging of raw samples, position by position, with gates.
 *
 * Integer arithmetic only in the sample path: sums are exact, so a mean is one correctly rounded division of two exact
 * numbers, the same on every target and for every order of the samples. The caller owns the state (one per block of
 * accelerometers) and the configuration. The state holds no pointer to it: keep the configuration that
 * tumble_averaging_init has checked, and give the same to add, finish and restore, which do not check it again. Not
 * re-entrant on one state; no other state is touched.
 *
 * Life of a position: begin, add (or accumulate) for every sample, finish. `finish` judges the gates; a position that
 * fails them is left empty and may be begun again. Every sample that a gate refuses or that is missing is counted. A
 * sample that comes while no position is open, or when the position is full, is a mistake of the caller: the status
 * says so, and nothing counts it.
 */

typedef struct {
    int32_t counts[TUMBLE_CHANNELS];
    uint16_t counter; /* the block's own sample counter; grows by one per sample and wraps */
    uint8_t status;   /* what the block says of the sample; 0: healthy. Any other is refused */
} tumble_sample_t;

typedef struct {
    int32_t saturation_counts; /* at or beyond +- this a sample is refused; 1 to INT32_MAX */
    uint32_t min_samples;      /* of a finished position; 1 to TUMBLE_MAX_SAMPLES */
    uint16_t max_lost;         /* samples that may be missing from a position */
    uint16_t stuck_run;        /* equal values in a row that call a channel stuck, or all of a position with fewer
                                * samples (but more than one); at least 2, or 0: gate off */
    float noise_counts;        /* declared standard deviation of one sample, finite; 0: unknown, stillness gate off */
    float stillness_ratio;     /* scatter over declared noise that still counts as still; finite, above 0, also
                                * where the gate is off */
} tumble_averaging_config_t;

/* Monotonic since init, over all positions; they stop at UINT32_MAX instead of wrapping. */
typedef struct {
    uint32_t saturated;
    uint32_t deviating;
    uint32_t repeated;
    uint32_t reordered;
    uint32_t lost;
} tumble_averaging_counters_t;

/* One finished position. samples == 0: empty. */
typedef struct {
    int64_t sum_counts[TUMBLE_CHANNELS];
    uint32_t samples;
    float scatter_counts[TUMBLE_CHANNELS]; /* standard deviation of one sample, n - 1; 0 for a single one */
} tumble_average_t;

/* The open position. */
typedef struct {
    uint8_t index;
    uint8_t faults; /* bits private to accumulator.h */
    uint16_t last_counter;
    uint32_t lost;
    int64_t square_sum[TUMBLE_CHANNELS]; /* of deviations from `first` */
    int32_t first[TUMBLE_CHANNELS];
    int32_t last[TUMBLE_CHANNELS];
    uint16_t run[TUMBLE_CHANNELS]; /* how often `last` has come in a row */
} tumble_open_position_t;

typedef struct {
    tumble_open_position_t open;
    tumble_averaging_counters_t counters;
    tumble_average_t averages[TUMBLE_MAX_POSITIONS];
} tumble_averaging_t;

static_assert(sizeof(tumble_averaging_t) <= ((40U * TUMBLE_MAX_POSITIONS) + 96U), "a position costs 40 bytes of RAM");

/* Empty every position and zero the counters.
 * Returns TUMBLE_OK or TUMBLE_E_ARGUMENT (null, or a configuration out of range). */
tumble_status_t tumble_averaging_init(tumble_averaging_t *averaging, const tumble_averaging_config_t *config);

/* Open the position at `index` of the schedule, forgetting what it held; an open one is abandoned and left empty.
 * Returns TUMBLE_OK or TUMBLE_E_ARGUMENT (null, or index not below TUMBLE_MAX_POSITIONS). */
tumble_status_t tumble_averaging_begin(tumble_averaging_t *averaging, uint8_t index);

/* Take one sample through the gates. Refused samples are counted and change neither sums nor scatter; missing counter
 * values are counted as lost, and the sample itself is taken. A gap of 32768 or more reads as a step backwards: the
 * caller's timeout must come long before. Returns TUMBLE_OK, TUMBLE_E_NOT_OPEN, TUMBLE_E_FULL (TUMBLE_MAX_SAMPLES),
 * TUMBLE_E_UNHEALTHY (the block marks the sample as faulty), TUMBLE_E_REPEATED, TUMBLE_E_REORDERED,
 * TUMBLE_E_SATURATED, TUMBLE_E_DEVIATION.
 * After TUMBLE_E_UNHEALTHY end the position: the sample is not counted and its counter value is not taken. If you go on,
 * that value counts as lost with the next sample (unless no sample of the position came before). */
tumble_status_t tumble_averaging_add(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                     const tumble_sample_t *sample);

/* Take one sample without gates, for a caller that has gates of its own: sums and scatter only. (With
 * tumble_averaging_add the configuration can switch off the stuck and the stillness gate; the others always judge.)
 * The caller guarantees that a position is open and not full, and that deviations stay within
 * TUMBLE_MAX_DEVIATION_COUNTS. */
void tumble_averaging_accumulate(tumble_averaging_t *averaging, const int32_t counts[TUMBLE_CHANNELS]);

/* Close the open position and judge it. On any refusal the position is left empty.
 * Returns TUMBLE_OK, TUMBLE_E_NOT_OPEN, and in this order: TUMBLE_E_SATURATED, TUMBLE_E_DEVIATION (such a sample was
 * refused: the mean would be biased), TUMBLE_E_LOST, TUMBLE_E_TOO_FEW, TUMBLE_E_STUCK, TUMBLE_E_NOT_STILL. */
tumble_status_t tumble_averaging_finish(tumble_averaging_t *averaging, const tumble_averaging_config_t *config);

/* Put back a position that `finish` had accepted and that was kept elsewhere meanwhile, over a loss of power. An open
 * position is abandoned and left empty. The position must pass the gates that can still be judged; on any refusal it is
 * left empty.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT (null, the index, a sum that so many samples below saturation cannot have, more
 * than TUMBLE_MAX_SAMPLES, a scatter that is negative or not finite), TUMBLE_E_TOO_FEW, TUMBLE_E_STUCK,
 * TUMBLE_E_NOT_STILL. */
tumble_status_t tumble_averaging_restore(tumble_averaging_t *averaging, const tumble_averaging_config_t *config,
                                         uint8_t index, const tumble_average_t *average);

/* Samples in the open position so far; 0 when none is open. */
uint32_t tumble_averaging_samples(const tumble_averaging_t *averaging);

/* Mean (counts) of the open position so far and its standard error, for progress and for stopping early.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_OPEN, or TUMBLE_E_TOO_FEW below two samples (the error is not
 * known yet). */
tumble_status_t tumble_averaging_running(const tumble_averaging_t *averaging, double mean_counts[TUMBLE_CHANNELS],
                                         double standard_error_counts[TUMBLE_CHANNELS]);

/* Mean (counts) of the finished position at `index`, correctly rounded, and its standard error scatter / sqrt(n).
 * `standard_error_counts` may be null.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, or TUMBLE_E_MISSING_POSITION when the position is empty. */
tumble_status_t tumble_averaging_mean(const tumble_averaging_t *averaging, uint8_t index,
                                      double mean_counts[TUMBLE_CHANNELS],
                                      double standard_error_counts[TUMBLE_CHANNELS]);

/* All finished positions as means in volts, ready for an estimator; the others are marked as not measured.
 * `v_per_count` finite and not 0.
 * Returns TUMBLE_OK or TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_averaging_means(const tumble_averaging_t *averaging, double v_per_count, tumble_means_t *means);

/* ---- Estimators: from position means to the twelve coefficients of U = U0 + K a.
 *
 * K in volts per g (unit of the means per unit of local gravity), U0 in volts. Outputs are written only on TUMBLE_OK.
 * The formulas are exact for an ideal stand, to rounding; every position counts as one mean whatever its number of
 * samples. A measured mean that is not a number, or beyond TUMBLE_MAX_MEAN_V, is TUMBLE_E_NOT_FINITE, so no result can
 * overflow. Source: formulas (3) and (7); s and b follow from the same harmonic pattern.
 */

#define TUMBLE_MAX_MEAN_V 1e100

/* The table of estimators: number, name, what it needs of a schedule, the functions that estimate and that state
 * uncertainties. C reads it here, Python through its extension; tools/estimators writes the names into the package and
 * the schemas. An estimator's number is its place in the list and travels over CAN: new ones go to the end. Those of LENT
 * a board lends with data of its own (tumble_optimal_estimate, tumble_inclined_estimate and what follows them), so that
 * images without them do not link them. */
#define TUMBLE_ESTIMATOR_LIST(ONE, LENT)                                                                               \
    ONE(AVERAGED, averaged, HARMONIC, tumble_estimate_averaged, tumble_uncertainty_averaged)                           \
    ONE(REFINED, refined, HARMONIC, tumble_estimate_refined, tumble_uncertainty_refined)                               \
    ONE(LEAST_SQUARES, least_squares, RANK, tumble_estimate_least_squares, tumble_uncertainty_least_squares)           \
    LENT(OPTIMAL, optimal, GAINS)                                                                                      \
    LENT(INCLINED, inclined, INCLINED)

typedef enum {
#define TUMBLE_ESTIMATE_ENUM(number, ...) TUMBLE_ESTIMATE_##number,
    TUMBLE_ESTIMATOR_LIST(TUMBLE_ESTIMATE_ENUM, TUMBLE_ESTIMATE_ENUM)
#undef TUMBLE_ESTIMATE_ENUM
        TUMBLE_ESTIMATE_COUNT
} tumble_estimate_t;

/* What an estimator needs of a schedule. */
enum {
    TUMBLE_NEEDS_HARMONIC = 0, /* circles: see tumble_schedule_harmonic */
    TUMBLE_NEEDS_RANK,         /* positions that identify all twelve coefficients */
    TUMBLE_NEEDS_GAINS,        /* a gain record made for it */
    TUMBLE_NEEDS_INCLINED      /* inclinations of one bolting: see tumble_schedule_inclinations */
};

typedef struct {
    double k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS]; /* [i][j]: response of channel i to acceleration along j */
    double u0_v[TUMBLE_CHANNELS];
} tumble_coefficients_t;

/* Which positions or coefficients made an estimator refuse; bits as tumble_schedule_harmonic and
 * tumble_schedule_identify have them. Zero when they do not apply. */
typedef struct {
    uint64_t missing;
    uint8_t unidentified;
} tumble_refusal_t;

/* `averaged`: K_ij is the mean of what all circles say that hold the axis j, U0_i that of all circles. In the paper's
 * schedule: K_ix = (K1_ix + K2_ix)/2, U0_i = (U1_0i + U2_0i)/2.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_HARMONIC, TUMBLE_E_MISSING_POSITION (then refusal->missing),
 * TUMBLE_E_NOT_FINITE. `refusal` may be null. */
tumble_status_t tumble_estimate_averaged(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                         tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

/* `refined`, formula (7): as averaged, but K_ij and K_ji only from the circles that hold both axes i and j, if there are
 * any. In the paper's schedule: K_yx from mounting 2 and K_zx from mounting 1. A yaw of the block on the platform, or a
 * tilt of its seat, then turns the block and changes nothing else.
 * Returns as tumble_estimate_averaged: TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_HARMONIC, TUMBLE_E_MISSING_POSITION
 * (then refusal->missing), TUMBLE_E_NOT_FINITE. */
tumble_status_t tumble_estimate_refined(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                        tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

/* What a run says of its inclinations, as tumble_inclined_map_t has them: each by its sine and cosine, and the zero of its
 * table angle against the first one's. The core has no arc sine. */
typedef struct {
    double sine[TUMBLE_MAX_YAWS];
    double cosine[TUMBLE_MAX_YAWS];
    double turn_sine[TUMBLE_MAX_YAWS];
    double turn_cosine[TUMBLE_MAX_YAWS];
} tumble_inclinations_t;

/* `inclined`: the block is bolted on once, and the stand is inclined. Neither the inclinations nor the level of the axis
 * need be known: the outputs across the axis follow a parabola over those along it, whose vertex is the level
 * (docs/never-remounted.md). K is that of the table frame at the first inclination. The sign of the inclinations is that of
 * the schedule's tilts, which nothing else depends on.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_INCLINED, TUMBLE_E_MISSING_POSITION (then refusal->missing),
 * TUMBLE_E_NOT_FINITE, TUMBLE_E_ALIKE, TUMBLE_E_ONE_SIDE. `refusal` may be null. */
tumble_status_t tumble_estimate_inclined(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                         tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

/* The same with a weight for each channel, above 0 and finite, best in proportion to 1 / noise (null: equal), and what the
 * run says of its inclinations (`seen` may be null). */
tumble_status_t tumble_inclined_weighted(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                         const double weights[TUMBLE_CHANNELS], tumble_coefficients_t *coefficients,
                                         tumble_inclinations_t *seen, tumble_refusal_t *refusal);

/* `least_squares`: ordinary least squares of the measured fit positions on the ideal geometry, any schedule. Solves the
 * four-unknown normal matrix that the three channels share, then corrects the solution once from its residuals
 * (corrected seminormal equations), so the error grows with the condition of the design, not with its square.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_RANK (then refusal->unidentified), TUMBLE_E_NOT_FINITE. */
tumble_status_t tumble_estimate_least_squares(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                              tumble_coefficients_t *coefficients, tumble_refusal_t *refusal);

#define TUMBLE_MAX_GAIN 1e100

/* A constant gain table: twelve rows (K row by row, then U0), in each one gain per fit position of the schedule and
 * channel, in the schedule's order, the channel running fastest. Gains of K in 1/g, of U0 dimensionless. */
typedef struct {
    const double *gains; /* TUMBLE_COEFFICIENTS x (3 x fit_positions) */
    uint8_t fit_positions;
    double inclination_rad; /* 0 or above: of beta and tau (tumble_gain_record_inclination), for uncertainties alone */
} tumble_gain_table_t;

/* Any estimator that is linear in the means, from its gain table. All fit positions must be measured.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_GAIN_TABLE (wrong number of fit positions, or a gain that is not a
 * number or beyond TUMBLE_MAX_GAIN), TUMBLE_E_MISSING_POSITION, TUMBLE_E_NOT_FINITE. */
tumble_status_t tumble_estimate_gains(const tumble_gain_table_t *table, const tumble_schedule_t *schedule,
                                      const tumble_means_t *means, tumble_coefficients_t *coefficients);

/* ---- Calibration: coefficients to specific force, and what is intrinsic to the block. */

/* The inverse of the coefficients, ready to be applied: a = k_inverse (U - u0). */
typedef struct {
    double k_inverse_g_per_v[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
    double u0_v[TUMBLE_CHANNELS];
} tumble_calibration_t;

/* At or below this, K counts as singular: a row's length over the longest row's, and the volume that the three unit
 * rows span (1 for orthogonal channels, 0 for parallel ones). */
#define TUMBLE_MIN_ROW_RATIO 1e-6
#define TUMBLE_MIN_ROW_VOLUME 1e-3

/* Invert the coefficients. Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_FINITE, TUMBLE_E_SINGULAR. */
tumble_status_t tumble_calibration_invert(const tumble_coefficients_t *coefficients, tumble_calibration_t *calibration);

/* Outputs (V) to specific force (g). `a_g` may be the same array as `u_v`. */
void tumble_calibration_apply(const tumble_calibration_t *calibration, const double u_v[TUMBLE_CHANNELS],
                              double a_g[TUMBLE_CHANNELS]);

/* Raw counts to specific force (g); `v_per_count` is the size of one count of the converter. */
void tumble_calibration_apply_counts(const tumble_calibration_t *calibration, double v_per_count,
                                     const int32_t counts[TUMBLE_CHANNELS], double a_g[TUMBLE_CHANNELS]);

/* Parameters that do not depend on how the block sits on the stand (Geist and Gaitan, NIST, J. Res. 122.032, 126.038):
 * scale_i = |row i of K|, the angles between the sensitive axes as cosines (the core has no arc cosine), and the bias
 * of a channel over its own scale, U0_i / |row i|. */
typedef struct {
    double scale_v_per_g[TUMBLE_CHANNELS];
    double cosine_xy;
    double cosine_xz;
    double cosine_yz;
    double bias_g[TUMBLE_CHANNELS];
} tumble_intrinsic_t;

/* Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_FINITE, TUMBLE_E_SINGULAR (a row of K that is zero or nearly so).
 */
tumble_status_t tumble_calibration_intrinsic(const tumble_coefficients_t *coefficients, tumble_intrinsic_t *intrinsic);

/* ---- Verification: is a calibration to be believed? The gravity check, closure and residuals.
 *
 * Only measured positions are looked at.
 */

/* The gravity check, formula (8): at every position the calibrated block must find a specific force of 1 g,
 *     delta_g = (|a|^2 - 1) / 2,     a = K^-1 (U - U0).
 * On fit positions it is optimistic, so check positions are kept apart. */
typedef struct {
    double delta_g_g[TUMBLE_MAX_POSITIONS]; /* 0 where not measured */
    double max_abs_fit_g;                   /* 0 when no fit position is measured */
    double max_abs_check_g;                 /* 0 when no check position is measured */
    uint8_t fit_positions;                  /* how many of each were judged */
    uint8_t check_positions;
    bool pass; /* both maxima at most the limit, and something was judged */
} tumble_gravity_check_t;

/* Judge a run by a limit (g), finite and above 0.
 * Returns TUMBLE_OK (whatever the verdict), TUMBLE_E_ARGUMENT, or TUMBLE_E_NOT_FINITE (then `check` is all zero and
 * does not pass). */
tumble_status_t tumble_gravity_check(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                     const tumble_calibration_t *calibration, double limit_g,
                                     tumble_gravity_check_t *check);

/* Closure: how the outputs have changed when a mounting comes back to an attitude, last measured position less the
 * earliest one with the same attitude (in the paper's schedule U9 - U1). It shows drift, slip of the table, or a block
 * that moved. `mounting` is the mounting's number.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, or TUMBLE_E_MISSING_POSITION when the mounting has no such pair. */
tumble_status_t tumble_closure(const tumble_schedule_t *schedule, const tumble_means_t *means, uint8_t mounting,
                               double difference_v[TUMBLE_CHANNELS]);

/* Residual (V) of the position at `index`: U - U0 - K a on the ideal geometry. `index` below position_count. `measured`
 * is not looked at: ask it first, for the residual of a position that was not measured means nothing. */
void tumble_residual(const tumble_schedule_t *schedule, const tumble_means_t *means,
                     const tumble_coefficients_t *coefficients, uint8_t index, double residual_v[TUMBLE_CHANNELS]);

/* Root mean square of the residuals of the measured fit positions, per channel, over n - 4 degrees of freedom.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, or TUMBLE_E_TOO_FEW with fewer than five measured fit positions. */
tumble_status_t tumble_residual_rms(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                    const tumble_coefficients_t *coefficients, double rms_v[TUMBLE_CHANNELS]);

/* ---- Uncertainty: how far the twelve coefficients may be from the truth, from what the stand is declared to be.
 *
 * An estimate is linear in the means, so its standard uncertainty follows exactly to first order from the estimator's
 * gains and from the derivatives of the specific force by each error of the stand, taken at zero error on the exact
 * geometry, the known tilt of the axis included (docs/method.md, "Uncertainty"). Independent errors add in quadrature.
 * The gains are computed row by row as they are needed: no table, no matrix. Cost: some 20 double operations for each
 * of the twelve coefficients and each position whose mean it is made of, 40 with a table of gains.
 */

#define TUMBLE_MAX_STAND_SIGMA_RAD 1.0

/* What the samples of a run show of its noise, by channel (tumble_blocks_noise); 104 bytes. */
typedef struct {
    double noise_v[TUMBLE_CHANNELS];     /* of one sample, were it white: it gives the means their standard errors */
    double declared_v;                   /* the same as the stand declares it, of the channel that has most */
    double variance_v2[TUMBLE_CHANNELS]; /* private: of a sample, as it matters to a mean, */
    double line_v2[TUMBLE_CHANNELS];     /* what each further length of the longest blocks adds to it, */
    double lengths_per_sample;           /* such lengths, */
    double rounding_v2;                  /* and of rounding by one count */
    uint8_t above;                       /* bit of each channel: its noise is more than declared, beyond chance */
    uint8_t undithered;                  /* likewise: all samples of a position round alike */
} tumble_noise_t;

/* By how much the variance of a mean of so many `samples` (1 or more) is larger than `declared_v2`; 0 or more. Counts
 * where the noise of the channel is above the declared one; where samples round alike the rounding of one count is
 * added, undivided. */
double tumble_noise_excess(const tumble_noise_t *noise, int channel, uint32_t samples, double declared_v2);

/* What a stand is declared to be: standard deviations, 0 for an error that it does not have. */
typedef struct {
    double axis_tilt_rad; /* alpha1: the axis is not level; one for a run. Angles: 0 to TUMBLE_MAX_STAND_SIGMA_RAD */
    double level_rad;     /* alpha2: the zero of the table angle; one for a run */
    double remount_rad;   /* alpha3: yaw of the block on the platform; one for each mounting, or `common_yaw` */
    double angle_rad;     /* alpha4: of a set table angle; one for each position */
    double noise_v;       /* of one sample of one channel; 0 to TUMBLE_MAX_MEAN_V */
    double least_noise_v; /* of a mean, however many samples it has: it never counts as less; 0 to TUMBLE_MAX_MEAN_V */
    uint32_t samples;     /* in a mean, where the run does not say; at least 1 */
    bool common_yaw;      /* every mounting has the same yaw */
    double seat_rad; /* theta_h, theta_n: how far a mounting tilts the block against the axis, and turns it about it;
                           * one of each for each mounting */
    double platform_rad; /* theta_h of the platform: one for all mountings */
    double encoder_rad;  /* of the table angle t: each of the four numbers by sin t, cos t, sin 2t, cos 2t; for all */
    double drift_v;      /* of each channel, from the first fit position to the last; 0 to TUMBLE_MAX_MEAN_V */
    double channel_noise_v[TUMBLE_CHANNELS]; /* of a channel that differs, in place of noise_v; 0: as noise_v says. */
    double channel_drift_v[TUMBLE_CHANNELS]; /* Likewise of drift_v */
} tumble_stand_record_t;

#define TUMBLE_WAVES 4 /* numbers of an encoder's errors */

/* The run whose estimate is judged. */
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_stand_record_t *stand;
    const tumble_coefficients_t *coefficients; /* the estimate; only its K matters */
    const bool *measured;                      /* one flag per position; null: all are measured */
    const uint32_t *samples;                   /* in the mean of each position, at least 1; null: the stand's */
    uint16_t only; /* bits of the coefficients (0 to 11: K row by row, then U0) to be judged now, so that all twelve can
                    * be judged in small steps; the others stay as they are. 0: all */
    /* By how much the variance of the mean of each position and channel, as it was measured, is larger than declared:
     * 0 or more. Null: by nothing. */
    const double (*excess_variance_v2)[TUMBLE_CHANNELS];
    const tumble_noise_t *noise; /* the same by tumble_blocks_noise; null: by nothing */
    /* A unit vector on the axes of the block: then u(|a|) there is judged in place of coefficients, into `*norm_g`, g,
     * and `uncertainty` may be null. Null: coefficients are. */
    const double *attitude;
    double *norm_g;
    /* Of tumble_estimate_inclined: what the run says of its inclinations, and the weights of the channels, as
     * tumble_inclined_weighted has them. Null: as the schedule has them; equal. */
    const tumble_inclinations_t *inclinations;
    const double *weights;
} tumble_judged_run_t;

/* Standard uncertainties, arranged and with units as in tumble_coefficients_t. */
typedef struct {
    double k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
    double u0_v[TUMBLE_CHANNELS];
} tumble_uncertainty_t;

/* Standard uncertainties of an estimate by tumble_estimate_averaged, tumble_estimate_refined or
 * tumble_estimate_least_squares; each uses, and refuses, the positions that its estimator does. `refusal` may be null.
 * `uncertainty` is written on TUMBLE_OK, and set to zero on TUMBLE_E_NOT_FINITE.
 * Returns TUMBLE_OK; TUMBLE_E_ARGUMENT (null, or a number out of its range above); TUMBLE_E_NOT_FINITE (K is no number,
 * or too large); TUMBLE_E_NOT_HARMONIC, TUMBLE_E_MISSING_POSITION (refusal->missing) or TUMBLE_E_RANK
 * (refusal->unidentified) as the estimator. */
tumble_status_t tumble_uncertainty_averaged(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                            tumble_refusal_t *refusal);
tumble_status_t tumble_uncertainty_refined(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                           tumble_refusal_t *refusal);
tumble_status_t tumble_uncertainty_least_squares(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                                 tumble_refusal_t *refusal);

/* Likewise of tumble_estimate_inclined, at the inclinations that the run shows. Errors of level and inclination do
 * nothing; seat and yaw of the bolting and the zero of the table angle turn the block against its axes, as K says them.
 * Returns also TUMBLE_E_NOT_INCLINED, TUMBLE_E_MISSING_POSITION, TUMBLE_E_ALIKE, TUMBLE_E_ONE_SIDE. */
tumble_status_t tumble_uncertainty_inclined(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                            tumble_refusal_t *refusal);

/* What a run says of its inclinations, in the order of tumble_inclined_map_t; beyond `count`: 0. The error of the level
 * axis is that of the first one that the schedule has at 0. */
typedef struct {
    double deg[TUMBLE_MAX_YAWS];
    double u_deg[TUMBLE_MAX_YAWS]; /* standard uncertainties */
    double level_rad;
    double u_level_rad;
    uint8_t count;
    bool has_level; /* else both are 0 */
} tumble_shown_inclinations_t;

/* The inclinations of a run that was estimated by tumble_estimate_inclined, with uncertainties as of its coefficients.
 * Errors of level and inclination do nothing: they are what it shows. Angles are those of `run->inclinations`, within 0.3
 * rad of the schedule's, to 1e-15 rad; farther off their series is worse. `run->only` and `attitude` are not read.
 * docs/never-remounted.md. Returns as tumble_uncertainty_inclined, and writes zeros on a refusal but
 * TUMBLE_E_ARGUMENT (null). */
tumble_status_t tumble_uncertainty_inclinations(const tumble_judged_run_t *run, tumble_shown_inclinations_t *shown,
                                                tumble_refusal_t *refusal);

/* `inclined` for a procedure that knows no inclinations: how the channels weigh, and memory for what the run says of its
 * inclinations, 192 bytes, which the uncertainties need. */
typedef struct {
    const double *weights; /* as tumble_inclined_weighted has them; null: equal */
    tumble_inclinations_t *seen;
} tumble_inclined_source_t;

/* Does the schedule have inclinations? `source`: a tumble_inclined_source_t, here and below.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT (null, no memory, a weight that is not above 0 and finite), TUMBLE_E_NOT_INCLINED. */
tumble_status_t tumble_inclined_check(const void *source, const tumble_schedule_t *schedule);

/* Estimate by tumble_inclined_weighted. Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_INCLINED,
 * TUMBLE_E_MISSING_POSITION, TUMBLE_E_NOT_FINITE, TUMBLE_E_ALIKE, TUMBLE_E_ONE_SIDE. */
tumble_status_t tumble_inclined_estimate(const void *source, const tumble_schedule_t *schedule,
                                         const tumble_means_t *means, tumble_coefficients_t *coefficients);

/* Standard uncertainties of the last estimate from this source, by tumble_uncertainty_inclined at the inclinations that it
 * found; those of `run` and its weights are not read. Returns as that function, and TUMBLE_E_ARGUMENT (no memory). */
tumble_status_t tumble_inclined_uncertainty(const void *source, const tumble_judged_run_t *run,
                                            tumble_uncertainty_t *uncertainty);

/* Standard uncertainties of an estimate by tumble_estimate_gains, or by the table of a gain record. Errors of inclinations
 * count as the table says.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_FINITE, TUMBLE_E_GAIN_TABLE (for another number of fit positions),
 * TUMBLE_E_MISSING_POSITION. */
tumble_status_t tumble_uncertainty_gains(const tumble_gain_table_t *table, const tumble_judged_run_t *run,
                                         tumble_uncertainty_t *uncertainty);

/* The worst u(|a|) over all attitudes, one attitude at a time: tumble_worst_norm_begin, then judge at
 * tumble_worst_norm_attitude and hand what comes out to tumble_worst_norm_next, for as long as it returns true; `worst_g`
 * is then right to 1 %. First 26 attitudes all over the sphere, then a climb from the best of these: some 60 in all,
 * never more than 150. */
typedef struct {
    double best[3];
    double worst_g;
    uint8_t place;
    uint8_t rounds;
    uint8_t halvings;
    bool rises;
} tumble_worst_norm_t;

void tumble_worst_norm_begin(tumble_worst_norm_t *search);
void tumble_worst_norm_attitude(const tumble_worst_norm_t *search, double attitude[3]);
bool tumble_worst_norm_next(tumble_worst_norm_t *search, double u_g);

/* ---- Gain records: a table of stand-optimal gains as it lies in non-volatile memory, validated and read in place.
 *
 * docs/files.md defines the bytes. Nothing is copied: a record that passed the check is used where it is mapped.
 * The caller must keep it there, unchanged, as long as the pointer to it is in use.
 */

#if defined(__BYTE_ORDER__) && (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)
#error "a gain record is read in place and is little endian: this target needs a reader of its own"
#endif

#define TUMBLE_GAIN_RECORD_SCHEMA 1
#define TUMBLE_MAX_SIGMA_RAD 1.0 /* of a stand's errors */

/* The head of a record. Behind it, up to its last 8 bytes: the gains, then the standard deviation of inclinations if they
 * are declared, then the weights of the channels if they differ. */
typedef struct {
    uint8_t magic[4]; /* "TGR1" */
    uint32_t size_bytes;
    uint8_t schema;
    uint8_t inclinations; /* 0: it has no rows for them; else one for each mounting */
    uint8_t fit_positions;
    uint8_t mountings;
    uint8_t yaws;   /* 1: one yaw for all mountings; else one for each */
    uint8_t seats;  /* 0: none is declared; else one for each mounting */
    uint8_t waves;  /* numbers of the encoder: 0, or TUMBLE_WAVES */
    uint8_t drifts; /* 0, or one for each channel */
    uint32_t schedule_crc;
    uint32_t block_crc; /* CRC-32 of the block's serial, UTF-8; 0: for any block. For people: nothing here checks it */
    double k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS]; /* the K that the gains were linearised at; not all 0 */
    double sigma_rad[4];                                /* standard deviations of alpha1 .. alpha4; 0: no such error */
    double sigma_mean_v;                                /* of a mean of the noisiest channel; above 0 */
    double u_k_v_per_g[TUMBLE_CHANNELS][TUMBLE_CHANNELS]; /* standard uncertainties of the result, at that K */
    double u_u0_v[TUMBLE_CHANNELS];
} tumble_gain_record_t;

static_assert(offsetof(tumble_gain_record_t, k_v_per_g) == 24, "the numbers follow the head's first 24 bytes");
static_assert(sizeof(tumble_gain_record_t) == 232, "the gains follow the head's 232 bytes");

/* Is there a record of gains for this schedule in the `size` bytes at `memory`? Checks in this order: pointers and
 * alignment (to 8 bytes); magic, size and schema; CRC-32; counts and schedule fingerprint; that every number is finite,
 * at most TUMBLE_MAX_GAIN in magnitude, and in its range. The record may be shorter than the memory. `*record` is
 * written only on TUMBLE_OK. The schedule has passed its own validation. Reads every byte once bitwise (about 50
 * instructions a byte).
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_GAIN_RECORD (nothing that this software reads), TUMBLE_E_CRC,
 * TUMBLE_E_GAIN_TABLE (for another schedule), TUMBLE_E_NOT_FINITE (K, a sigma, a u or a gain is not a number or out of
 * range). */
tumble_status_t tumble_gain_record_open(const void *memory, size_t size, const tumble_schedule_t *schedule,
                                        const tumble_gain_record_t **record);

/* Gains of the coefficients: TUMBLE_COEFFICIENTS rows of 3 x fit_positions, as in tumble_gain_table_t. */
const double *tumble_gain_record_gains(const tumble_gain_record_t *record);

/* Gains (rad per V; of drifts, V per V) of the stand's own errors: rows alpha1, alpha2, each yaw, theta_h of each seat,
 * theta_n of each, the numbers of the encoder, drifts, beta of each inclination, tau of each; columns as above. */
const double *tumble_gain_record_stand_gains(const tumble_gain_record_t *record);

/* Standard deviation (rad) of beta and tau, the errors of an inclination; 0 where no size of them is declared. */
double tumble_gain_record_inclination(const tumble_gain_record_t *record);

/* What the square of an output of each channel counts beside that of the noisiest one: sigma_mean_v over the channel's own,
 * squared. Null where the channels are alike. */
const double *tumble_gain_record_weights(const tumble_gain_record_t *record);

/* The fingerprint of a schedule: CRC-32 over mountings and fit positions, see docs/files.md. */
uint32_t tumble_gain_record_schedule_crc(const tumble_schedule_t *schedule);

/* ---- The stand-optimal estimator: constant gains for one stand, twice corrected to second order.
 *
 * The gains of a record are those of generalised least squares for the stand's declared errors: twelve rows for the
 * coefficients, further rows for the errors that positions share (axis tilt, level, yaws, seats, ...). The gains are linear; the
 * outputs are not, and on a stand with a yaw of 15 mrad a linear estimate of K_xx is off by 16 times its uncertainty.
 * Therefore the difference between the exact geometry and its linearisation is taken out of the means and the gains are
 * applied again, twice, with inclinations four times: docs/method.md, "Stand-optimal weights".
 */

/* The series for sine and cosine are exact to a double's last bits up to here. No stand is that bad. */
#define TUMBLE_MAX_STAND_ERROR_RAD 0.1

/* Errors of the stand estimated from the run (rad); an error that the record declares absent is 0. */
typedef struct {
    double alpha1_rad;
    double alpha2_rad;
    double alpha3_rad[TUMBLE_MAX_YAWS];  /* per mounting of the schedule, in its order; beyond: 0 */
    double theta_h_rad[TUMBLE_MAX_YAWS]; /* likewise; the platform's is in each */
    double theta_n_rad[TUMBLE_MAX_YAWS];
    double encoder_rad[TUMBLE_WAVES]; /* by the sine and cosine of the table angle, and of its double */
    double drift_v[TUMBLE_CHANNELS];  /* from the first fit position to the last */
    double beta_rad[TUMBLE_MAX_YAWS]; /* of the inclination of a mounting, beside alpha1, */
    double tau_rad[TUMBLE_MAX_YAWS];  /* and of the zero of its table angle; of the first of a bolting 0 */
} tumble_stand_errors_t;

/* What the estimator works with beside its stack; the caller owns it. */
typedef struct {
    tumble_stand_errors_t stand;               /* a result, beside the coefficients */
    float curvature_rad[TUMBLE_MAX_POSITIONS]; /* private */
} tumble_optimal_t;

static_assert(sizeof(tumble_optimal_t) <= ((4U * TUMBLE_MAX_POSITIONS) + (40U * TUMBLE_MAX_YAWS) + 72U),
              "with optimal a position costs 4 more, a mounting 40");

/* Coefficients and the stand's errors from the means of all fit positions. `record` was opened for this very schedule.
 * Outputs are working memory too: on TUMBLE_E_STAND_ERROR, and where a result is not finite, they are left zero.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT (null), TUMBLE_E_NOT_FINITE (a measured mean that is not a number or beyond
 * TUMBLE_MAX_MEAN_V, or a result that is not finite), TUMBLE_E_GAIN_TABLE (the record has another number of fit
 * positions or mountings than the schedule), TUMBLE_E_MISSING_POSITION (a fit position was not measured),
 * TUMBLE_E_STAND_ERROR (an error of the stand, or of one table angle with alpha2, or its curvature, comes out beyond
 * TUMBLE_MAX_STAND_ERROR_RAD: wrong record, mounting or means). */
tumble_status_t tumble_estimate_optimal(const tumble_gain_record_t *record, const tumble_schedule_t *schedule,
                                        const tumble_means_t *means, tumble_coefficients_t *coefficients,
                                        tumble_optimal_t *optimal);

/* The estimator for a procedure that knows no records: where the record is mapped, and the memory to work with. */
typedef struct {
    const void *record;
    size_t record_bytes; /* of the memory; the record may be shorter */
    tumble_optimal_t *work;
} tumble_optimal_source_t;

/* Does the memory hold a record for this schedule? `source`: a tumble_optimal_source_t. Returns as
 * tumble_gain_record_open: TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_GAIN_RECORD, TUMBLE_E_CRC, TUMBLE_E_GAIN_TABLE,
 * TUMBLE_E_NOT_FINITE. */
tumble_status_t tumble_optimal_check(const void *source, const tumble_schedule_t *schedule);

/* Check the whole record again, and estimate. On any refusal `coefficients` holds no result. Returns as
 * tumble_gain_record_open and tumble_estimate_optimal: TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_GAIN_RECORD,
 * TUMBLE_E_CRC, TUMBLE_E_GAIN_TABLE, TUMBLE_E_NOT_FINITE, TUMBLE_E_MISSING_POSITION, TUMBLE_E_STAND_ERROR. */
tumble_status_t tumble_optimal_estimate(const void *source, const tumble_schedule_t *schedule,
                                        const tumble_means_t *means, tumble_coefficients_t *coefficients);

/* Standard uncertainties of an estimate by `optimal`: the stand's errors propagated through the gains of the record, at
 * the K for which the record was made. (At the K of another block this propagation would overstate them, because the
 * second-order correction takes the difference out: docs/method.md.)
 *
 * `source`: a tumble_optimal_source_t. `run->coefficients` is not read, but must not be null. The whole record is
 * checked with the first coefficient; when `run->only` leaves that out, it has been checked before. Returns as
 * tumble_gain_record_open and tumble_uncertainty_gains: TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_GAIN_RECORD,
 * TUMBLE_E_CRC, TUMBLE_E_GAIN_TABLE, TUMBLE_E_NOT_FINITE, TUMBLE_E_MISSING_POSITION. */
tumble_status_t tumble_optimal_uncertainty(const void *source, const tumble_judged_run_t *run,
                                           tumble_uncertainty_t *uncertainty);

/* ---- The stand seen: errors of the stand estimated from a run: its angles, the error of a set angle, the noise.
 *
 * There are two ways to the angles. The closed form takes the paper's positions: with the biases and the sensitivities
 * to x that each mounting gives by itself, v = K^-1 (U1_0 - U2_0) and w = K^-1 (K2_x - K1_x),
 *
 *     alpha1 = (v_y - v_z) / 2,    w_y = alpha2 + alpha3 of mounting 1,    w_z = alpha2 + alpha3 of mounting 2.
 *
 * The fit takes any schedule: generalised least squares for coefficients and angles together. It treats the error of a
 * set angle as an error of three outputs at once along one direction. Its uncertainties are the smallest possible, up
 * to six times smaller than those of the closed form, and only the fit gives alpha4 (docs/method.md, "The stand seen").
 * Only measured fit positions are read. The fit has an unknown for the yaw of each
 * mounting: more than TUMBLE_MAX_YAWS of them are TUMBLE_E_ARGUMENT.
 */

/* One quantity with its standard uncertainty. If the run cannot tell it, `known` is false and both numbers are 0. */
typedef struct {
    double value;
    double u;
    bool known;
} tumble_seen_t;

/* Angles of the stand, rad. */
typedef struct {
    tumble_seen_t alpha1;             /* the axis is not level */
    tumble_seen_t alpha2_plus_alpha3; /* zero of the table angle, and mean yaw of all mountings */
    tumble_seen_t alpha3_difference;  /* yaw in the first mounting less that in the second */
} tumble_seen_angles_t;               /* mountings: those with measured fit positions, in the schedule's order */

/* The random errors that the uncertainties come from. */
typedef struct {
    double angle_rad;                              /* alpha4, standard deviation; 0 or more, finite */
    double mean_variance_v2[TUMBLE_MAX_POSITIONS]; /* noise of the mean of a channel; 0 or more, finite */
} tumble_random_errors_t;

/* Unknowns of the fit at most: coefficients, alpha1, alpha3 per mounting, alpha2; and room for them. */
#define TUMBLE_FIT_UNKNOWNS (TUMBLE_COEFFICIENTS + 2 + TUMBLE_MAX_YAWS)

/* Working memory of the fit, 2 kB. The caller owns it; its content means nothing outside the fit. */
typedef struct {
    double r[(TUMBLE_FIT_UNKNOWNS * (TUMBLE_FIT_UNKNOWNS + 3)) / 2]; /* upper triangle and right sides, by rows */
    double row[TUMBLE_FIT_UNKNOWNS + 1];
    double residual_square;
    double scale_v;     /* largest element of K */
    double smallest_v2; /* noise variance that weights are relative to, in units of scale_v */
    double angle_square;
    uint8_t unknowns;
} tumble_fit_work_t;

/* Standard deviation of one sample, pooled over positions and channels, from the number of samples and the scatter of
 * each position (n - 1; not read below two samples), with one row of both arrays for each of `positions`. Unit as the
 * scatter. Not known where no position has two samples. Neither array may be null. */
tumble_seen_t tumble_seen_noise(const uint32_t *samples, const double (*scatter)[TUMBLE_CHANNELS], uint8_t positions);

/* The angles by the closed form. `errors` as declared, or as seen; null: uncertainties are 0.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NOT_HARMONIC, TUMBLE_E_MISSING_POSITION. */
tumble_status_t tumble_seen_angles(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                   const tumble_calibration_t *calibration, const tumble_random_errors_t *errors,
                                   tumble_seen_angles_t *angles);

/* The angles by the fit, linearised at `coefficients` (any estimate of them) and an ideal stand; errors of second order
 * in the angles remain.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_seen_fit(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                const tumble_coefficients_t *coefficients, const tumble_random_errors_t *errors,
                                tumble_fit_work_t *work, tumble_seen_angles_t *angles);

/* alpha4 from the run itself: the part of the residuals that exceeds the noise (`errors->angle_rad` is not read).
 * Errors of set angles move m of the weighted residuals; the estimate is the alpha4 at which the squares of these sum
 * up to m (Paule and Mandel). `freedom` receives the degrees of freedom of the estimate: m without noise, less with it.
 * Not known where m is 0, or where the residuals do not exceed the noise.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_seen_angle_error(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                        const tumble_coefficients_t *coefficients, const tumble_random_errors_t *errors,
                                        tumble_fit_work_t *work, tumble_seen_t *alpha4, double *freedom);

/* The sum of those squares for alpha4 = `errors->angle_rad`. If that is the truth, the sum is chi-squared with
 * `freedom` = m degrees of freedom.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_seen_angle_chi_squared(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                              const tumble_coefficients_t *coefficients,
                                              const tumble_random_errors_t *errors, tumble_fit_work_t *work,
                                              double *chi_squared, uint8_t *freedom);

/* ---- Blocks: the standard errors of means as the samples show them.
 *
 * The scatter of samples over root N is the standard error of their mean only if the noise is white. Blocks of
 * consecutive samples show whether it is: of neighbouring blocks of m samples with the sums A and B, (A - B)^2 / 2m is
 * the variance of a sample on the average, whatever m is. Noise that hangs together has more in long blocks. Two lengths
 * are looked at, m and 2m: of N samples a quarter and half, rounded down to powers of two, at most 64 and 128. Sums are
 * exact integers, by channel, over all positions of a run.
 *
 * Beside the averaging of a run give tumble_blocks_begin with tumble_averaging_begin, tumble_blocks_add every sample
 * that tumble_averaging_add took, and tumble_blocks_finish after tumble_averaging_finish returned TUMBLE_OK. These three
 * use no floating point and do not check their arguments. When the run is over, tumble_blocks_noise tells what
 * uncertainties must count beyond the declared noise.
 */

#define TUMBLE_BLOCK_LENGTHS 2
#define TUMBLE_MAX_BLOCK_SAMPLES 128
#define TUMBLE_MIN_BLOCKED_SAMPLES 8 /* of a position: two lengths of two samples or more */

/* A difference of sums must fit an int32, its square an int64: a sample lies within the deviation from the first. */
static_assert(TUMBLE_MAX_DEVIATION_COUNTS * TUMBLE_MAX_BLOCK_SAMPLES * 2 <= INT32_MAX, "A - B must fit an int32");

/* 136 bytes. The caller owns it; nothing in it is to be written from outside. */
typedef struct {
    int64_t square_sum[TUMBLE_BLOCK_LENGTHS][TUMBLE_CHANNELS]; /* of A - B, finished positions; at the end: or more */
    int64_t open_square_sum[TUMBLE_BLOCK_LENGTHS][TUMBLE_CHANNELS];
    uint32_t difference[TUMBLE_BLOCK_LENGTHS][TUMBLE_CHANNELS]; /* A - B so far, modulo 2^32 */
    uint32_t pairs[TUMBLE_BLOCK_LENGTHS];                       /* of finished positions */
    uint32_t samples;                                           /* of the open position */
    uint32_t block_samples;                                     /* m */
} tumble_blocks_t;

static_assert((sizeof(tumble_blocks_t) + sizeof(tumble_averaging_t)) <= 1664U, "RAM of a run with blocks");

/* Forget all. `samples` of a position, as planned: at least TUMBLE_MIN_BLOCKED_SAMPLES.
 * Returns TUMBLE_OK or TUMBLE_E_ARGUMENT. */
tumble_status_t tumble_blocks_init(tumble_blocks_t *blocks, uint32_t samples);

/* Open a position. What was open before and not finished is forgotten. */
void tumble_blocks_begin(tumble_blocks_t *blocks);

/* One sample of the open position. */
void tumble_blocks_add(tumble_blocks_t *blocks, const int32_t counts[TUMBLE_CHANNELS]);

/* Keep the open position. A position that is measured again counts again. */
void tumble_blocks_finish(tumble_blocks_t *blocks);

/* For tumble_judged_run_t: the noise that the run shows, in the unit of `v_per_count`. A channel is `above` what `stand`
 * declares only beyond chance (below 1e-3 for a sound run); half a count of rounding is no such noise. Of the stand
 * its noise_v counts. Where no position has two blocks the scatter of samples speaks alone. Some 60,000 instructions on a
 * Cortex-M4 without floating point hardware for 18 positions.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT (null; `v_per_count` 0 or not finite), TUMBLE_E_TOO_FEW (no finished position has
 * two samples), TUMBLE_E_DEVIATION (samples scatter so much that a sum of squares has come to its end). */
tumble_status_t tumble_blocks_noise(const tumble_blocks_t *blocks, const tumble_averaging_t *averaging,
                                    const tumble_stand_record_t *stand, double v_per_count, tumble_noise_t *noise);

/* ---- Chi-squared: the quantile that belongs to so many one-sided `sigmas` of the normal distribution, by Wilson and
 * Hilferty (1931): k (1 - 2/(9 k) + sigmas sqrt(2/(9 k)))^3. With 4 it is never below the true quantile, and above it by
 * 9 % (1 degree), 2.4 % (6), 0.8 % (18). `freedom` 1 or more: without freedom there is nothing to judge, and the answer
 * would not be a number.
 */
double tumble_chi_squared_limit(double freedom, double sigmas);

/* ---- Misfit: does a run fit the stand that is declared? A chi-squared test of every mounting, taken in small steps.
 *
 * In one mounting the specific force turns on a circle, so every channel is
 *
 *     U(phi) = b + s sin phi + c cos phi
 *
 * whatever K and U0 are, and whatever the systematic errors of the stand (alpha1, alpha2, the yaw alpha3, a known
 * tilt): each of them changes b, s and c alone. A generalised least-squares fit of these nine numbers leaves residuals.
 * They come from the errors of the set angles, from the noise of the means, and from undeclared errors: steps,
 * drift, slip, curvature of the block. With V = v I + alpha4^2 d d^T the covariance of the three means at a position
 * (d: how the outputs answer to its angle), the sum of r^T V^-1 r is chi-squared with 3 (n - 3) degrees of freedom.
 *
 * A fault of one channel drowns in the sum over three. So each channel is judged again, given the other two: the sum
 * less the sum without that channel is chi-squared with n - 3 degrees of freedom. Hence four tests a mounting. Each
 * fails a sound run in TUMBLE_MISFIT_CHANCE_PER_MILLION cases of a million at most, so that all tests together stay
 * below 1e-3.
 *
 * Mountings are not compared with each other: a step between them, and a tilt of the seat, pass. So does an inclination
 * of the stand, whatever it is: an error of a set angle counts there as on a level axis, where it is felt most, and by a
 * part of 0.03 across, for the zero of the table angle. At 45 degrees the set angles may be worse by a factor of 1.4
 * before they are found.
 *
 * Every measured position counts, check positions included. A mounting with fewer than four positions cannot be judged,
 * and passes.
 */

#define TUMBLE_MISFIT_UNKNOWNS 9 /* b, s and c of three channels */
#define TUMBLE_MISFIT_TESTS 4    /* of a mounting: all channels, and each given the others */
#define TUMBLE_MISFIT_SIGMAS 4.0 /* one-sided quantile of the normal distribution that the limit is taken at */
#define TUMBLE_MISFIT_CHANCE_PER_MILLION 32
#define TUMBLE_MISFIT_CHANCE (1e-6 * TUMBLE_MISFIT_CHANCE_PER_MILLION)

/* A mounting that is judged has at least four positions. With four, the limit lies so far above the quantile that its
 * chance is half; so it is mountings of five that add up. */
static_assert((TUMBLE_MISFIT_TESTS * (TUMBLE_MAX_POSITIONS / 5) * TUMBLE_MISFIT_CHANCE_PER_MILLION) < 1000,
              "a sound run must fail in less than one case of a thousand");

/* The run and its stand. All must stay as they are from the first step to the last. */
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_averaging_t *averaging;       /* its finished positions */
    const tumble_coefficients_t *coefficients; /* any estimate: residuals are taken from it before they are fitted */
    const tumble_stand_record_t *stand;        /* angle_rad, noise_v and least_noise_v count; checked by its owner */
    double v_per_count;
} tumble_misfit_run_t;

/* Working memory, 0.5 kB. The caller owns it. `misfit` is the verdict; everything else is private. */
typedef struct {
    bool misfit;         /* some test has failed */
    uint8_t mounting;    /* index in the schedule */
    uint8_t test;        /* 0: all channels; else all but channel test - 1 */
    uint8_t position;    /* the next to be looked at */
    uint8_t counted;     /* means in the sums */
    uint8_t all_freedom; /* what the fit of all three channels left: degrees of freedom, */
    double all_square;   /* and of the whitened residuals */
    double square;       /* of the whitened residuals, this test's */
    double right[TUMBLE_MISFIT_UNKNOWNS];
    double triangle[(TUMBLE_MISFIT_UNKNOWNS * (TUMBLE_MISFIT_UNKNOWNS + 1)) / 2]; /* lower, by rows */
} tumble_misfit_work_t;

/* Begin. */
void tumble_misfit_begin(tumble_misfit_work_t *work);

/* Take one step of the test: one position, or the end of one test; some 20,000 instructions on a Cortex-M4 without
 * floating point hardware. Call it until it returns false; then `work->misfit` is the verdict. */
bool tumble_misfit_step(tumble_misfit_work_t *work, const tumble_misfit_run_t *run);

/* The largest chi-squared of a sound run: tumble_chi_squared_limit with TUMBLE_MISFIT_SIGMAS. */
double tumble_misfit_limit(int freedom);

/* ---- The whole model: does a run fit its coefficients and the stand that is declared? Chi-squared of all residuals.
 *
 * Generalised least squares on the exact geometry: unknown are the coefficients and every error that the stand declares,
 * each with its variance as prior. The smallest sum of the squares of what remains, outputs and errors in units of their
 * standard deviations, is chi-squared with 3 P - 12 degrees of freedom for P measured fit positions: docs/method.md,
 * "Does the run fit its stand?". It is found by four steps of Gauss and Newton from any estimate of the coefficients, and
 * does not depend on which. The error of a set angle is eliminated position by position, what a mounting has for itself
 * mounting by mounting: the memory does not grow with either. An error of the stand that comes out beyond
 * TUMBLE_MAX_STAND_ERROR_RAD is held there: such a run fits nothing.
 *
 * Where the block is bolted on once and the stand is inclined, each inclination is an unknown, and so is the zero of the
 * table angle at each but the first: nothing is known of them, and each takes a degree of freedom. The errors of the one
 * bolting turn the block, which the coefficients take up. An inclination may be 0.3 rad from its schedule's. A schedule
 * with inclinations and several boltings is not for this test: tumble_whole_step ends at once, and nothing is known.
 */

/* The run and its stand. */
typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_means_t *means;
    const tumble_stand_record_t *stand; /* its angles and drift alone, checked by its owner */
    const double *mean_variance_v2;     /* noise of the mean of a channel, one for each position; 0 or more, finite */
    const double (*channel_variance_v2)[TUMBLE_CHANNELS]; /* of each channel, in place of that; null: all are alike */
} tumble_whole_run_t;

#define TUMBLE_WHOLE_LOCAL 3  /* errors of a mounting: yaw, seat (theta_h, theta_n); of an inclination: tilt, 0, zero */
#define TUMBLE_WHOLE_SHARED 4 /* errors of all: alpha1, alpha2, platform, a yaw common to all mountings */
#define TUMBLE_WHOLE_COURSE (TUMBLE_WAVES + TUMBLE_CHANNELS) /* where declared: the encoder's numbers, drifts */
#define TUMBLE_WHOLE_UNKNOWNS (TUMBLE_WHOLE_LOCAL + TUMBLE_COEFFICIENTS + TUMBLE_WHOLE_SHARED + TUMBLE_WHOLE_COURSE)

/* One-sided quantile of the normal distribution that belongs to the confidence, 99.9 %: of a thousand honest runs one is
 * beyond the limit. */
#define TUMBLE_WHOLE_SIGMAS 3.0902323061678135

/* A position, linearised: outputs (V) per g, per sigma of an error, per rad. Private. */
typedef struct {
    double attitude_g[TUMBLE_CHANNELS];
    double by_local[TUMBLE_WHOLE_LOCAL][TUMBLE_CHANNELS];
    double by_shared[TUMBLE_WHOLE_SHARED][TUMBLE_CHANNELS];
    double by_angle[TUMBLE_CHANNELS];
    double wave_rad[TUMBLE_WAVES];      /* the table angle, per sigma of each number of the encoder */
    double drift_v[TUMBLE_CHANNELS];    /* each output, per sigma of its own drift */
    double residual_v[TUMBLE_CHANNELS]; /* as if the set angle had no error */
    double variance_v2[TUMBLE_CHANNELS];
} tumble_whole_place_t;

/* Working memory, 4.5 kB. The caller owns it. The first members are the verdict of tumble_whole_step, once `known`;
 * everything else is private. */
typedef struct {
    double chi_squared;
    double limit;    /* tumble_chi_squared_limit */
    double misfit;   /* sqrt(chi_squared / freedom): rms of the residuals over what the stand declares */
    uint8_t freedom; /* 3 P - 12, and less by the inclinations and zeros that nothing is known of */
    bool misfits;    /* beyond the limit, or no number */
    bool known;      /* the test has ended, with numbers */
    bool under_way;
    uint8_t stage;
    uint8_t round;    /* of Gauss and Newton */
    uint8_t unknowns; /* fewer where neither encoder nor drift is declared */
    uint8_t columns;  /* unknowns that rows are turned into: all, or those of a mounting */
    uint8_t mounting; /* index in the schedule, */
    uint8_t position; /* likewise, */
    uint8_t channel;
    uint8_t column;                                                             /* and unknown that come next */
    uint8_t means;                                                              /* in the sums */
    double triangle[(TUMBLE_WHOLE_UNKNOWNS * (TUMBLE_WHOLE_UNKNOWNS + 3)) / 2]; /* with right sides, by rows */
    double row[TUMBLE_WHOLE_UNKNOWNS + 1];
    double change[TUMBLE_WHOLE_UNKNOWNS]; /* of the unknowns, in this round; errors in units of their sigma */
    double residual_square;
    double least_v2[TUMBLE_CHANNELS]; /* no mean has less variance */
    tumble_whole_place_t place;
    tumble_coefficients_t coefficients;
    double shared_rad[TUMBLE_WHOLE_SHARED];
    double course[TUMBLE_WHOLE_COURSE];                        /* rad; V */
    float local_rad[TUMBLE_MAX_MOUNTINGS][TUMBLE_WHOLE_LOCAL]; /* where a round is linearised: a float will do */
    float angle_rad[TUMBLE_MAX_POSITIONS];
} tumble_whole_work_t;

/* All at once. Returns TUMBLE_OK, TUMBLE_E_ARGUMENT (null), and what tumble_estimate_least_squares returns. Both results
 * are written on TUMBLE_OK alone. */
tumble_status_t tumble_whole_chi_squared(const tumble_whole_run_t *run, tumble_whole_work_t *work, double *chi_squared,
                                         uint8_t *freedom);

/* Begin a test in steps; the previous result is dropped. Inline, so that a program that may test does not link the test. */
static inline void tumble_whole_begin(tumble_whole_work_t *work)
{
    work->under_way = false;
    work->known = false;
}

/* Take one step of the test of a run and its declared noise, from the averages; see below for the run. All fit positions
 * that have a mean count; there are at least TUMBLE_UNKNOWNS of them, as for any estimate. Call it until it returns false:
 * then the verdict is there. */
bool tumble_whole_step(tumble_whole_work_t *work, const tumble_misfit_run_t *run);

/* ---- Over temperature: K and U0 as polynomials of the block's temperature T,
 *
 *     K(T) = K_0 + K_1 (T - T0) + K_2 (T - T0)^2,     U0(T) likewise,
 *
 * as `tumble solve --temperature` finds them from runs at several temperatures. They hold within the range of those runs,
 * and are refused elsewhere. A new run at one temperature changes K_0 and U0_0, and leaves the slopes as they are:
 *
 *     tumble_calibration_t calibration;
 *     double a_g[TUMBLE_CHANNELS];
 *     if (tumble_thermal_calibration(&thermal, temperature_c, &calibration) == TUMBLE_OK) {
 *         tumble_calibration_apply(&calibration, u_v, a_g);
 *     }
 */
#define TUMBLE_THERMAL_POWERS 3

typedef struct {
    double reference_c; /* T0 */
    double lowest_c;    /* the range, its ends with it */
    double highest_c;
    tumble_coefficients_t power[TUMBLE_THERMAL_POWERS]; /* of (T - T0)^m: V/g and V, per K^m; 0 above the degree */
} tumble_thermal_t;

/* The coefficients at a temperature. Returns TUMBLE_OK; TUMBLE_E_ARGUMENT (null, or the temperature is outside the range);
 * TUMBLE_E_NOT_FINITE (the temperature is not known, or a number of the polynomials is none). */
tumble_status_t tumble_thermal_at(const tumble_thermal_t *thermal, double temperature_c,
                                  tumble_coefficients_t *coefficients);

/* The same inverted. Returns as tumble_thermal_at, and TUMBLE_E_SINGULAR. */
tumble_status_t tumble_thermal_calibration(const tumble_thermal_t *thermal, double temperature_c,
                                           tumble_calibration_t *calibration);

/* A run at one temperature. */
typedef struct {
    double temperature_c;
    const tumble_coefficients_t *coefficients;
    const tumble_uncertainty_t *uncertainty;
} tumble_thermal_run_t;

/* Move the polynomials by what a run says at its temperature; the slopes stay. For each coefficient, with c and u of the
 * polynomials there, g what it may have changed since, c_run and u_run:
 *
 *     c + w (c_run - c),     w = (u^2 + g^2) / (u^2 + g^2 + u_run^2),
 *
 * which is least squares with the polynomials as prior. Its uncertainty is given as (1 - w) sqrt(u^2 + g^2) + w u_run. That
 * is a bound for whatever errors both have in common, as on the same stand; independent ones would make it smaller.
 * `*uncertainty` is that of the polynomials at the run's temperature, before and after. Whether run and polynomials agree
 * at all is for the caller to test before (tumble_commit_objections).
 * Returns TUMBLE_OK; as tumble_thermal_at; TUMBLE_E_ARGUMENT (null, a negative u or g, or all three 0);
 * TUMBLE_E_NOT_FINITE (a number is none, or too large). */
tumble_status_t tumble_thermal_update(tumble_thermal_t *thermal, tumble_uncertainty_t *uncertainty,
                                      const tumble_uncertainty_t *growth, const tumble_thermal_run_t *run);

#ifdef __cplusplus
}
#endif

#endif
