#include "core/whole_model.h"

#include "core/accumulator.h"
#include "core/arith.h"
#include "core/course.h"
#include "core/stand_record.h"

#include <stddef.h>

#define ROUNDING_V2 12.0 /* a step of the converter, squared, over the variance of its rounding */

/* From means. */

static void read_mean(const tumble_whole_run_t *run, uint8_t p, tumble_whole_reading_t *reading)
{
    reading->measured = run->means->measured[p];
    reading->course = tumble_stand_drifts(run->stand) ? tumble_course_at(run->schedule, run->means->measured, p) : 0.0;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        reading->u_v[i] = run->means->u_v[p][i];
        reading->variance_v2[i] =
            (run->channel_variance_v2 != NULL) ? run->channel_variance_v2[p][i] : run->mean_variance_v2[p];
    }
}

tumble_status_t tumble_whole_chi_squared(const tumble_whole_run_t *run, tumble_whole_work_t *work, double *chi_squared,
                                         uint8_t *freedom)
{
    if ((run == NULL) || (run->schedule == NULL) || (run->means == NULL) || (run->stand == NULL) ||
        ((run->mean_variance_v2 == NULL) && (run->channel_variance_v2 == NULL)) || (work == NULL) ||
        (chi_squared == NULL) || (freedom == NULL)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_whole_model_t model = {run->schedule, run->stand, tumble_schedule_count_bolted(run->schedule)};
    tumble_coefficients_t start;
    const tumble_status_t status = tumble_estimate_least_squares(run->schedule, run->means, &start, NULL);
    if (status != TUMBLE_OK) {
        return status;
    }
    tumble_whole_start(work, &start);
    tumble_whole_reading_t reading = {.measured = false};
    do {
        if (work->position < run->schedule->position_count) {
            read_mean(run, work->position, &reading);
        }
    } while (tumble_whole_go_on(&model, &reading, work));
    *chi_squared = work->chi_squared;
    *freedom = work->freedom;
    return TUMBLE_OK;
}

/* From averages. */

/* Declared noise and rounding of a mean. Samples with less noise than half a step of the converter round alike, and
 * averaging does not help. */
static double declared_variance(const tumble_misfit_run_t *run, int i, uint32_t samples)
{
    const double step_v2 = run->v_per_count * run->v_per_count;
    const double noise_v2 = tumble_square(tumble_stand_noise_v(run->stand, i));
    const double least_v2 = run->stand->least_noise_v * run->stand->least_noise_v;
    const bool alike = tumble_exceeds(step_v2, 4.0 * noise_v2);
    return tumble_larger((noise_v2 / (double)samples) + (alike ? (step_v2 / ROUNDING_V2) : 0.0), least_v2);
}

static double course_of_average(const tumble_misfit_run_t *run, uint8_t p)
{
    bool measured[TUMBLE_MAX_POSITIONS];
    for (uint8_t other = 0; other < (uint8_t)TUMBLE_MAX_POSITIONS; other++) {
        measured[other] = run->averaging->averages[other].samples != 0U;
    }
    return tumble_course_at(run->schedule, measured, p);
}

static void read_average(const tumble_misfit_run_t *run, uint8_t p, tumble_whole_reading_t *reading)
{
    const tumble_average_t *average = &run->averaging->averages[p];
    reading->measured = tumble_averaging_has_mean(run->averaging, p);
    if (reading->measured) {
        reading->course = tumble_stand_drifts(run->stand) ? course_of_average(run, p) : 0.0;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) { /* three divisions a step: not worth tumble_divide's code */
            reading->u_v[i] = ((double)average->sum_counts[i] / (double)average->samples) * run->v_per_count;
            reading->variance_v2[i] = declared_variance(run, i, average->samples);
        }
    }
}

/* A sum that is no number does not fit either. */
static void find_verdict(tumble_whole_work_t *work)
{
    const int freedom = (int)work->freedom;
    work->under_way = false;
    if (freedom > 0) {
        work->limit = tumble_chi_squared_limit((double)freedom, TUMBLE_WHOLE_SIGMAS);
        work->misfit = tumble_sqrt(work->chi_squared / (double)freedom);
        work->misfits = !tumble_within(work->chi_squared, work->limit);
        work->known = tumble_is_finite(work->chi_squared);
    }
}

bool tumble_whole_step(tumble_whole_work_t *work, const tumble_misfit_run_t *run)
{
    const tumble_whole_model_t model = {run->schedule, run->stand, tumble_schedule_count_bolted(run->schedule)};
    tumble_whole_reading_t reading = {.measured = false};
    if (!work->under_way) {
        tumble_whole_start(work, run->coefficients);
        if ((model.bolted > 0U) && ((model.bolted + 1U) < run->schedule->mounting_count)) {
            work->under_way = false;
            return false; /* several boltings: what they have in common is not among the unknowns */
        }
    }
    if (work->position < run->schedule->position_count) {
        read_average(run, work->position, &reading);
    }
    const bool more = tumble_whole_go_on(&model, &reading, work);
    if (!more) {
        find_verdict(work);
    }
    return more;
}
