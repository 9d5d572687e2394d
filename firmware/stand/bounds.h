/* bounds.h - the bounds of a motion, whatever the stand reports and whatever kind it is.
 *
 * procedure and navcomp command the stand through these functions, and not through its kind: each motion that they
 * begin has three bounds of its own, and the first that is passed stops the table.
 *
 *     way       The reported angle may leave the way from start to goal by TUMBLE_OVERSHOOT_MDEG.           RUNAWAY
 *     time      way / speed, what starting and braking add, and a margin.                TIMEOUT, in homing HOMING
 *     progress  Within half the margin (in homing, which turns back, the whole) the reported angle must change, by more
 *               than a flicker, and at the end it must be at the goal, within the same distance.             STALL
 *               While it changes steadily, it does so at the speed that was told.                            SCALE
 *
 * The last one notices a wrong number of counts in a turn, or a speed that somebody has changed. Steady is what four
 * looks in a row agree on, or three find twice as fast as told: a ramp changes too much from one look to the next.
 *
 *     speed   ^        ____________            looks: a quarter of the ramp apart, at a report that shows progress
 *             |      /|   |   |   |\
 *             |    /  |   |   |   |  \         a ramp: each look differs from the one before by v / 4
 *             |__/____|___|___|___|____\___
 *
 * A motion that is given up leaves the stand in FAULT, on the ladder of its kind's own stop, and its position unknown:
 * after clear_fault it must home. How fast a motion is, the kind tells in report.motion. A kind that does not tell of
 * its motions has the bound of the way alone; one that does not know its speed has those of way and progress.
 */
#ifndef TUMBLE_STAND_BOUNDS_H
#define TUMBLE_STAND_BOUNDS_H

#include "tumble/stand.h"

#define TUMBLE_OVERSHOOT_MDEG 2000
#define TUMBLE_MOTION_MARGIN_MS 2000U /* where the configuration has 0 */

/* Thousandths of a quantity; beyond 1e6, or no number: 1e9. */
int32_t tumble_thousandths(double quantity);

/* The kind's functions of the same names, within the bounds. */
tumble_status_t tumble_stand_home(const tumble_stand_t *stand);
tumble_status_t tumble_stand_move(const tumble_stand_t *stand, double angle_deg);
void tumble_stand_stop(const tumble_stand_t *stand);
tumble_status_t tumble_stand_clear_fault(const tumble_stand_t *stand);
tumble_stand_state_t tumble_stand_state(const tumble_stand_t *stand);
tumble_stand_fault_t tumble_stand_fault(const tumble_stand_t *stand);

/* Nobody knows any more where the table is: before the next move it must home. */
void tumble_stand_lose_position(const tumble_stand_t *stand);

/* Let the kind go on, then look at the bounds. It must be called every 100 ms at least while the table turns. */
void tumble_stand_step(const tumble_stand_t *stand, uint64_t now_us, uint32_t margin_ms);

#endif
