/* schedules.c - the built-in schedules beside the paper's, which stands alone for targets that hold no other. */
#include "core/schedule_data.h"

/* clang-format off */
#define FOUR_POSITIONS(mounting)                    \
    {(mounting), 1, TUMBLE_USE_FIT, TUMBLE_AT_45},  \
    {(mounting), 2, TUMBLE_USE_FIT, TUMBLE_AT_135}, \
    {(mounting), 3, TUMBLE_USE_FIT, TUMBLE_AT_225}, \
    {(mounting), 4, TUMBLE_USE_FIT, TUMBLE_AT_315}
#define FIVE_POSITIONS(mounting)                    \
    FOUR_POSITIONS(mounting), {(mounting), 5, TUMBLE_USE_CHECK, TUMBLE_AT_45}
#define LEVEL TUMBLE_AT_0
#define UP    { 45.0,  TUMBLE_HALF_SQRT2, TUMBLE_HALF_SQRT2}
#define DOWN  {-45.0, -TUMBLE_HALF_SQRT2, TUMBLE_HALF_SQRT2}
#define INCLINATION(number, tilt) {(number), {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, tilt, 1}
/* clang-format on */

static const tumble_mounting_t two[] = {TUMBLE_H_N_V, TUMBLE_MH_V_N};
static const tumble_mounting_t three[] = {TUMBLE_H_N_V, TUMBLE_MH_V_N, TUMBLE_N_V_H};
static const tumble_mounting_t inclinations[] = {INCLINATION(1, LEVEL), INCLINATION(2, UP), INCLINATION(3, DOWN),
                                                 INCLINATION(4, LEVEL)};

static const tumble_position_t faces[] = {
    {1, 1, TUMBLE_USE_FIT, TUMBLE_AT_0},   /* z up */
    {1, 3, TUMBLE_USE_FIT, TUMBLE_AT_90},  /* x up */
    {1, 5, TUMBLE_USE_FIT, TUMBLE_AT_180}, /* z down */
    {1, 7, TUMBLE_USE_FIT, TUMBLE_AT_270}, /* x down */
    {2, 1, TUMBLE_USE_FIT, TUMBLE_AT_0},   /* y up */
    {2, 5, TUMBLE_USE_FIT, TUMBLE_AT_180}, /* y down */
};
/* The last column says which axis of the block is up; how it is turned about the vertical does not matter. */
static const tumble_mounting_t laid[] = {
    {1, {{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}, LEVEL, 0},   /* x up */
    {2, {{0.0, 0.0, -1.0}, {-1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}, LEVEL, 0}, /* x down */
    {3, {{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}}, LEVEL, 0},   /* y up */
    {4, {{0.0, 1.0, 0.0}, {0.0, 0.0, -1.0}, {-1.0, 0.0, 0.0}}, LEVEL, 0}, /* y down */
    {5, {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, LEVEL, 0},   /* z up */
    {6, {{1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {0.0, 0.0, -1.0}}, LEVEL, 0}, /* z down */
};
static const tumble_position_t once_each[] = {{1, 1, TUMBLE_USE_FIT, TUMBLE_AT_0}, {2, 1, TUMBLE_USE_FIT, TUMBLE_AT_0},
                                              {3, 1, TUMBLE_USE_FIT, TUMBLE_AT_0}, {4, 1, TUMBLE_USE_FIT, TUMBLE_AT_0},
                                              {5, 1, TUMBLE_USE_FIT, TUMBLE_AT_0}, {6, 1, TUMBLE_USE_FIT, TUMBLE_AT_0}};
static const tumble_position_t nines[] = {TUMBLE_NINE_POSITIONS(1, FIT), TUMBLE_NINE_POSITIONS(2, FIT),
                                          TUMBLE_NINE_POSITIONS(3, FIT)};
static const tumble_position_t fours[] = {FOUR_POSITIONS(1), FOUR_POSITIONS(2), FOUR_POSITIONS(3)};
static const tumble_position_t fives[] = {FIVE_POSITIONS(1), FIVE_POSITIONS(2), FIVE_POSITIONS(3)};
static const tumble_position_t inclined[] = {TUMBLE_NINE_POSITIONS(1, CHECK), TUMBLE_NINE_POSITIONS(2, CHECK),
                                             TUMBLE_NINE_POSITIONS(3, CHECK), TUMBLE_NINE_POSITIONS(4, CHECK)};

const tumble_schedule_t tumble_schedule_hand_laid = TUMBLE_SCHEDULE_OF(laid, once_each);
const tumble_schedule_t tumble_schedule_six_faces = TUMBLE_SCHEDULE_OF(two, faces);
const tumble_schedule_t tumble_schedule_three_mountings = TUMBLE_SCHEDULE_OF(three, nines);
const tumble_schedule_t tumble_schedule_diagonal = TUMBLE_SCHEDULE_OF(three, fours);
const tumble_schedule_t tumble_schedule_diagonal_closed = TUMBLE_SCHEDULE_OF(three, fives);
const tumble_schedule_t tumble_schedule_inclined = {inclinations, inclined, 3, 27};
const tumble_schedule_t tumble_schedule_inclined_closed = {inclinations, inclined, 4, 36};
