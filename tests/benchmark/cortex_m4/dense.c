/* dense.c - least squares of all twelve coefficients at once, for comparison only. */
#include "benchmark.h"
#include "core/arith.h"

#include <string.h>

#define N TUMBLE_COEFFICIENTS
#define ROWS (3 * 18)

static void make_row(const tumble_schedule_t *schedule, uint8_t p, int channel, double row[N])
{
    double a[3];
    tumble_schedule_attitude(schedule, p, a);
    memset(row, 0, N * sizeof *row);
    for (int j = 0; j < 3; j++) {
        row[3 * channel + j] = a[j];
    }
    row[9 + channel] = 1.0;
}

static void unpack(const double x[N], tumble_coefficients_t *coefficients)
{
    memcpy(coefficients->k_v_per_g, x, sizeof coefficients->k_v_per_g);
    memcpy(coefficients->u0_v, x + 9, sizeof coefficients->u0_v);
}

/* N = L L^T in place, then both triangles. */
static void cholesky(double m[N][N], double x[N])
{
    for (int j = 0; j < N; j++) {
        for (int i = j; i < N; i++) {
            double sum = m[i][j];
            for (int k = 0; k < j; k++) {
                sum -= m[i][k] * m[j][k];
            }
            m[i][j] = (i == j) ? tumble_sqrt(sum) : sum / m[j][j];
        }
        for (int k = 0; k < j; k++) {
            x[j] -= m[j][k] * x[k];
        }
        x[j] /= m[j][j];
    }
    for (int j = N - 1; j >= 0; j--) {
        for (int i = j + 1; i < N; i++) {
            x[j] -= m[i][j] * x[i];
        }
        x[j] /= m[j][j];
    }
}

tumble_status_t dense_normal_equations(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                       tumble_coefficients_t *coefficients)
{
    double m[N][N];
    double x[N];
    memset(m, 0, sizeof m);
    memset(x, 0, sizeof x);
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        for (int channel = 0; channel < 3; channel++) {
            double row[N];
            make_row(schedule, p, channel, row);
            for (int i = 0; i < N; i++) {
                for (int j = 0; j <= i; j++) {
                    m[i][j] += row[i] * row[j];
                }
                x[i] += row[i] * means->u_v[p][channel];
            }
        }
    }
    cholesky(m, x);
    unpack(x, coefficients);
    return TUMBLE_OK;
}

/* Reflect column k, and with it those behind. The right side is column N. */
static void reflect(double q[ROWS][N + 1], int k)
{
    double square = 0.0;
    for (int i = k; i < ROWS; i++) {
        square += q[i][k] * q[i][k];
    }
    const double length = (q[k][k] > 0.0) ? -tumble_sqrt(square) : tumble_sqrt(square);
    const double scale = 1.0 / (square - q[k][k] * length);
    q[k][k] -= length;
    for (int j = k + 1; j <= N; j++) {
        double sum = 0.0;
        for (int i = k; i < ROWS; i++) {
            sum += q[i][k] * q[i][j];
        }
        sum *= scale;
        for (int i = k; i < ROWS; i++) {
            q[i][j] -= sum * q[i][k];
        }
    }
    q[k][k] = length;
}

tumble_status_t dense_householder(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                  tumble_coefficients_t *coefficients)
{
    double q[ROWS][N + 1];
    double x[N];
    for (int i = 0; i < ROWS; i++) {
        make_row(schedule, (uint8_t)(i / 3), i % 3, q[i]);
        q[i][N] = means->u_v[i / 3][i % 3];
    }
    for (int k = 0; k < N; k++) {
        reflect(q, k);
    }
    for (int j = N - 1; j >= 0; j--) {
        x[j] = q[j][N];
        for (int i = j + 1; i < N; i++) {
            x[j] -= q[j][i] * x[i];
        }
        x[j] /= q[j][j];
    }
    unpack(x, coefficients);
    return TUMBLE_OK;
}

/* What one would write who sees that the channels share one design: a normal matrix of four unknowns, no checks at all. */
tumble_status_t shared_normal_matrix(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                     tumble_coefficients_t *coefficients)
{
    double m[4][4] = {{0.0}};
    double x[TUMBLE_CHANNELS][4] = {{0.0}};
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        double row[4] = {0.0, 0.0, 0.0, 1.0};
        tumble_schedule_attitude(schedule, p, row);
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j <= i; j++) {
                m[i][j] += row[i] * row[j];
            }
            for (int channel = 0; channel < TUMBLE_CHANNELS; channel++) {
                x[channel][i] += row[i] * means->u_v[p][channel];
            }
        }
    }
    for (int j = 0; j < 4; j++) { /* m = L D L^T in place */
        for (int i = j + 1; i < 4; i++) {
            const double factor = m[i][j] / m[j][j];
            for (int k = i; k < 4; k++) {
                m[k][i] -= factor * m[k][j];
            }
            for (int channel = 0; channel < TUMBLE_CHANNELS; channel++) {
                x[channel][i] -= factor * x[channel][j];
            }
        }
    }
    for (int channel = 0; channel < TUMBLE_CHANNELS; channel++) {
        for (int j = 3; j >= 0; j--) {
            for (int i = j + 1; i < 4; i++) {
                x[channel][j] -= m[i][j] * x[channel][i];
            }
            x[channel][j] /= m[j][j];
        }
        memcpy(coefficients->k_v_per_g[channel], x[channel], sizeof coefficients->k_v_per_g[channel]);
        coefficients->u0_v[channel] = x[channel][3];
    }
    return TUMBLE_OK;
}
