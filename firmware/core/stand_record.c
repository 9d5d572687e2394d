#include "core/stand_record.h"

#include "core/arith.h"

static bool is_sigma(double sigma, double largest)
{
    return tumble_within(sigma, largest) && !tumble_is_positive(-sigma);
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
