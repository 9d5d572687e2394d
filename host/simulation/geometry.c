#include "simulation/geometry.h"

#include "simulation/maths.h"

void sim_geometry_init(sim_geometry_t *geometry, const tumble_mounting_t *mounting, const sim_seat_t *seat)
{
    double sin_t;
    double cos_t;
    double sin_3;
    double cos_3;
    double sin_h;
    double cos_h;
    sim_sincos_deg(mounting->tilt.deg + seat->alpha1_rad * SIM_DEG_PER_RAD, &sin_t, &cos_t);
    sim_sincos_deg(seat->alpha3_rad * SIM_DEG_PER_RAD, &sin_3, &cos_3);
    sim_sincos_deg(seat->theta_h_rad * SIM_DEG_PER_RAD, &sin_h, &cos_h);
    const double turned[3][3] = {
        /* of sin p, of cos p, of 1 */
        {cos_t * cos_3, cos_t * sin_h * sin_3, sin_t * cos_h * sin_3},  /* h' */
        {-cos_t * sin_3, cos_t * sin_h * cos_3, sin_t * cos_h * cos_3}, /* n' */
        {0.0, cos_t * cos_h, -sin_t * sin_h},                           /* v' */
    };
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const double (*const m)[3] = mounting->matrix;
            geometry->a[i][j] = m[i][0] * turned[0][j] + m[i][1] * turned[1][j] + m[i][2] * turned[2][j];
        }
    }
    geometry->level_deg = (seat->alpha2_rad + seat->theta_n_rad) * SIM_DEG_PER_RAD;
    geometry->turns_true = true;
    for (int n = 0; n < TUMBLE_WAVES; n++) {
        geometry->encoder_deg[n] = seat->encoder_rad[n] * SIM_DEG_PER_RAD;
        geometry->turns_true = geometry->turns_true && geometry->encoder_deg[n] == 0.0;
    }
}

static double encoder_error_deg(const sim_geometry_t *geometry, double actual_deg)
{
    double sine;
    double cosine;
    if (geometry->turns_true) {
        return 0.0;
    }
    sim_sincos_deg(actual_deg, &sine, &cosine);
    const double *const number = geometry->encoder_deg;
    return number[0] * sine + number[1] * cosine + number[2] * (2.0 * sine * cosine) +
           number[3] * (cosine * cosine - sine * sine);
}

void sim_geometry_force(const sim_geometry_t *geometry, double actual_deg, double a_g[3])
{
    double sine;
    double cosine;
    sim_sincos_deg(actual_deg + geometry->level_deg + encoder_error_deg(geometry, actual_deg), &sine, &cosine);
    for (int i = 0; i < 3; i++) {
        const double *const a = geometry->a[i];
        a_g[i] = a[0] * sine + a[1] * cosine + a[2];
    }
}
