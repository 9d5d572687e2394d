/* schedule.h - test positions: how the block is mounted and how far the table is turned.
 *
 * A schedule is constant data that the caller owns; these functions only read it. They allocate nothing, keep no
 * state, and may be called from anywhere.
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
#ifndef TUMBLE_CORE_SCHEDULE_H
#define TUMBLE_CORE_SCHEDULE_H

#include "core/limits.h"
#include "core/status.h"

#include <stdbool.h>
#include <stdint.h>

/* An angle as data. Range -3600 to 3600 degrees; sine and cosine good to 1e-12. */
typedef struct {
    double deg;
    double sine;
    double cosine;
} tumble_angle_t;

typedef struct {
    uint8_t number;      /* what people call it: 1, 2, ... unique in the schedule */
    double matrix[3][3]; /* proper rotation, orthonormal to 1e-9; rows: block axes x, y, z; columns: h, n, v */
    tumble_angle_t tilt; /* known tilt of the axis out of the horizontal; {0, 0, 1} on a level stand */
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

/* The schedule of the paper: two mountings, nine positions each, table angle (l - 1) * 45 degrees for l = 1..9.
 * Mounting 2 is mounting 1 turned by 180 degrees about the bisector of the block's y and z axes. */
extern const tumble_schedule_t tumble_schedule_paper;

/* Is this schedule usable data? Checks the sizes, then every mounting (number, rotation, tilt), then every position
 * (mounting, number, use, angle), and stops at the first fault. `where` (may be null) then receives the index of that
 * mounting or position; it is left alone when the fault has no place.
 * Returns TUMBLE_OK, TUMBLE_E_SCHEDULE_SIZE, _SCHEDULE_ROTATION, _SCHEDULE_ANGLE, _SCHEDULE_MOUNTING,
 * _SCHEDULE_DUPLICATE, or _ARGUMENT (null, or a `use` outside its list). Every other function expects a schedule that
 * passed. */
tumble_status_t tumble_schedule_validate(const tumble_schedule_t *schedule, uint8_t *where);

/* Index of the position with these numbers, or position_count if there is none. */
uint8_t tumble_schedule_find(const tumble_schedule_t *schedule, uint8_t mounting, uint8_t position);

/* The mounting that the position at `index` is measured in. `index` below position_count, validated schedule. */
const tumble_mounting_t *tumble_schedule_mounting_of(const tumble_schedule_t *schedule, uint8_t index);

/* Specific force a (g) on the block axes x, y, z at the position at `index`, on the ideal stand. */
void tumble_schedule_attitude(const tumble_schedule_t *schedule, uint8_t index, double a_g[TUMBLE_CHANNELS]);

/* Can these positions identify all twelve coefficients? Uses the fit positions, and of those only the measured ones
 * when `measured` is not null (one flag per position). The three channels share one design, so the answer is four
 * bits: bit 0..2 for K_ix, K_iy, K_iz, bit 3 for U0_i of every channel i; set in `unidentified` (may be null) when that
 * coefficient is not determined. Returns TUMBLE_OK, TUMBLE_E_RANK, or _ARGUMENT (null schedule). */
tumble_status_t tumble_schedule_identify(const tumble_schedule_t *schedule, const bool *measured,
                                         uint8_t *unidentified);

/* The strongest column of the design is taken first, then always the one of which the columns taken explain least. As long
 * as what remains has at least this root mean square over the positions, its coefficient counts as identified; below it
 * the noise of a mean would be magnified about a thousandfold. */
#define TUMBLE_MIN_SENSITIVITY_G 1e-3

/* Where a schedule holds the positions of the paper: index of the fit position in each slot [mounting - 1][l - 1]. */
typedef struct {
    uint8_t index[2][9];
} tumble_harmonic_map_t;

/* Find the 2 x 9 positions of the paper among the fit positions, by geometry (matrix, tilt, angle), whatever their
 * numbers; extra positions do no harm. With `measured` (may be null) only measured ones count.
 * `missing` (may be null) receives one bit per empty slot, bit (mounting - 1) * 9 + (l - 1), also on a refusal.
 * Returns TUMBLE_OK; TUMBLE_E_NOT_HARMONIC when the schedule itself lacks one; TUMBLE_E_MISSING_POSITION when it has
 * them all but not all are measured; _ARGUMENT (null). */
tumble_status_t tumble_schedule_harmonic(const tumble_schedule_t *schedule, const bool *measured,
                                         tumble_harmonic_map_t *map, uint32_t *missing);

#endif
