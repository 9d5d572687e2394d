/* batch.c - many runs of one schedule in one call, all positions measured; part of the extension's source.
 *
 * means_v: runs x positions x 3. coefficients: runs x 12, K row by row, then U0. stand: runs x (2 + 3 TUMBLE_MAX_YAWS),
 * alpha1, alpha2, alpha3 by mounting, the seats. seen: runs x 4 x TUMBLE_MAX_YAWS, as tumble_inclinations_t has them. A
 * refusal stops at the run that `where` then names.
 */
#include <string.h>

typedef tumble_status_t batch_estimator_t(const tumble_schedule_t *, const tumble_means_t *, tumble_coefficients_t *,
                                          tumble_refusal_t *);

typedef struct {
    const char *name;
    batch_estimator_t *estimate;
    tumble_status_t (*uncertainty)(const tumble_judged_run_t *, tumble_uncertainty_t *, tumble_refusal_t *);
} estimator_row_t;

#define ROW(number, name, needs, estimate, uncertainty) {#name, estimate, uncertainty},
#define ROW_OF_GAINS NULL, NULL
#define ROW_OF_INCLINED tumble_estimate_inclined, tumble_uncertainty_inclined
#define LENT_ROW(number, name, needs) {#name, ROW_OF_##needs},
static const estimator_row_t estimator_rows[] = {TUMBLE_ESTIMATOR_LIST(ROW, LENT_ROW)};

static const double *batch_load(const tumble_schedule_t *schedule, const double *means_v, tumble_means_t *means)
{
    const size_t numbers = (size_t)schedule->position_count * TUMBLE_CHANNELS;
    memcpy(means->u_v, means_v, numbers * sizeof *means_v);
    memset(means->measured, true, schedule->position_count);
    return means_v + numbers;
}

static double *batch_store(const void *numbers, size_t size, double *to)
{
    memcpy(to, numbers, size);
    return to + (size / sizeof *to);
}

tumble_status_t batch_estimate(batch_estimator_t *estimator, const tumble_schedule_t *schedule, size_t runs,
                               const double *means_v, double *coefficients, size_t *where)
{
    tumble_means_t means;
    tumble_status_t status = TUMBLE_OK;
    for (*where = 0; *where < runs; (*where)++) {
        tumble_coefficients_t found;
        means_v = batch_load(schedule, means_v, &means);
        status = estimator(schedule, &means, &found, NULL);
        if (status != TUMBLE_OK) {
            break;
        }
        coefficients = batch_store(&found, sizeof found, coefficients);
    }
    return status;
}

tumble_status_t batch_inclined(const tumble_schedule_t *schedule, size_t runs, const double *means_v,
                               const double *weights, double *coefficients, double *seen, size_t *where)
{
    tumble_means_t means;
    tumble_status_t status = TUMBLE_OK;
    for (*where = 0; *where < runs; (*where)++) {
        tumble_coefficients_t found;
        tumble_inclinations_t inclinations = {{0.0}, {0.0}, {0.0}, {0.0}};
        means_v = batch_load(schedule, means_v, &means);
        status = tumble_inclined_weighted(schedule, &means, weights, &found, &inclinations, NULL);
        if (status != TUMBLE_OK) {
            break;
        }
        coefficients = batch_store(&found, sizeof found, coefficients);
        seen = batch_store(&inclinations, sizeof inclinations, seen);
    }
    return status;
}

tumble_status_t batch_optimal(const tumble_gain_record_t *record, const tumble_schedule_t *schedule, size_t runs,
                              const double *means_v, double *coefficients, double *stand, size_t *where)
{
    tumble_means_t means;
    tumble_status_t status = TUMBLE_OK;
    for (*where = 0; *where < runs; (*where)++) {
        tumble_coefficients_t found;
        tumble_optimal_t optimal;
        means_v = batch_load(schedule, means_v, &means);
        status = tumble_estimate_optimal(record, schedule, &means, &found, &optimal);
        if (status != TUMBLE_OK) {
            break;
        }
        coefficients = batch_store(&found, sizeof found, coefficients);
        stand = batch_store(&optimal.stand, sizeof optimal.stand, stand);
    }
    return status;
}
