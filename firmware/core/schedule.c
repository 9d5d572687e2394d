#include "tumble/core.h"

#include "core/arith.h"
#include "core/normal.h"
#include "core/one_copy.h"
#include "core/vector.h"

#include <stddef.h>

#define MAX_ANGLE_DEG 3600.0
#define ANGLE_TOLERANCE 1e-12
#define ROTATION_TOLERANCE 1e-9

/* Taylor's series to x^17 for the sine and x^18 for the cosine: below 1e-16 of error up to 45 degrees. */
static void sine_cosine_of_small(double x, double *sine, double *cosine)
{
    double term = 1.0;
    double sums[2] = {1.0, 0.0}; /* of even and of odd powers */
    for (unsigned k = 1; k <= 18U; k++) {
        term *= x / (double)k;
        sums[k % 2U] += term;
        x = -x;
    }
    *sine = sums[1];
    *cosine = sums[0];
}

static bool angle_is_consistent(const tumble_angle_t *angle)
{
    if (!tumble_within(angle->deg, MAX_ANGLE_DEG)) {
        return false;
    }
    const double quarters = (angle->deg / 90.0) + 40.5; /* 40 turns of a quarter make it positive, 0.5 rounds it */
    const uint32_t quarter = (uint32_t)tumble_whole(quarters);
    const double rest_deg = angle->deg - (90.0 * ((double)quarter - 40.0));
    double sine;
    double cosine;
    sine_cosine_of_small(rest_deg * (3.14159265358979323846 / 180.0), &sine, &cosine);
    for (uint32_t turn = quarter % 4U; turn > 0U; turn--) {
        const double before = sine;
        sine = cosine;
        cosine = -before;
    }
    return tumble_within(angle->sine - sine, ANGLE_TOLERANCE) && tumble_within(angle->cosine - cosine, ANGLE_TOLERANCE);
}

static bool is_proper_rotation(const double m[3][3])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j <= i; j++) {
            if (!tumble_within(tumble_dot(m[i], m[j]) - ((i == j) ? 1.0 : 0.0), ROTATION_TOLERANCE)) {
                return false;
            }
        }
    }
    double cross[3];
    tumble_cross(m[0], m[1], cross);
    return tumble_is_positive(tumble_dot(cross, m[2]));
}

TUMBLE_ONE_COPY uint8_t tumble_schedule_find_mounting(const tumble_schedule_t *schedule, uint8_t number)
{
    uint8_t m = 0;
    while ((m < schedule->mounting_count) && (schedule->mountings[m].number != number)) {
        m++;
    }
    return m;
}

static tumble_status_t validate_mounting(const tumble_schedule_t *schedule, uint8_t m)
{
    const tumble_mounting_t *mounting = &schedule->mountings[m];
    if (tumble_schedule_find_mounting(schedule, mounting->number) != m) {
        return TUMBLE_E_SCHEDULE_DUPLICATE;
    }
    if (!is_proper_rotation(mounting->matrix)) {
        return TUMBLE_E_SCHEDULE_ROTATION;
    }
    return angle_is_consistent(&mounting->tilt) ? TUMBLE_OK : TUMBLE_E_SCHEDULE_ANGLE;
}

static tumble_status_t validate_position(const tumble_schedule_t *schedule, uint8_t p)
{
    const tumble_position_t *position = &schedule->positions[p];
    if (tumble_schedule_find_mounting(schedule, position->mounting) == schedule->mounting_count) {
        return TUMBLE_E_SCHEDULE_MOUNTING;
    }
    if (tumble_schedule_find(schedule, position->mounting, position->number) != p) {
        return TUMBLE_E_SCHEDULE_DUPLICATE;
    }
    if ((position->use != TUMBLE_USE_FIT) && (position->use != TUMBLE_USE_CHECK)) {
        return TUMBLE_E_ARGUMENT;
    }
    return angle_is_consistent(&position->angle) ? TUMBLE_OK : TUMBLE_E_SCHEDULE_ANGLE;
}

static bool has_valid_size(const tumble_schedule_t *schedule)
{
    return (schedule->mounting_count >= 1U) && (schedule->mounting_count <= TUMBLE_MAX_MOUNTINGS) &&
           (schedule->position_count >= 1U) && (schedule->position_count <= TUMBLE_MAX_POSITIONS);
}

tumble_status_t tumble_schedule_validate(const tumble_schedule_t *schedule, uint8_t *where)
{
    if ((schedule == NULL) || (schedule->mountings == NULL) || (schedule->positions == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!has_valid_size(schedule)) {
        return TUMBLE_E_SCHEDULE_SIZE;
    }
    tumble_status_t status = TUMBLE_OK;
    uint8_t at = 0;
    for (uint8_t m = 0; (m < schedule->mounting_count) && (status == TUMBLE_OK); m++) {
        status = validate_mounting(schedule, m);
        at = m;
    }
    for (uint8_t p = 0; (p < schedule->position_count) && (status == TUMBLE_OK); p++) {
        status = validate_position(schedule, p);
        at = p;
    }
    if ((status != TUMBLE_OK) && (where != NULL)) {
        *where = at;
    }
    return status;
}

uint8_t tumble_schedule_find(const tumble_schedule_t *schedule, uint8_t mounting, uint8_t position)
{
    uint8_t p = 0;
    while ((p < schedule->position_count) &&
           ((schedule->positions[p].mounting != mounting) || (schedule->positions[p].number != position))) {
        p++;
    }
    return p;
}

const tumble_mounting_t *tumble_schedule_mounting_of(const tumble_schedule_t *schedule, uint8_t index)
{
    return &schedule->mountings[tumble_schedule_find_mounting(schedule, schedule->positions[index].mounting)];
}

bool tumble_schedule_stays_bolted(const tumble_schedule_t *schedule, uint8_t index)
{
    const tumble_mounting_t *mounting = &schedule->mountings[index];
    return (index > 0U) && (mounting->bolting > 0U) && (mounting->bolting == schedule->mountings[index - 1U].bolting);
}

uint8_t tumble_schedule_count_bolted(const tumble_schedule_t *schedule)
{
    uint8_t count = 0;
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        if (tumble_schedule_stays_bolted(schedule, m)) {
            count++;
        }
    }
    return count;
}

void tumble_schedule_attitude(const tumble_schedule_t *schedule, uint8_t index, double a_g[TUMBLE_CHANNELS])
{
    const tumble_mounting_t *mounting = tumble_schedule_mounting_of(schedule, index);
    const tumble_angle_t *angle = &schedule->positions[index].angle;
    const double f[3] = {mounting->tilt.cosine * angle->sine, mounting->tilt.sine,
                         mounting->tilt.cosine * angle->cosine};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        a_g[i] = tumble_dot(mounting->matrix[i], f);
    }
}
