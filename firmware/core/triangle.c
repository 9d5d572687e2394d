#include "core/triangle.h"

#include "core/arith.h"

double *tumble_triangle_row(double *triangle, int unknowns, int j)
{
    return &triangle[(j * (unknowns + 1)) - ((j * (j - 1)) / 2)];
}

void tumble_triangle_turn(double *triangle, int unknowns, double *row, int from, int to, double tiny)
{
    for (int j = from; j < to; j++) {
        if (tumble_within(row[j], tiny)) {
            continue;
        }
        double *r = tumble_triangle_row(triangle, unknowns, j);
        const double length = tumble_sqrt((r[0] * r[0]) + (row[j] * row[j]));
        const double c = r[0] / length;
        const double s = row[j] / length;
        for (int k = j; k <= unknowns; k++) {
            const double kept = (c * r[k - j]) + (s * row[k]);
            row[k] = (c * row[k]) - (s * r[k - j]);
            r[k - j] = kept;
        }
    }
}
