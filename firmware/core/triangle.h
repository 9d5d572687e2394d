/* triangle.h - elimination: rows of a linear problem become an upper triangle, one by one, by Givens rotations (private
 * to the core).
 *
 * A row has one number for each of the `unknowns`, and its right side behind them. Row j of the triangle begins at its
 * diagonal and ends with its right side; the rows follow each other. All zeros: nothing is known yet.
 */
#ifndef TUMBLE_CORE_TRIANGLE_H
#define TUMBLE_CORE_TRIANGLE_H

/* Row j of the triangle. */
double *tumble_triangle_row(double *triangle, int unknowns, int j);

/* Turn a row into the rows of the triangle `from` to below `to`; a number of the row that is no larger than `tiny`
 * counts as rounding. What is left of its right side, after all of them, is a residual. */
void tumble_triangle_turn(double *triangle, int unknowns, double *row, int from, int to, double tiny);

#endif
