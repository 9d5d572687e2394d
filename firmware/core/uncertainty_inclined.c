#include "core/arith.h"
#include "core/inclined.h"
#include "core/uncertainty.h"

#include <stddef.h>
#include <string.h>

typedef struct {
    tumble_inclined_map_t map;
    tumble_inclined_t run;
    tumble_harmonics_t gains;          /* of the coefficient, or with an attitude of |a|; */
    double sine_seed[TUMBLE_MAX_YAWS]; /* or of an inclination: 1 / cos beta_k in its place. Else 0 */
    bool of_inclination;
    tumble_angle_t tilt;  /* of the mounting and */
    tumble_angle_t angle; /* of the position that were asked for last, as the run shows them */
} inclined_t;

/* Where a mounting stands among the inclinations. */
static uint8_t inclination_of(const inclined_t *inclined, const tumble_mounting_t *mounting)
{
    const tumble_inclined_map_t *map = &inclined->map;
    uint8_t k = 0;
    while ((k < (map->count - 1U)) && (&map->schedule->mountings[map->mounting[k]] != mounting)) {
        k++;
    }
    return k;
}

static const tumble_angle_t *tilt_of(const tumble_gains_t *gains, const tumble_mounting_t *mounting)
{
    inclined_t *inclined = gains->hooked;
    const uint8_t k = inclination_of(inclined, mounting);
    inclined->tilt = (tumble_angle_t){0.0, inclined->run.seen.sine[k], inclined->run.seen.cosine[k]};
    return &inclined->tilt;
}

/* What a harmonic weighs, times what the mean weighs in it (core/inclined.c). The table angle counts from its zero. */
static const tumble_angle_t *gains_at(const tumble_gains_t *gains, uint8_t p, double g[TUMBLE_CHANNELS])
{
    inclined_t *inclined = gains->hooked;
    const tumble_schedule_t *schedule = inclined->map.schedule;
    const tumble_angle_t *angle = &schedule->positions[p].angle;
    const uint8_t k = inclination_of(inclined, tumble_schedule_mounting_of(schedule, p));
    const double (*of)[TUMBLE_CHANNELS] = (const double (*)[TUMBLE_CHANNELS])inclined->gains[k];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double waves = (of[TUMBLE_SINE][i] * angle->sine) + (of[TUMBLE_COSINE][i] * angle->cosine);
        g[i] = ((2.0 * waves) + of[TUMBLE_LEVEL][i]) / (double)inclined->map.positions[k];
    }
    const double cosine = inclined->run.seen.turn_cosine[k];
    const double sine = inclined->run.seen.turn_sine[k];
    inclined->angle = (tumble_angle_t){angle->deg, (angle->sine * cosine) + (angle->cosine * sine),
                                       (angle->cosine * cosine) - (angle->sine * sine)};
    return &inclined->angle;
}

/* The gains of the harmonics in the coefficient, or with an attitude n in the length of the shown specific force. K_ij is
 * the sum of K_ih, K_in, K_iv over row j of the mounting's matrix. */
static void solve(const tumble_gains_t *gains)
{
    inclined_t *inclined = gains->hooked;
    const tumble_inclined_map_t *map = &inclined->map;
    const double (*matrix)[3] = map->schedule->mountings[map->mounting[0]].matrix;
    const double *attitude = gains->run->attitude;
    double seed[TUMBLE_UNKNOWNS][TUMBLE_CHANNELS] = {0};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const bool counts = !inclined->of_inclination && ((attitude != NULL) || (i == gains->channel));
        const double weight = !counts ? 0.0 : (attitude != NULL) ? gains->by_channel[i] : 1.0;
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            const double of_axis = (attitude != NULL) ? attitude[j] : (j == gains->unknown) ? 1.0 : 0.0;
            for (int n = 0; n < 3; n++) {
                seed[n][i] += weight * of_axis * matrix[j][n];
            }
        }
        seed[TUMBLE_BIAS][i] = ((attitude != NULL) || (gains->unknown == TUMBLE_BIAS)) ? weight : 0.0;
    }
    tumble_inclined_gains(map, &inclined->run, (const double (*)[TUMBLE_CHANNELS])seed, inclined->sine_seed,
                          inclined->gains);
}

static const tumble_gains_hooks_t hooks = {solve, tilt_of, gains_at};

