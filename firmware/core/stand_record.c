#include "core/stand_record.h"

#include "core/arith.h"

static bool is_sigma(double sigma, double largest)
{
    return tumble_within(sigma, largest) && !tumble_is_positive(-sigma);
}

double tumble_stand_noise_v(const tumble_stand_record_t *stand, int channel)
{
    const double own_v = stand->channel_noise_v[channel];
    return tumble_is_positive(own_v) ? own_v : stand->noise_v;
}

double tumble_stand_drift_v(const tumble_stand_record_t *stand, int channel)
{
    const double own_v = stand->channel_drift_v[channel];
    return tumble_is_positive(own_v) ? own_v : stand->drift_v;
}

bool tumble_stand_drifts(const tumble_stand_record_t *stand)
{
    bool drifts = tumble_is_positive(stand->drift_v);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        drifts = drifts || tumble_is_positive(stand->channel_drift_v[i]);
    }
    return drifts;
}

bool tumble_stand_record_is_valid(const tumble_stand_record_t *stand)
{
    bool valid = true;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        valid = valid && is_sigma(stand->channel_noise_v[i], TUMBLE_MAX_MEAN_V) &&
                is_sigma(stand->channel_drift_v[i], TUMBLE_MAX_MEAN_V);
    }
    return valid && is_sigma(stand->axis_tilt_rad, TUMBLE_MAX_STAND_SIGMA_RAD) &&
           is_sigma(stand->level_rad, TUMBLE_MAX_STAND_SIGMA_RAD) &&
           is_sigma(stand->remount_rad, TUMBLE_MAX_STAND_SIGMA_RAD) &&
           is_sigma(stand->angle_rad, TUMBLE_MAX_STAND_SIGMA_RAD) &&
           is_sigma(stand->seat_rad, TUMBLE_MAX_STAND_SIGMA_RAD) &&
           is_sigma(stand->platform_rad, TUMBLE_MAX_STAND_SIGMA_RAD) &&
           is_sigma(stand->encoder_rad, TUMBLE_MAX_STAND_SIGMA_RAD) && is_sigma(stand->drift_v, TUMBLE_MAX_MEAN_V) &&
           is_sigma(stand->noise_v, TUMBLE_MAX_MEAN_V) && is_sigma(stand->least_noise_v, TUMBLE_MAX_MEAN_V) &&
           (stand->samples >= 1U);
}
