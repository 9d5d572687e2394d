#include "navcomp/views.h"

#include "core/stand_record.h"
#include "navcomp/uncertainty.h"

#include <stddef.h>

/* Is the view that of the present result? From now on it is. */
static bool is_present(const tumble_navcomp_t *navcomp, tumble_view_mark_t *mark)
{
    const uint32_t at_hand = tumble_procedure_counters(&navcomp->procedure)->positions + 1U;
    const bool present = (mark->looked_at == at_hand) && (mark->run_number == navcomp->run_number);
    *mark = (tumble_view_mark_t){.run_number = navcomp->run_number, .looked_at = at_hand};
    return present;
}

/* The errors of the stand. */

enum { ALPHA1 = 0, ALPHA2_PLUS_ALPHA3, ALPHA3_DIFFERENCE, ALPHA4, NOISE };

static void show_seen(tumble_stand_view_t *view, unsigned quantity, const tumble_seen_t *seen)
{
    double *const number = &view->number[(size_t)quantity * 2U];
    view->known[quantity] = seen->known;
    number[0] = seen->known ? seen->value : 0.0;
    number[1] = seen->known ? seen->u : 0.0;
}

#define LEAST_NOISE 1e-4 /* of the largest: a channel without noise must not hide the others */

/* What makes each channel as noisy as the noisiest, as the stand declares them: 1 where they are alike. */
static void find_weights(const tumble_declared_t *declared, double weight[TUMBLE_CHANNELS])
{
    double largest_v = 0.0;
    for (int c = 0; c < TUMBLE_CHANNELS; c++) {
        weight[c] = (declared != NULL) ? tumble_stand_noise_v(declared->stand, c) : 0.0;
        largest_v = tumble_larger(largest_v, weight[c]);
    }
    for (int c = 0; c < TUMBLE_CHANNELS; c++) {
        weight[c] =
            tumble_is_positive(largest_v) ? (largest_v / tumble_larger(weight[c], LEAST_NOISE * largest_v)) : 1.0;
    }
}

/* The run and its result as they are with channels that are alike: no angle changes. */
static void make_alike(const double weight[TUMBLE_CHANNELS], tumble_means_t *means, tumble_coefficients_t *coefficients)
{
    for (int c = 0; c < TUMBLE_CHANNELS; c++) {
        for (int p = 0; p < TUMBLE_MAX_POSITIONS; p++) {
            means->u_v[p][c] *= weight[c];
        }
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            coefficients->k_v_per_g[c][j] *= weight[c];
        }
        coefficients->u0_v[c] *= weight[c];
    }
}

/* Noise of a sample of the noisiest channel, from the scatter within positions; and what it makes of the means. */
static tumble_seen_t estimate_noise(const tumble_navcomp_t *navcomp, const double weight[TUMBLE_CHANNELS],
                                    tumble_stand_memory_t *memory)
{
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    const tumble_average_t *averages = tumble_procedure_averages(&navcomp->procedure)->averages;
    uint32_t samples[TUMBLE_MAX_POSITIONS] = {0};
    double scatter_v[TUMBLE_MAX_POSITIONS][TUMBLE_CHANNELS];
    const uint8_t count = config->schedule->position_count;
    for (uint8_t p = 0; p < count; p++) {
        samples[p] = averages[p].samples;
        for (int c = 0; c < TUMBLE_CHANNELS; c++) {
            const double volts = weight[c] * config->v_per_count * (double)averages[p].scatter_counts[c];
            scatter_v[p][c] = (volts < 0.0) ? -volts : volts;
        }
    }
    const tumble_seen_t noise = tumble_seen_noise(samples, (const double (*)[TUMBLE_CHANNELS])scatter_v, count);
    for (uint8_t p = 0; p < count; p++) {
        memory->errors.mean_variance_v2[p] =
            (noise.known && (samples[p] != 0U)) ? ((noise.value * noise.value) / (double)samples[p]) : 0.0;
    }
    return noise;
}

