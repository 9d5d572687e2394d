#include "tumble/core.h"

#include "core/arith.h"
#include "core/harmonic.h"

#include <stddef.h>

#define MOUNTINGS 2
#define POSITIONS 9
#define ROTATION_TOLERANCE 1e-9
#define ROOT_2 1.4142135623730951

/* A quantity of the closed form: the sum over the paper's positions of weight times (y component of the specific force
 * plus `z` times the z component), the second mounting's with the sign `second`. */
typedef struct {
    const double *weights;
    double z;
    double second;
    double factor;
} closed_form_t;

tumble_seen_t tumble_seen_noise(const uint32_t *samples, const double (*scatter)[TUMBLE_CHANNELS], uint8_t positions)
{
    double freedom = 0.0;
    double square_sum = 0.0;
    for (uint8_t p = 0; p < positions; p++) {
        for (int i = 0; (samples[p] > 1U) && (i < TUMBLE_CHANNELS); i++) {
            const double own = (double)samples[p] - 1.0;
            freedom += own;
            square_sum += own * scatter[p][i] * scatter[p][i];
        }
    }
    if (freedom == 0.0) {
        return (tumble_seen_t){0};
    }
    const double sigma = tumble_sqrt(square_sum / freedom);
    return (tumble_seen_t){sigma, sigma / tumble_sqrt(2.0 * freedom), true};
}

/* How y component plus `z` times z component change with the table angle: in the paper's mountings one of the two is
 * its cosine, the other does not change. */
static double slope_of(const closed_form_t *form, uint8_t paper)
{
    const double slope = -tumble_schedule_paper.positions[paper].angle.sine;
    return (paper < POSITIONS) ? (form->z * slope) : slope;
}

static tumble_seen_t closed_form(const closed_form_t *form, const uint8_t index[MOUNTINGS * POSITIONS],
                                 const tumble_means_t *means, const tumble_calibration_t *calibration,
                                 const tumble_random_errors_t *errors)
{
    double gain[TUMBLE_CHANNELS]; /* outputs to (y + z component) */
    double gain_square = 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        gain[i] = calibration->k_inverse_g_per_v[1][i] + (form->z * calibration->k_inverse_g_per_v[2][i]);
        gain_square += gain[i] * gain[i];
    }
    double sum = 0.0;
    double variance = 0.0;
    for (uint8_t paper = 0; paper < (MOUNTINGS * POSITIONS); paper++) {
        const uint8_t p = index[paper];
        const double *u = means->u_v[p];
        const double weight = form->factor * form->weights[paper % POSITIONS];
        const double signed_weight = (paper < POSITIONS) ? weight : (form->second * weight);
        sum += signed_weight * ((gain[0] * u[0]) + (gain[1] * u[1]) + (gain[2] * u[2]));
        if (errors != NULL) {
            const double tilt = slope_of(form, paper) * errors->angle_rad;
            variance += weight * weight * ((tilt * tilt) + (gain_square * errors->mean_variance_v2[p]));
        }
    }
    return (tumble_seen_t){sum, tumble_sqrt(variance), true};
}

static bool is_alike(const tumble_mounting_t *a, const tumble_mounting_t *b)
{
    bool alike = true;
    for (int i = 0; i < (TUMBLE_CHANNELS * TUMBLE_CHANNELS); i++) {
        alike = alike && tumble_within(a->matrix[i / 3][i % 3] - b->matrix[i / 3][i % 3], ROTATION_TOLERANCE);
    }
    return alike;
}

/* Where the paper's positions are. False when one is not there, or when there are other circles. */
static bool find_paper(const tumble_harmonic_map_t *map, uint8_t index[MOUNTINGS * POSITIONS])
{
    uint8_t found = 0;
    for (uint8_t c = 0; c < map->count; c++) {
        const tumble_circle_t *circle = &map->circle[c];
        const tumble_mounting_t *mounting = &map->schedule->mountings[circle->mounting];
        for (uint8_t paper = 0; (paper < MOUNTINGS) && (circle->stride == 1U); paper++) {
            if (is_alike(mounting, &tumble_schedule_paper.mountings[paper])) {
                (void)memcpy(&index[(size_t)POSITIONS * paper], circle->index, POSITIONS);
                found++;
            }
        }
    }
    return (found == MOUNTINGS) && (map->count == MOUNTINGS);
}

tumble_status_t tumble_seen_angles(const tumble_schedule_t *schedule, const tumble_means_t *means,
                                   const tumble_calibration_t *calibration, const tumble_random_errors_t *errors,
                                   tumble_seen_angles_t *angles)
{
    /* Weights of the mean of a circle and of its sine, times 8. */
    static const double mean_weights[POSITIONS] = {0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.5};
    static const double sine_weights[POSITIONS] = {0.0, ROOT_2, 2.0, ROOT_2, 0.0, -ROOT_2, -2.0, -ROOT_2, 0.0};
    static const closed_form_t closed_forms[] = {
        {mean_weights, -1.0, -1.0, 0.5 / 8.0}, /* alpha1: (v_y - v_z) / 2 */
        {sine_weights, 1.0, 1.0, -0.5 / 8.0},  /* alpha2 + alpha3: (w_y + w_z) / 2 */
        {sine_weights, -1.0, 1.0, -1.0 / 8.0}, /* yaw 1 - yaw 2: w_y - w_z */
    };
    if ((schedule == NULL) || (means == NULL) || (calibration == NULL) || (angles == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    tumble_harmonic_map_t map;
    uint8_t index[MOUNTINGS * POSITIONS];
    tumble_status_t status = tumble_schedule_harmonic(schedule, means->measured, &map, NULL);
    if ((status == TUMBLE_OK) && !find_paper(&map, index)) {
        status = TUMBLE_E_NOT_HARMONIC;
    }
    if (status == TUMBLE_OK) {
        angles->alpha1 = closed_form(&closed_forms[0], index, means, calibration, errors);
        angles->alpha2_plus_alpha3 = closed_form(&closed_forms[1], index, means, calibration, errors);
        angles->alpha3_difference = closed_form(&closed_forms[2], index, means, calibration, errors);
    }
    return status;
}