/* Check the run, and solve it again. */
static tumble_status_t prepare(const tumble_judged_run_t *run, const tumble_uncertainty_t *uncertainty,
                               inclined_t *inclined, tumble_refusal_t *refusal)
{
    uint64_t missing = 0;
    (void)memset(inclined->sine_seed, 0, sizeof inclined->sine_seed);
    inclined->of_inclination = false;
    tumble_status_t status = tumble_uncertainty_check(run, uncertainty);
    if (status == TUMBLE_OK) {
        status = tumble_schedule_inclinations(run->schedule, run->measured, &inclined->map, &missing);
    }
    if (refusal != NULL) {
        *refusal = (tumble_refusal_t){missing, 0};
    }
    return (status == TUMBLE_OK) ? tumble_inclined_again(&inclined->map, run->coefficients, run->inclinations,
                                                         run->weights, &inclined->run)
                                 : status;
}

tumble_status_t tumble_uncertainty_inclined(const tumble_judged_run_t *run, tumble_uncertainty_t *uncertainty,
                                            tumble_refusal_t *refusal)
{
    inclined_t inclined;
    tumble_gains_t gains = {.run = run, .kind = TUMBLE_GAINS_HOOKED, .hooks = &hooks, .hooked = &inclined};
    const tumble_status_t status = prepare(run, uncertainty, &inclined, refusal);
    return (status == TUMBLE_OK) ? tumble_uncertainty_judge(&gains, uncertainty) : status;
}

tumble_status_t tumble_inclined_uncertainty(const void *source, const tumble_judged_run_t *run,
                                            tumble_uncertainty_t *uncertainty)
{
    const tumble_inclined_source_t *from = source;
    if ((from == NULL) || (from->seen == NULL) || (run == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_judged_run_t judged = *run;
    judged.inclinations = from->seen;
    judged.weights = from->weights;
    return tumble_uncertainty_inclined(&judged, uncertainty, NULL);
}

/* ---- Of the inclinations themselves. ---- */

#define DEG_PER_RAD 57.295779513082320876798
#define TERMS 11 /* of the arc sine: of an angle of 0.3 rad they leave out less than 1e-15 rad */

/* Of an angle by its sine: x + 1/2 x^3/3 + 1/2 3/4 x^5/5 + ... */
static double arc_sine(double x)
{
    double power = x;
    double sum = x;
    for (int n = 1; n <= TERMS; n++) {
        power *= tumble_square(x) * (double)((2 * n) - 1) / (double)(2 * n);
        sum += power / (double)((2 * n) + 1);
    }
    return sum;
}

/* By how much an inclination differs from the schedule's: sin(beta - beta_0) is small, and has no other solution. */
static double beyond_rad(const inclined_t *inclined, uint8_t k, const tumble_angle_t *tilt)
{
    const tumble_inclinations_t *seen = &inclined->run.seen;
    return arc_sine((seen->sine[k] * tilt->cosine) - (seen->cosine[k] * tilt->sine));
}

tumble_status_t tumble_uncertainty_inclinations(const tumble_judged_run_t *run, tumble_shown_inclinations_t *shown,
                                                tumble_refusal_t *refusal)
{
    if ((run == NULL) || (run->stand == NULL) || (shown == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_stand_record_t stand;
    tumble_judged_run_t judged;
    tumble_uncertainty_t u = {0};
    inclined_t inclined;
    judged = *run;
    judged.only = 1U; /* in the place of K_xx each is judged */
    judged.attitude = NULL;
    tumble_status_t status = prepare(&judged, &u, &inclined, refusal);
    *shown = (tumble_shown_inclinations_t){0};
    stand = *run->stand;
    stand.axis_tilt_rad = 0.0; /* the inclinations show it */
    judged.stand = &stand;
    tumble_gains_t gains = {.run = &judged, .kind = TUMBLE_GAINS_HOOKED, .hooks = &hooks, .hooked = &inclined};
    inclined.of_inclination = true;
    for (uint8_t k = 0; (status == TUMBLE_OK) && (k < inclined.map.count); k++) {
        const tumble_angle_t *tilt = &run->schedule->mountings[inclined.map.mounting[k]].tilt;
        inclined.sine_seed[k] = 1.0 / inclined.run.seen.cosine[k];
        status = tumble_uncertainty_judge(&gains, &u);
        inclined.sine_seed[k] = 0.0;
        const double beyond = beyond_rad(&inclined, k, tilt);
        shown->deg[k] = tilt->deg + (DEG_PER_RAD * beyond);
        shown->u_deg[k] = DEG_PER_RAD * u.k_v_per_g[0][0];
        shown->count++;
        if (!shown->has_level && tumble_within(tilt->deg, 0.0)) {
            shown->has_level = true;
            shown->level_rad = beyond;
            shown->u_level_rad = u.k_v_per_g[0][0];
        }
    }
    if (status != TUMBLE_OK) {
        *shown = (tumble_shown_inclinations_t){0};
    }
    return status;
}