static void estimate_stand_errors(const tumble_navcomp_t *navcomp, tumble_stand_memory_t *memory,
                                  const tumble_coefficients_t *coefficients)
{
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    const tumble_declared_t *declared = navcomp->config->declared;
    tumble_seen_angles_t angles = {.alpha1 = {.known = false}};
    tumble_seen_t alpha4 = {.known = false};
    double freedom;
    (void)tumble_averaging_means(tumble_procedure_averages(&navcomp->procedure), config->v_per_count, &memory->means);
    double weight[TUMBLE_CHANNELS];
    tumble_coefficients_t alike;
    alike = *coefficients;
    find_weights(declared, weight);
    make_alike(weight, &memory->means, &alike);
    const tumble_seen_t noise = estimate_noise(navcomp, weight, memory);
    if (config->estimate != TUMBLE_ESTIMATE_INCLINED) {
        (void)tumble_seen_angle_error(config->schedule, &memory->means, &alike, &memory->errors, &memory->work, &alpha4,
                                      &freedom);
        memory->errors.angle_rad = (declared != NULL) ? declared->stand->angle_rad : alpha4.value;
        (void)tumble_seen_fit(config->schedule, &memory->means, &alike, &memory->errors, &memory->work, &angles);
    }
    show_seen(&memory->view, ALPHA1, &angles.alpha1);
    show_seen(&memory->view, ALPHA2_PLUS_ALPHA3, &angles.alpha2_plus_alpha3);
    show_seen(&memory->view, ALPHA3_DIFFERENCE, &angles.alpha3_difference);
    show_seen(&memory->view, ALPHA4, &alpha4);
    show_seen(&memory->view, NOISE, &noise);
}

const tumble_stand_view_t *tumble_stand_view(const tumble_navcomp_t *navcomp, tumble_stand_memory_t *memory)
{
    tumble_result_t result;
    if (tumble_navcomp_result(navcomp, &result) != TUMBLE_OK) {
        return NULL;
    }
    if (!is_present(navcomp, &memory->mark)) {
        estimate_stand_errors(navcomp, memory, result.coefficients);
    }
    return &memory->view;
}

/* Its inclinations. */

static void show_inclinations(const tumble_shown_inclinations_t *shown, tumble_inclinations_view_t *view)
{
    *view = (tumble_inclinations_view_t){.known = {false}};
    for (size_t k = 0; k < shown->count; k++) {
        view->known[k] = true;
        view->number[2U * k] = shown->deg[k];
        view->number[(2U * k) + 1U] = shown->u_deg[k];
    }
    const size_t level = (size_t)2U * TUMBLE_MAX_YAWS; /* behind all inclinations */
    view->known[TUMBLE_MAX_YAWS] = shown->has_level;
    view->number[level] = shown->level_rad;
    view->number[level + 1U] = shown->u_level_rad;
}

/* Of a result; `source` keeps what its estimator saw. On a refusal nothing is shown. */
static void estimate_inclinations(const tumble_navcomp_t *navcomp, const tumble_coefficients_t *coefficients,
                                  const tumble_inclined_source_t *source, tumble_inclinations_view_t *view)
{
    tumble_shown_inclinations_t shown = {.count = 0};
    uint32_t samples[TUMBLE_MAX_POSITIONS];
    tumble_judged_run_t run = {.coefficients = coefficients, .inclinations = source->seen, .weights = source->weights};
    (void)tumble_navcomp_estimate_noise(navcomp);
    if (tumble_navcomp_judged_run(navcomp, samples, &run) == TUMBLE_OK) {
        (void)tumble_uncertainty_inclinations(&run, &shown, NULL);
    }
    show_inclinations(&shown, view);
}

const tumble_inclinations_view_t *tumble_inclinations_view(const tumble_navcomp_t *navcomp,
                                                           tumble_inclinations_memory_t *memory)
{
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    const tumble_lent_t *lent = tumble_procedure_lent(config);
    tumble_result_t result;
    if ((tumble_navcomp_result(navcomp, &result) != TUMBLE_OK) || (config->estimate != TUMBLE_ESTIMATE_INCLINED) ||
        (lent == NULL) || (navcomp->config->declared == NULL)) {
        return NULL;
    }
    if (!is_present(navcomp, &memory->mark)) {
        estimate_inclinations(navcomp, result.coefficients, lent->source, &memory->view);
    }
    return &memory->view;
}
