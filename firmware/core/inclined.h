/* inclined.h - the closed form of a block that is bolted on once and inclined with its stand (private to the core). */
#ifndef TUMBLE_CORE_INCLINED_H
#define TUMBLE_CORE_INCLINED_H

#include "tumble/core.h"

/* What an estimate is made of, inclination by inclination as tumble_inclinations_t has them: of the mean outputs of each
 * channel the part that follows the sine of the table angle, its cosine, and neither. */
enum { TUMBLE_SINE, TUMBLE_COSINE, TUMBLE_LEVEL, TUMBLE_HARMONICS };

typedef double tumble_harmonics_t[TUMBLE_MAX_YAWS][TUMBLE_HARMONICS][TUMBLE_CHANNELS];

/* A solved run, and all between its harmonics and its coefficients that their derivatives need. */
typedef struct {
    tumble_inclinations_t seen;
    tumble_harmonics_t harmonics;
    double weight[TUMBLE_CHANNELS]; /* of each channel, the largest 1 */
    double along[TUMBLE_CHANNELS];  /* d: unit vector along which the weighted level parts lie */
    double apart;                   /* length of what it is made of */
    double place[TUMBLE_MAX_YAWS];  /* t_k less their mean */
    double square[TUMBLE_MAX_YAWS]; /* A2_k */
    double bend[TUMBLE_MAX_YAWS];   /* t_k^2 less the line through it */
    double places_squared;          /* sums over the inclinations */
    double bends_squared;
    double skew; /* t_k^2 = skew t_k + spread + bend_k */
    double spread;
    double r; /* of the parabola p + q t + r t^2 */
    double q;
    double vertex; /* A^2, at the level axis */
    double slope;  /* sin beta_k = slope t_k + middle */
    double middle;
    double length[TUMBLE_MAX_YAWS];    /* of the sums that the turn onto the first inclination comes from */
    double column[3][TUMBLE_CHANNELS]; /* K_ih, K_in, K_iv */
    double bias[TUMBLE_CHANNELS];
} tumble_inclined_t;

/* Solve a run by its map; `weights` of the channels, null: equal. Means are numbers that tumble_means_check has passed, and
 * all of the map's positions are measured. Returns TUMBLE_OK, TUMBLE_E_ALIKE, TUMBLE_E_ONE_SIDE. */
tumble_status_t tumble_inclined_solve(const tumble_inclined_map_t *map, const tumble_means_t *means,
                                      const double weights[TUMBLE_CHANNELS], tumble_inclined_t *run);

/* The run that coefficients and inclinations came from, but for its residuals; inclinations null: the schedule's. Returns as
 * tumble_inclined_solve. */
tumble_status_t tumble_inclined_again(const tumble_inclined_map_t *map, const tumble_coefficients_t *coefficients,
                                      const tumble_inclinations_t *inclinations, const double weights[TUMBLE_CHANNELS],
                                      tumble_inclined_t *run);

/* What one unit of each harmonic adds to a sum of coefficients, weighed by `seed`: of K_ih, K_in, K_iv and the bias; and of
 * inclinations, by `sine_seed`: of each sin beta_k. The closed form backwards, step by step. */
void tumble_inclined_gains(const tumble_inclined_map_t *map, const tumble_inclined_t *run,
                           const double seed[4][TUMBLE_CHANNELS], const double sine_seed[TUMBLE_MAX_YAWS],
                           tumble_harmonics_t gains);

#endif
