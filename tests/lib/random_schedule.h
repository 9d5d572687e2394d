/* random_schedule.h - schedules nobody would choose, that every estimator takes: any rotations, tilted axes, check positions, odd numbers. */
#ifndef TUMBLE_TESTS_UNIT_RANDOM_SCHEDULE_H
#define TUMBLE_TESTS_UNIT_RANDOM_SCHEDULE_H

#include "model.h"

typedef struct {
    tumble_mounting_t mountings[TUMBLE_MAX_YAWS];
    tumble_position_t positions[TUMBLE_MAX_POSITIONS];
    tumble_schedule_t schedule; /* points at the two above: do not copy */
} random_schedule_t;

static inline tumble_mounting_t random_mounting(dice_t *dice, uint8_t number)
{
    static const tumble_angle_t tilts[] = {LEVEL,
                                           LEVEL,
                                           {5.0, 0.08715574274765818, 0.99619469809174555},
                                           {-10.0, -0.17364817766693036, 0.98480775301220802},
                                           {20.0, 0.34202014332566871, 0.93969262078590843}};
    tumble_mounting_t mounting = {.number = number, .tilt = tilts[dice_below(dice, COUNT_OF(tilts))]};
    random_rotation(dice, mounting.matrix);
    return mounting;
}

static inline void random_schedule(dice_t *dice, random_schedule_t *s)
{
    const uint8_t mountings = (uint8_t)(1U + dice_below(dice, TUMBLE_MAX_YAWS));
    const uint8_t positions = (uint8_t)(1U + dice_below(dice, TUMBLE_MAX_POSITIONS));
    for (uint8_t m = 0; m < mountings; m++) {
        s->mountings[m] = random_mounting(dice, (uint8_t)(200U - 7U * m));
    }
    for (uint8_t p = 0; p < positions; p++) {
        s->positions[p] = (tumble_position_t){
            .mounting = s->mountings[dice_below(dice, mountings)].number,
            .number = (uint8_t)(100U - p),
            .use = (dice_below(dice, 8) == 0U) ? TUMBLE_USE_CHECK : TUMBLE_USE_FIT,
            .angle = steps_of_7_5_deg[dice_below(dice, STEP_COUNT)],
        };
    }
    s->schedule = (tumble_schedule_t){s->mountings, s->positions, mountings, positions};
}

/* So many mountings, each with one position: that of the paper's first. */
static inline void free_attitudes(uint8_t count, tumble_mounting_t *mountings, tumble_position_t *positions,
                                  tumble_schedule_t *schedule)
{
    for (uint8_t m = 0; m < count; m++) {
        mountings[m] = tumble_schedule_paper.mountings[0];
        positions[m] = tumble_schedule_paper.positions[0];
        mountings[m].number = (uint8_t)(m + 1U);
        positions[m].mounting = mountings[m].number;
    }
    *schedule = (tumble_schedule_t){mountings, positions, count, count};
}

static inline uint8_t count_fit_positions(const tumble_schedule_t *schedule)
{
    uint8_t count = 0;
    for (unsigned p = 0; p < schedule->position_count; p++) {
        if (schedule->positions[p].use == TUMBLE_USE_FIT) {
            count++;
        }
    }
    return count;
}

#endif
