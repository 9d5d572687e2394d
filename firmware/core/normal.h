/* normal.h - the four-unknown normal matrix that the three channels share (private to the core).
 *
 * Every channel obeys u = [a_x a_y a_z 1] (K_ix, K_iy, K_iz, U0_i), with the same rows for all three. So one 4 x 4
 * matrix N = sum r r^T over the fit positions serves them, factored with diagonal pivoting as N = P L D L^T P^T. A
 * pivot is the part of a column that the columns before it do not explain, which makes the rank test one comparison.
 */
#ifndef TUMBLE_CORE_NORMAL_H
#define TUMBLE_CORE_NORMAL_H

#include "tumble/core.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    double m[TUMBLE_UNKNOWNS][TUMBLE_UNKNOWNS]; /* L below the diagonal, D on it */
    uint8_t order[TUMBLE_UNKNOWNS];             /* order[k]: the unknown that pivot k belongs to */
    uint8_t rank;
} tumble_normal_t;

/* Is the position at `index` to be fitted? `measured` may be null: all are. */
bool tumble_normal_uses(const tumble_schedule_t *schedule, const bool *measured, uint8_t index);

/* The row r of the design at a position. */
void tumble_normal_row(const tumble_schedule_t *schedule, uint8_t index, double row[TUMBLE_UNKNOWNS]);

/* Sum and factor N over the positions in use. */
void tumble_normal_build(tumble_normal_t *normal, const tumble_schedule_t *schedule, const bool *measured);

/* One bit per unknown that the null space of N touches; 0 at full rank. */
uint8_t tumble_normal_unidentified(const tumble_normal_t *normal);

/* Solve N x = right; the solution takes its place. Full rank only. */
void tumble_normal_solve(const tumble_normal_t *normal, double right[TUMBLE_UNKNOWNS]);

/* Least squares of one channel over the measured fit positions: x += N^-1 A^T (u - A x), twice (corrected seminormal
 * equations), so that the error grows with the condition of A and not with its square. Full rank only. */
void tumble_normal_fit(const tumble_normal_t *normal, const tumble_schedule_t *schedule, const tumble_means_t *means,
                       int channel, double x[TUMBLE_UNKNOWNS]);

#endif
