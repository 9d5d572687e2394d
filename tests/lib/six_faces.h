/* six_faces.h - the oldest of all schedules: each axis of the block up, then down; one mounting for each axis. */
#ifndef TUMBLE_TESTS_UNIT_SIX_FACES_H
#define TUMBLE_TESTS_UNIT_SIX_FACES_H

#include "model.h"

static const tumble_mounting_t six_faces_mountings[] = {
    {1, {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, LEVEL, 0}, /* x up at 0 */
    {2, {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, LEVEL, 0}, /* y up */
    {3, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, LEVEL, 0}, /* z up */
};

static const tumble_position_t six_faces_positions[] = {
    {1, 1, TUMBLE_USE_FIT, LEVEL},        {1, 2, TUMBLE_USE_FIT, {180, 0, -1}}, {2, 1, TUMBLE_USE_FIT, LEVEL},
    {2, 2, TUMBLE_USE_FIT, {180, 0, -1}}, {3, 1, TUMBLE_USE_FIT, LEVEL},        {3, 2, TUMBLE_USE_FIT, {180, 0, -1}},
};

static const tumble_schedule_t six_faces = {six_faces_mountings, six_faces_positions, 3, 6};

#endif
