#include "core/normal.h"

#include "core/arith.h"
#include "core/one_copy.h"

#include <stddef.h>

#define N TUMBLE_UNKNOWNS

/* A component of a null vector below this is rounding, not a part of it. */
#define NULL_COMPONENT 1e-7

bool tumble_normal_uses(const tumble_schedule_t *schedule, const bool *measured, uint8_t index)
{
    return (schedule->positions[index].use == TUMBLE_USE_FIT) && ((measured == NULL) || measured[index]);
}

void tumble_normal_row(const tumble_schedule_t *schedule, uint8_t index, double row[N])
{
    tumble_schedule_attitude(schedule, index, row);
    row[TUMBLE_CHANNELS] = 1.0;
}

static void add_multiple(double *sum, double factor, const double *x, int count)
{
    for (int j = 0; j < count; j++) {
        sum[j] += factor * x[j];
    }
}

/* u - a x */
static double residual_of(double u, const double *a, const double *x, int count)
{
    for (int j = 0; j < count; j++) {
        u -= a[j] * x[j];
    }
    return u;
}

/* Symmetric exchange of unknowns a and b, in the part already factored as in the rest. */
TUMBLE_ONE_COPY static void exchange(tumble_normal_t *normal, int a, int b)
{
    for (int j = 0; j < N; j++) {
        const double keep = normal->m[a][j];
        normal->m[a][j] = normal->m[b][j];
        normal->m[b][j] = keep;
    }
    for (int i = 0; i < N; i++) {
        const double keep = normal->m[i][a];
        normal->m[i][a] = normal->m[i][b];
        normal->m[i][b] = keep;
    }
    const uint8_t keep = normal->order[a];
    normal->order[a] = normal->order[b];
    normal->order[b] = keep;
}

static int largest_pivot(const tumble_normal_t *normal, int from)
{
    int best = from;
    for (int i = from + 1; i < N; i++) {
        if (tumble_exceeds(normal->m[i][i], normal->m[best][best])) {
            best = i;
        }
    }
    return best;
}

/* Take the pivot k out of the rows and columns behind it. */
static void eliminate(tumble_normal_t *normal, int k)
{
    for (int i = k + 1; i < N; i++) {
        const double l = normal->m[i][k] / normal->m[k][k];
        add_multiple(&normal->m[i][k + 1], -l, &normal->m[k][k + 1], N - (k + 1));
        normal->m[i][k] = l;
    }
}

static void factor(tumble_normal_t *normal, double smallest_pivot)
{
    for (int k = 0; k < N; k++) {
        exchange(normal, k, largest_pivot(normal, k));
        if (!tumble_exceeds(normal->m[k][k], smallest_pivot)) {
            break;
        }
        eliminate(normal, k);
        normal->rank++;
    }
}

void tumble_normal_build(tumble_normal_t *normal, const tumble_schedule_t *schedule, const bool *measured)
{
    *normal = (tumble_normal_t){.order = {0, 1, 2, 3}};
    double positions = 0.0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        if (!tumble_normal_uses(schedule, measured, p)) {
            continue;
        }
        double row[N];
        tumble_normal_row(schedule, p, row);
        for (int i = 0; i < N; i++) {
            add_multiple(normal->m[i], row[i], row, N);
        }
        positions += 1.0;
    }
    factor(normal, positions * TUMBLE_MIN_SENSITIVITY_G * TUMBLE_MIN_SENSITIVITY_G);
}

/* One step of back substitution in L^T z. */
static void substitute_back(const tumble_normal_t *normal, int i, double z[N])
{
    for (int j = i + 1; j < N; j++) {
        z[i] -= normal->m[j][i] * z[j];
    }
}

/* The null vector whose free unknown is `free`: back substitution in L^T z = 0 with z[free] = 1. */
static void null_vector(const tumble_normal_t *normal, int free, double z[N])
{
    for (int i = 0; i < N; i++) {
        z[i] = (i == free) ? 1.0 : 0.0;
    }
    for (int i = (int)normal->rank - 1; i >= 0; i--) {
        substitute_back(normal, i, z);
    }
}

uint8_t tumble_normal_unidentified(const tumble_normal_t *normal)
{
    unsigned bits = 0;
    for (int free = (int)normal->rank; free < N; free++) {
        double z[N];
        null_vector(normal, free, z);
        for (int i = 0; i < N; i++) {
            if (!tumble_within(z[i], NULL_COMPONENT)) {
                bits |= 1U << normal->order[i];
            }
        }
    }
    return (uint8_t)bits;
}

void tumble_normal_solve(const tumble_normal_t *normal, double right[N])
{
    double z[N] = {0.0, 0.0, 0.0, 0.0};
    for (int i = 0; i < N; i++) { /* L */
        z[i] = residual_of(right[normal->order[i]], normal->m[i], z, i);
    }
    for (int i = N - 1; i >= 0; i--) { /* D L^T */
        z[i] /= normal->m[i][i];
        substitute_back(normal, i, z);
        right[normal->order[i]] = z[i];
    }
}

void tumble_normal_fit(const tumble_normal_t *normal, const tumble_schedule_t *schedule, const tumble_means_t *means,
                       int channel, double x[N])
{
    for (int j = 0; j < N; j++) {
        x[j] = 0.0;
    }
    for (int pass = 0; pass < 2; pass++) { /* from zero, the first pass solves the normal equations themselves */
        double right[N] = {0.0, 0.0, 0.0, 0.0};
        for (uint8_t p = 0; p < schedule->position_count; p++) {
            if (tumble_normal_uses(schedule, means->measured, p)) {
                double row[N];
                tumble_normal_row(schedule, p, row);
                add_multiple(right, residual_of(means->u_v[p][channel], row, x, N), row, N);
            }
        }
        tumble_normal_solve(normal, right);
        for (int j = 0; j < N; j++) {
            x[j] += right[j];
        }
    }
}

tumble_status_t tumble_schedule_identify(const tumble_schedule_t *schedule, const bool *measured, uint8_t *unidentified)
{
    if (schedule == NULL) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_normal_t normal;
    tumble_normal_build(&normal, schedule, measured);
    const uint8_t missing = tumble_normal_unidentified(&normal);
    if (unidentified != NULL) {
        *unidentified = missing;
    }
    return (missing == 0U) ? TUMBLE_OK : TUMBLE_E_RANK;
}
