/* optimal_definition.h - the stand-optimal estimator as it is defined, in matrices: y = A beta + J s + D delta + e. Everything
 * is kept, nothing is shared between passes; angles are whole, in degrees, through the simulation's sine and cosine.
 */
#ifndef TUMBLE_TESTS_UNIT_OPTIMAL_DEFINITION_H
#define TUMBLE_TESTS_UNIT_OPTIMAL_DEFINITION_H

#include "gain_bench.h"
#include "simulation/maths.h"

#define MOST_COLUMNS (3U * TUMBLE_MAX_POSITIONS)
#define MOST_ROWS (14U + TUMBLE_MAX_YAWS)

typedef struct {
    const gain_bytes_t *record;
    const tumble_schedule_t *schedule;
    unsigned columns;
    unsigned rows;
    double y[MOST_COLUMNS];
    double e[MOST_COLUMNS];
    double x[MOST_ROWS];
    double delta[TUMBLE_MAX_POSITIONS];
    uint8_t position[TUMBLE_MAX_POSITIONS]; /* of the schedule, by fit position */
} definition_t;

/* Force on the block's axes with every angle as a whole, in degrees. */
static inline void force_at(const tumble_schedule_t *schedule, uint8_t p, double tilt_deg, double angle_deg,
                            double yaw_deg, double a_g[3])
{
    const tumble_mounting_t *mounting = model_mounting(schedule, p);
    double st, ct, sp, cp, sy, cy;
    sim_sincos_deg(mounting->tilt.deg + tilt_deg, &st, &ct);
    sim_sincos_deg(schedule->positions[p].angle.deg + angle_deg, &sp, &cp);
    sim_sincos_deg(yaw_deg, &sy, &cy);
    const double h = ct * sp;
    const double yawed[3] = {h * cy + st * sy, st * cy - h * sy, ct * cp};
    for (int i = 0; i < 3; i++) {
        a_g[i] =
            mounting->matrix[i][0] * yawed[0] + mounting->matrix[i][1] * yawed[1] + mounting->matrix[i][2] * yawed[2];
    }
}

static inline double yaw_of(const definition_t *d, uint8_t p)
{
    const long mounting = model_mounting(d->schedule, p) - d->schedule->mountings;
    return d->x[14 + ((d->rows == 15U) ? 0 : mounting)];
}

/* Derivatives of the force: by the tilt it is the force a quarter turn on; by the angle likewise, less the part along the
 * axis; by the yaw what is left of a quarter turn after what yaw does not touch. */
static inline void derivatives_at(const tumble_schedule_t *schedule, uint8_t p, double by_tilt[3], double by_angle[3],
                                  double by_yaw[3])
{
    const tumble_mounting_t *mounting = model_mounting(schedule, p);
    double along[3];
    double upwards[3];
    double st, ct, sp, cp;
    sim_sincos_deg(mounting->tilt.deg, &st, &ct);
    sim_sincos_deg(schedule->positions[p].angle.deg, &sp, &cp);
    force_at(schedule, p, 90.0, 0.0, 0.0, by_tilt);
    force_at(schedule, p, 0.0, 90.0, 0.0, by_angle);
    force_at(schedule, p, 0.0, 0.0, 90.0, by_yaw);
    for (int i = 0; i < 3; i++) {
        along[i] = mounting->matrix[i][1] * st;
        upwards[i] = mounting->matrix[i][2] * ct * cp;
        by_angle[i] -= along[i];
        by_yaw[i] -= upwards[i];
    }
}

static inline double k_times(const double *k, int channel, const double a[3])
{
    return k[3 * channel] * a[0] + k[3 * channel + 1] * a[1] + k[3 * channel + 2] * a[2];
}

static inline void define_position(definition_t *d, unsigned fit)
{
    const uint8_t p = d->position[fit];
    double k_t[9];
    double ideal[3], exact[3], by_tilt[3], by_angle[3], by_yaw[3];
    double numerator = 0.0;
    double square = 0.0;
    for (unsigned n = 0; n < 9U; n++) {
        k_t[n] = number_at(d->record, AT_K + n);
    }
    force_at(d->schedule, p, 0.0, 0.0, 0.0, ideal);
    derivatives_at(d->schedule, p, by_tilt, by_angle, by_yaw);
    double linear[3];
    for (int i = 0; i < 3; i++) {
        linear[i] = k_times(d->x, i, ideal) + d->x[9 + i] + k_times(k_t, i, by_tilt) * d->x[12] +
                    k_times(k_t, i, by_angle) * d->x[13] + k_times(k_t, i, by_yaw) * yaw_of(d, p);
        const double r = d->y[3U * fit + (unsigned)i] - d->e[3U * fit + (unsigned)i] - linear[i];
        numerator += k_times(k_t, i, by_angle) * r;
        square += k_times(k_t, i, by_angle) * k_times(k_t, i, by_angle);
    }
    const double variance = number_at(d->record, AT_SIGMA + 3U) * number_at(d->record, AT_SIGMA + 3U);
    const double noise = number_at(d->record, AT_NOISE) * number_at(d->record, AT_NOISE);
    d->delta[fit] = variance * numerator / (noise + variance * square);
    force_at(d->schedule, p, SIM_DEG_PER_RAD * d->x[12], SIM_DEG_PER_RAD * (d->x[13] + d->delta[fit]),
             SIM_DEG_PER_RAD * yaw_of(d, p), exact);
    for (int i = 0; i < 3; i++) {
        d->e[3U * fit + (unsigned)i] =
            k_times(d->x, i, exact) + d->x[9 + i] - linear[i] - k_times(k_t, i, by_angle) * d->delta[fit];
    }
}

static inline void apply_definition(definition_t *d)
{
    for (unsigned row = 0; row < d->rows; row++) {
        d->x[row] = 0.0;
        for (unsigned column = 0; column < d->columns; column++) {
            d->x[row] += number_at(d->record, AT_GAINS + row * d->columns + column) * (d->y[column] - d->e[column]);
        }
    }
}

static inline definition_t solve_by_definition(const gain_bytes_t *record, const tumble_schedule_t *schedule,
                                               const tumble_means_t *means, unsigned yaws)
{
    definition_t d = {
        .record = record, .schedule = schedule, .columns = 3U * count_fit_positions(schedule), .rows = 14U + yaws};
    unsigned fit = 0;
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        if (schedule->positions[p].use == TUMBLE_USE_FIT) {
            d.position[fit] = p;
            memcpy(&d.y[3U * fit], means->u_v[p], sizeof means->u_v[p]);
            fit++;
        }
    }
    apply_definition(&d);
    for (int correction = 0; correction < 2; correction++) {
        for (unsigned f = 0; f < fit; f++) {
            define_position(&d, f);
        }
        apply_definition(&d);
    }
    return d;
}

#endif
