/* embed.c - average, solve, verify, keep and apply, in a program of your own. */
#include "embed_board.h"
#include "tumble/sets.h"
#include <stdio.h>
#include <stdlib.h>

static void must(tumble_status_t status)
{
    if (status != TUMBLE_OK) {
        puts(tumble_status_sentence(status));
        exit(1);
    }
}

static void settle(tumble_store_t *store, tumble_status_t status) /* a control loop makes one step in each cycle */
{
    while ((status == TUMBLE_OK) && tumble_store_busy(store))
        (void)tumble_store_step(store);
    must((status == TUMBLE_OK) ? tumble_store_outcome(store) : status);
}

int main(void)
{
    const tumble_averaging_config_t gates = {5000000, .min_samples = 64, .noise_counts = 148, .stillness_ratio = 1.5F};
    const tumble_stand_record_t stand = {.noise_v = 1.5e-4, .samples = 64}; /* played: without errors of its angles */
    static tumble_averaging_t averaging;
    static tumble_means_t means;
    static tumble_store_t store;
    tumble_set_t set = {.estimator = TUMBLE_ESTIMATE_REFINED, .flags = TUMBLE_SET_HAS_UNCERTAINTY}, kept;
    const tumble_judged_run_t run = {&tumble_schedule_paper, &stand, .coefficients = &set.coefficients};
    tumble_calibration_t calibration;
    tumble_gravity_check_t check;
    double a_g[TUMBLE_CHANNELS];
    must(tumble_averaging_init(&averaging, &gates));
    for (uint8_t position = 0; position < run.schedule->position_count; position++) { /* turn the table, let it rest */
        must(tumble_averaging_begin(&averaging, position));
        while (tumble_averaging_samples(&averaging) < gates.min_samples)
            must(tumble_averaging_add(&averaging, &gates, board_sample(position)));
        must(tumble_averaging_finish(&averaging, &gates));
    }
    must(tumble_averaging_means(&averaging, 1e-6, &means)); /* 1e-6 V per count */
    must(tumble_estimate_refined(run.schedule, &means, &set.coefficients, NULL));
    must(tumble_uncertainty_refined(&run, &set.uncertainty, NULL));
    must(tumble_calibration_invert(&set.coefficients, &calibration));
    must(tumble_gravity_check(run.schedule, &means, &calibration, 3e-4, &check));
    if (!check.pass) {
        puts("the gravity check failed: nothing is kept");
        return 1;
    }
    settle(&store, tumble_store_init(&store, &board_memory));
    settle(&store, tumble_store_commit(&store, &set));
    must(tumble_store_read(&store, TUMBLE_SET_ACTIVE, &kept));
    must(tumble_calibration_invert(&kept.coefficients, &calibration));
    tumble_calibration_apply_counts(&calibration, 1e-6, board_sample(17)->counts, a_g);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double *k = kept.coefficients.k_v_per_g[i], *u = kept.uncertainty.k_v_per_g[i];
        printf("K  %+.6f %+.6f %+.6f V/g  +- %.6f %.6f %.6f\n", k[0], k[1], k[2], u[0], u[1], u[2]);
        printf("U0 %+.6f V  +- %.6f;  a %+.4f g\n", kept.coefficients.u0_v[i], kept.uncertainty.u0_v[i], a_g[i]);
    }
}
