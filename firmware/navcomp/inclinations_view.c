#include "navcomp/inclinations_view.h"

#include "navcomp/uncertainty.h"

#include <stddef.h>

static void show(const tumble_shown_inclinations_t *shown, tumble_inclinations_view_t *view)
{
    *view = (tumble_inclinations_view_t){.known = {false}};
    for (size_t k = 0; k < shown->count; k++) {
        view->known[k] = true;
        view->number[2U * k] = shown->deg[k];
        view->number[(2U * k) + 1U] = shown->u_deg[k];
    }
    view->known[TUMBLE_MAX_YAWS] = shown->has_level;
    view->number[2U * TUMBLE_MAX_YAWS] = shown->level_rad;
    view->number[(2U * TUMBLE_MAX_YAWS) + 1U] = shown->u_level_rad;
}

/* Of a result; `source` keeps what its estimator saw. On a refusal nothing is shown. */
static void look(const tumble_navcomp_t *navcomp, const tumble_coefficients_t *coefficients,
                 const tumble_inclined_source_t *source, tumble_inclinations_view_t *view)
{
    tumble_shown_inclinations_t shown = {.count = 0};
    uint32_t samples[TUMBLE_MAX_POSITIONS];
    tumble_judged_run_t run = {.coefficients = coefficients, .inclinations = source->seen, .weights = source->weights};
    (void)tumble_navcomp_look_at_noise(navcomp);
    if (tumble_navcomp_judged_run(navcomp, samples, &run) == TUMBLE_OK) {
        (void)tumble_uncertainty_inclinations(&run, &shown, NULL);
    }
    show(&shown, view);
}

const tumble_inclinations_view_t *tumble_inclinations_view(const tumble_navcomp_t *navcomp,
                                                           tumble_inclinations_memory_t *memory)
{
    const uint32_t at_hand = tumble_procedure_counters(&navcomp->procedure)->positions + 1U;
    const tumble_procedure_config_t *config = &navcomp->procedure_config;
    const tumble_lent_t *lent = tumble_procedure_lent(config);
    tumble_result_t result;
    if ((tumble_navcomp_result(navcomp, &result) != TUMBLE_OK) || (config->estimate != TUMBLE_ESTIMATE_INCLINED) ||
        (lent == NULL) || (navcomp->config->declared == NULL)) {
        return NULL;
    }
    if ((memory->looked_at != at_hand) || (memory->run_number != navcomp->run_number)) {
        look(navcomp, result.coefficients, lent->source, &memory->view);
        memory->looked_at = at_hand;
        memory->run_number = navcomp->run_number;
    }
    return &memory->view;
}
