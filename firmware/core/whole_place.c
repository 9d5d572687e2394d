#include "core/whole_model.h"

#include "core/arith.h"
#include "core/course.h"
#include "core/stand_record.h"
#include "core/turn.h"
#include "core/vector.h"

enum { ALPHA1, ALPHA2, PLATFORM, COMMON_YAW };
enum { YAW, THETA_H, THETA_N }; /* of a mounting */
enum { TILT = YAW };            /* of an inclination, whose THETA_N is the zero of its table angles */

#define UNKNOWN_RAD 100.0 /* of an error that may have any size: what such a prior adds is below 1e-5 */

/* Yaw and seat of a block that is bolted on once turn it for the whole run, which the coefficients take up. In their place
 * each inclination has a tilt and a zero of its own, of which nothing is known; but the zero of the first is where the
 * others are counted from. */
void tumble_whole_sigmas(const tumble_whole_model_t *model, uint8_t mounting, tumble_whole_sigmas_t *sigmas)
{
    const tumble_stand_record_t *stand = model->stand;
    sigmas->shared_rad[ALPHA1] = stand->axis_tilt_rad;
    sigmas->shared_rad[ALPHA2] = stand->level_rad;
    sigmas->shared_rad[PLATFORM] = stand->platform_rad;
    sigmas->shared_rad[COMMON_YAW] = stand->common_yaw ? stand->remount_rad : 0.0;
    sigmas->local_rad[YAW] = stand->common_yaw ? 0.0 : stand->remount_rad;
    sigmas->local_rad[THETA_H] = stand->seat_rad;
    sigmas->local_rad[THETA_N] = stand->seat_rad;
    if (model->bolted > 0U) {
        sigmas->local_rad[TILT] = UNKNOWN_RAD;
        sigmas->local_rad[THETA_H] = 0.0;
        sigmas->local_rad[THETA_N] = (mounting > 0U) ? UNKNOWN_RAD : 0.0;
    }
    for (int e = 0; e < TUMBLE_WHOLE_COURSE; e++) {
        sigmas->course[e] = (e < TUMBLE_WAVES) ? stand->encoder_rad : tumble_stand_drift_v(stand, e - TUMBLE_WAVES);
    }
}

/* From (h, n, v) of the table to the block's axes. */
static void to_block(const tumble_mounting_t *mounting, const double f[3], double a[TUMBLE_CHANNELS])
{
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        a[i] = tumble_dot(mounting->matrix[i], f);
    }
}

/* What the outputs make of a change of the force, times `by`. */
static void respond(const tumble_whole_work_t *work, const tumble_mounting_t *mounting, const double f[3], double by,
                    double out_v[TUMBLE_CHANNELS])
{
    double a[TUMBLE_CHANNELS];
    to_block(mounting, f, a);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        out_v[i] = by * tumble_dot(work->coefficients.k_v_per_g[i], a);
    }
}

void tumble_whole_linearise(const tumble_whole_model_t *model, const tumble_whole_reading_t *reading,
                            tumble_whole_work_t *work)
{
    const uint8_t p = work->position;
    const tumble_mounting_t *mounting = &model->schedule->mountings[work->mounting];
    const float *own = work->local_rad[work->mounting];
    const double angle_rad = (double)work->angle_rad[p];
    tumble_whole_place_t *place = &work->place;
    tumble_whole_sigmas_t sigmas;
    tumble_whole_sigmas(model, work->mounting, &sigmas);
    double sine = model->schedule->positions[p].angle.sine;
    double cosine = model->schedule->positions[p].angle.cosine;
    double tilt_sine = mounting->tilt.sine;
    double tilt_cosine = mounting->tilt.cosine;
    const double encoder_rad = tumble_course_angle_error(&model->schedule->positions[p].angle, work->course);
    tumble_turn(work->shared_rad[ALPHA2] + (double)own[THETA_N] + angle_rad + encoder_rad, &sine, &cosine);
    const bool inclines = model->bolted > 0U;
    const double own_tilt = inclines ? (double)own[TILT] : 0.0;
    const double own_yaw = inclines ? 0.0 : (double)own[YAW];
    tumble_turn(work->shared_rad[ALPHA1] + own_tilt, &tilt_sine, &tilt_cosine);
    double force[3] = {tilt_cosine * sine, tilt_sine, tilt_cosine * cosine};
    double by_alpha1[3] = {-tilt_sine * sine, tilt_cosine, -tilt_sine * cosine};
    double by_turn[3] = {tilt_cosine * cosine, 0.0, -tilt_cosine * sine};
    const double lean = (double)own[THETA_H] + work->shared_rad[PLATFORM];
    tumble_turn(lean, &force[1], &force[2]);
    tumble_turn(lean, &by_alpha1[1], &by_alpha1[2]);
    tumble_turn(lean, &by_turn[1], &by_turn[2]);
    double by_lean[3] = {0.0, force[2], -force[1]};
    const double yaw = own_yaw + work->shared_rad[COMMON_YAW];
    tumble_turn(yaw, &by_lean[0], &by_lean[1]);
    tumble_turn(yaw, &force[0], &force[1]);
    tumble_turn(yaw, &by_alpha1[0], &by_alpha1[1]);
    tumble_turn(yaw, &by_turn[0], &by_turn[1]);
    const double by_yaw[3] = {force[1], -force[0], 0.0};
    to_block(mounting, force, place->attitude_g);
    respond(work, mounting, inclines ? by_alpha1 : by_yaw, sigmas.local_rad[YAW], place->by_local[YAW]);
    respond(work, mounting, by_lean, sigmas.local_rad[THETA_H], place->by_local[THETA_H]);
    respond(work, mounting, by_turn, sigmas.local_rad[THETA_N], place->by_local[THETA_N]);
    respond(work, mounting, by_alpha1, sigmas.shared_rad[ALPHA1], place->by_shared[ALPHA1]);
    respond(work, mounting, by_turn, sigmas.shared_rad[ALPHA2], place->by_shared[ALPHA2]);
    respond(work, mounting, by_lean, sigmas.shared_rad[PLATFORM], place->by_shared[PLATFORM]);
    respond(work, mounting, by_yaw, sigmas.shared_rad[COMMON_YAW], place->by_shared[COMMON_YAW]);
    respond(work, mounting, by_turn, 1.0, place->by_angle);
    tumble_course_waves(&model->schedule->positions[p].angle, place->wave_rad);
    for (int n = 0; n < TUMBLE_WAVES; n++) {
        place->wave_rad[n] *= model->stand->encoder_rad;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double felt_v = tumble_dot(work->coefficients.k_v_per_g[i], place->attitude_g);
        const double linear_v = work->coefficients.u0_v[i] + (reading->course * work->course[TUMBLE_WAVES + i]);
        place->residual_v[i] = reading->u_v[i] - linear_v - felt_v + (place->by_angle[i] * angle_rad);
        place->drift_v[i] = reading->course * sigmas.course[TUMBLE_WAVES + i];
        place->variance_v2[i] = tumble_larger(reading->variance_v2[i], work->least_v2[i]);
    }
}
