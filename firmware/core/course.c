#include "core/course.h"

#include "core/arith.h"
#include "core/normal.h"
#include "core/stand_record.h"

void tumble_course_waves(const tumble_angle_t *angle, double wave[TUMBLE_WAVES])
{
    wave[0] = angle->sine;
    wave[1] = angle->cosine;
    wave[2] = 2.0 * angle->sine * angle->cosine;
    wave[3] = (angle->cosine * angle->cosine) - (angle->sine * angle->sine);
}

double tumble_course_angle_error(const tumble_angle_t *angle, const double numbers[TUMBLE_WAVES])
{
    double wave[TUMBLE_WAVES];
    double error_rad = 0.0;
    tumble_course_waves(angle, wave);
    for (int n = 0; n < TUMBLE_WAVES; n++) {
        error_rad += numbers[n] * wave[n];
    }
    return error_rad;
}

double tumble_course_of(uint8_t fit, uint8_t fit_positions)
{
    return (fit_positions > 1U) ? (((double)fit / (double)(fit_positions - 1U)) - 0.5) : -0.5;
}

double tumble_course_at(const tumble_schedule_t *schedule, const bool *measured, uint8_t p)
{
    uint8_t before = 0;
    uint8_t count = 0;
    for (uint8_t other = 0; other < schedule->position_count; other++) {
        const uint8_t used = tumble_normal_uses(schedule, measured, other) ? 1U : 0U;
        before = (uint8_t)(before + ((other < p) ? used : 0U));
        count = (uint8_t)(count + used);
    }
    return tumble_course_of(before, count);
}

void tumble_course_add(const tumble_judged_run_t *run, uint8_t p, double turning, const double g[TUMBLE_CHANNELS],
                       tumble_course_response_t *response)
{
    if (tumble_is_positive(run->stand->encoder_rad)) {
        double wave[TUMBLE_WAVES];
        tumble_course_waves(&run->schedule->positions[p].angle, wave);
        for (int n = 0; n < TUMBLE_WAVES; n++) {
            response->by_wave[n] += wave[n] * turning;
        }
    }
    if (tumble_stand_drifts(run->stand)) {
        const double x = tumble_course_at(run->schedule, run->measured, p);
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            response->by_drift[i] += x * g[i];
        }
    }
}

double tumble_course_variance(const tumble_stand_record_t *stand, const tumble_course_response_t *response)
{
    double variance = 0.0;
    for (int n = 0; n < TUMBLE_WAVES; n++) {
        variance += tumble_square(stand->encoder_rad * response->by_wave[n]);
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        variance += tumble_square(tumble_stand_drift_v(stand, i) * response->by_drift[i]);
    }
    return variance;
}
