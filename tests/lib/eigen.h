/* eigen.h - eigenvalues and eigenvectors of a symmetric 4 x 4 matrix by Jacobi's rotations, for oracles of rank. */
#ifndef TUMBLE_TESTS_UNIT_EIGEN_H
#define TUMBLE_TESTS_UNIT_EIGEN_H

#include "model.h"

typedef struct {
    double value[TUMBLE_UNKNOWNS];
    double vector[TUMBLE_UNKNOWNS][TUMBLE_UNKNOWNS]; /* [k]: of value[k] */
} eigen_t;

static inline void eigen_rotate(double a[4][4], double v[4][4], int p, int q)
{
    if (a[p][q] == 0.0) {
        return;
    }
    const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    const double t = ((theta < 0.0) ? -1.0 : 1.0) / (magnitude(theta) + sqrt(theta * theta + 1.0));
    const double c = 1.0 / sqrt(t * t + 1.0);
    const double s = t * c;
    for (int k = 0; k < 4; k++) {
        const double x = a[k][p];
        const double y = a[k][q];
        a[k][p] = c * x - s * y;
        a[k][q] = s * x + c * y;
    }
    for (int k = 0; k < 4; k++) {
        const double x = a[p][k];
        const double y = a[q][k];
        a[p][k] = c * x - s * y;
        a[q][k] = s * x + c * y;
    }
    for (int k = 0; k < 4; k++) {
        const double x = v[p][k];
        const double y = v[q][k];
        v[p][k] = c * x - s * y;
        v[q][k] = s * x + c * y;
    }
}

static inline eigen_t eigen_of(double a[4][4])
{
    eigen_t result = {{0}, {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    for (int sweep = 0; sweep < 20; sweep++) {
        for (int p = 0; p < 3; p++) {
            for (int q = p + 1; q < 4; q++) {
                eigen_rotate(a, result.vector, p, q);
            }
        }
    }
    for (int k = 0; k < 4; k++) {
        result.value[k] = a[k][k];
    }
    return result;
}

/* Of the mean square design of the fit positions, the measured ones if `measured` is given. */
static inline eigen_t eigen_of_design(const tumble_schedule_t *schedule, const bool *measured)
{
    double normal[4][4] = {{0}};
    double n = 0.0;
    for (unsigned p = 0; p < schedule->position_count; p++) {
        if (schedule->positions[p].use == TUMBLE_USE_FIT && (measured == NULL || measured[p])) {
            dd_t a[TUMBLE_CHANNELS];
            model_attitude(schedule, p, a);
            const double row[4] = {dd_round(a[0]), dd_round(a[1]), dd_round(a[2]), 1.0};
            for (int i = 0; i < 16; i++) {
                normal[i / 4][i % 4] += row[i / 4] * row[i % 4];
            }
            n += 1.0;
        }
    }
    for (int i = 0; i < 16; i++) {
        normal[i / 4][i % 4] /= (n > 0.0) ? n : 1.0;
    }
    return eigen_of(normal);
}

#endif
