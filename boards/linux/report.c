#include "report.h"

#include "arguments.h"

int bench_exit_code(const bench_world_t *world)
{
    tumble_result_t result;
    if (world->end == WORLD_INTERRUPTED) {
        return BENCH_EXIT_INTERRUPTED;
    }
    if (world->end == WORLD_LEFT) {
        return BENCH_EXIT_PASS;
    }
    if (world->end != WORLD_DONE || tumble_navcomp_result(&world->navcomp, &result) != TUMBLE_OK) {
        return BENCH_EXIT_FAULT;
    }
    return result.pass ? BENCH_EXIT_PASS : BENCH_EXIT_LIMITS;
}

static void put_outcome(const bench_world_t *world, bench_json_t *json)
{
    const tumble_progress_t *const progress = &world->progress;
    const tumble_stand_refusal_t refusal = tumble_navcomp_drive_refusal(&world->navcomp);
    bench_json_whole(json, "seed", world->seed);
    bench_json_text(json, "end", bench_end_name(world->end));
    bench_json_whole(json, "exit", (uint64_t)bench_exit_code(world));
    bench_json_text(json, "state", tumble_state_name(progress->state));
    bench_json_text(json, "failed_in", tumble_state_name(progress->failed_in));
    bench_json_text(json, "reason", tumble_reason_name(progress->reason));
    bench_json_whole(json, "reason_number", (uint64_t)progress->reason);
    bench_json_text(json, "reason_sentence", tumble_reason_sentence(progress->reason));
    bench_json_text(json, "status", tumble_status_name(progress->status));
    bench_json_whole(json, "drive_code", progress->drive_code);
    if (refusal.index == 0U) {
        bench_json_null(json, "drive_refusal");
        return;
    }
    char sentence[BENCH_REFUSAL_BYTES];
    bench_refusal_sentence(&refusal, sentence, sizeof sentence);
    bench_json_open(json, "drive_refusal", '{');
    bench_json_whole(json, "index", refusal.index);
    bench_json_whole(json, "subindex", refusal.subindex);
    bench_json_whole(json, "abort", refusal.abort);
    bench_json_text(json, "step", bench_step_name(refusal.step));
    bench_json_text(json, "sentence", sentence);
    bench_json_close(json, '}');
}

/* Of fit and check positions. */
static double largest_delta_g(const tumble_gravity_check_t *check)
{
    return (check->max_abs_fit_g > check->max_abs_check_g) ? check->max_abs_fit_g : check->max_abs_check_g;
}

static void put_check(const bench_world_t *world, const tumble_gravity_check_t *check, bench_json_t *json)
{
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    bench_json_open(json, "verification", '{');
    bench_json_open(json, "delta_g_g", '[');
    for (uint32_t i = 0; i < schedule->position_count; i++) {
        const tumble_position_t *const position = &schedule->positions[i];
        bench_json_open(json, NULL, '{');
        bench_json_whole(json, "mounting", position->mounting);
        bench_json_whole(json, "position", position->number);
        bench_json_text(json, "use", (position->use == TUMBLE_USE_FIT) ? "fit" : "check");
        bench_json_number(json, "delta_g_g", check->delta_g_g[i]);
        bench_json_close(json, '}');
    }
    bench_json_close(json, ']');
    bench_json_number(json, "max_abs_delta_g_g", largest_delta_g(check));
    bench_json_number(json, "max_abs_fit_g", check->max_abs_fit_g);
    bench_json_number(json, "max_abs_check_g", check->max_abs_check_g);
    bench_json_number(json, "limit_g", world->config->procedure.gravity_limit_g);
    bench_json_flag(json, "pass", check->pass);
    bench_json_close(json, '}');
}

/* As the firmware states them; null where it does not. */
static void put_uncertainties(const bench_world_t *world, bench_json_t *json)
{
    tumble_uncertainty_t u;
    tumble_status_t status = tumble_navcomp_uncertainty(&world->navcomp, TUMBLE_ALL_COEFFICIENTS, &u);
    if (status == TUMBLE_E_PORT_BUSY) { /* the noise has been looked at */
        status = tumble_navcomp_uncertainty(&world->navcomp, TUMBLE_ALL_COEFFICIENTS, &u);
    }
    if (status != TUMBLE_OK) {
        bench_json_null(json, "u_K");
        bench_json_null(json, "u_U0");
        return;
    }
    bench_json_matrix(json, "u_K", u.k_v_per_g);
    bench_json_vector(json, "u_U0", u.u0_v, TUMBLE_CHANNELS);
}

/* What they count of the noise; null where nobody looks at it. Behind put_uncertainties. */
static void put_noise(const bench_world_t *world, bench_json_t *json)
{
    static const char *const CHANNELS[TUMBLE_CHANNELS] = {"x", "y", "z"};
    const tumble_noise_t *noise = NULL;
    if (tumble_navcomp_noise(&world->navcomp, &noise) != TUMBLE_OK) {
        bench_json_null(json, "noise");
        return;
    }
    bench_json_open(json, "noise", '{');
    bench_json_whole(json, "block_samples", world->config->noise.blocks.block_samples);
    bench_json_vector(json, "noise_v", noise->noise_v, TUMBLE_CHANNELS);
    bench_json_number(json, "declared_v", noise->declared_v);
    bench_json_open(json, "above_declared", '[');
    for (uint32_t i = 0; i < TUMBLE_CHANNELS; i++) {
        if ((noise->above >> i & 1U) != 0U) {
            bench_json_text(json, NULL, CHANNELS[i]);
        }
    }
    bench_json_close(json, ']');
    bench_json_close(json, '}');
}

static void put_result(const bench_world_t *world, bench_json_t *json)
{
#define NAME(number, name, ...) #name,
    static const char *const ESTIMATORS[TUMBLE_ESTIMATE_COUNT] = {TUMBLE_ESTIMATOR_LIST(NAME, NAME)};
    tumble_result_t result;
    bench_json_text(json, "estimator", ESTIMATORS[world->config->procedure.estimate]);
    if (tumble_navcomp_result(&world->navcomp, &result) != TUMBLE_OK) {
        bench_json_null(json, "K");
        bench_json_null(json, "U0");
        put_uncertainties(world, json);
        put_noise(world, json);
        bench_json_null(json, "verification");
        bench_json_null(json, "closure_g");
        return;
    }
    const uint8_t mountings = world->config->scenario.schedule.mounting_count;
    const tumble_procedure_t *const procedure = tumble_navcomp_procedure(&world->navcomp);
    bench_json_matrix(json, "K", result.coefficients->k_v_per_g);
    bench_json_vector(json, "U0", result.coefficients->u0_v, TUMBLE_CHANNELS);
    put_uncertainties(world, json);
    put_noise(world, json);
    put_check(world, result.check, json);
    bench_json_open(json, "closure_g", '[');
    for (uint8_t m = 0; m < mountings; m++) {
        bench_json_number(json, NULL, tumble_procedure_closure_g(procedure, m));
    }
    bench_json_close(json, ']');
}

static void put_means(const bench_world_t *world, bench_json_t *json)
{
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    const tumble_averaging_t *const averages = tumble_procedure_averages(tumble_navcomp_procedure(&world->navcomp));
    bench_json_open(json, "means", '[');
    for (uint8_t i = 0; i < schedule->position_count; i++) {
        double mean_v[TUMBLE_CHANNELS];
        double error_v[TUMBLE_CHANNELS];
        if (bench_mean(world, i, mean_v, error_v)) {
            bench_json_open(json, NULL, '{');
            bench_json_whole(json, "mounting", schedule->positions[i].mounting);
            bench_json_whole(json, "position", schedule->positions[i].number);
            bench_json_whole(json, "samples", averages->averages[i].samples);
            bench_json_vector(json, "u_v", mean_v, TUMBLE_CHANNELS);
            bench_json_vector(json, "standard_error_v", error_v, TUMBLE_CHANNELS);
            bench_json_close(json, '}');
        }
    }
    bench_json_close(json, ']');
}

static void put_inclinations(const bench_world_t *world, bench_json_t *json)
{
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    double beta_rad[TUMBLE_MAX_MOUNTINGS];
    if (!bench_inclines(schedule)) {
        return;
    }
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        beta_rad[m] = sim_truth_beta_rad(&world->truth, schedule, m);
    }
    bench_json_vector(json, "beta_rad", beta_rad, schedule->mounting_count);
    bench_json_vector(json, "tau_rad", world->truth.tau_rad, schedule->mounting_count);
}

static void put_truth(const bench_world_t *world, bench_json_t *json)
{
    const sim_truth_t *const truth = &world->truth;
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    bench_json_open(json, "truth", '{');
    bench_json_matrix(json, "K", truth->block.k_v_per_g);
    bench_json_vector(json, "U0", truth->block.u0_v, TUMBLE_CHANNELS);
    bench_json_number(json, "alpha1_rad", truth->alpha1_rad);
    bench_json_number(json, "alpha2_rad", truth->alpha2_rad);
    bench_json_vector(json, "alpha3_rad", truth->alpha3_rad, schedule->mounting_count);
    bench_json_vector(json, "alpha4_rad", truth->alpha4_rad, schedule->position_count);
    bench_json_vector(json, "theta_h_rad", truth->theta_h_rad, schedule->mounting_count);
    bench_json_vector(json, "theta_n_rad", truth->theta_n_rad, schedule->mounting_count);
    put_inclinations(world, json);
    bench_json_vector(json, "encoder_rad", truth->encoder_rad, TUMBLE_WAVES);
    bench_json_vector(json, "drift_v", truth->drift_v, TUMBLE_CHANNELS);
    bench_json_close(json, '}');
}

void bench_report_bus_counters(const sim_bus_t *bus, bench_json_t *json)
{
    uint64_t value = 0;
    const char *name;
    for (size_t row = 0; (name = bench_bus_counter(bus, row, &value)) != NULL; row++) {
        bench_json_whole(json, name, value);
    }
}

void bench_report_firmware_counters(const bench_world_t *world, bench_json_t *json)
{
    uint64_t value = 0;
    const char *name;
    for (size_t row = 0; (name = bench_firmware_counter(world, row, &value)) != NULL; row++) {
        bench_json_whole(json, name, value);
    }
}

/* Which faults have come, and how often: one that never did was set up wrongly. */
static void put_faults(const bench_world_t *world, bench_json_t *json)
{
    bench_json_open(json, "faults", '[');
    for (uint32_t i = 0; i < world->config->scenario.fault_count; i++) {
        bench_json_open(json, NULL, '{');
        bench_json_text(json, "kind", sim_fault_word(world->config->scenario.faults[i].kind));
        bench_json_whole(json, "times", world->script.states[i].times);
        bench_json_close(json, '}');
    }
    bench_json_close(json, ']');
}

void bench_report_firmware(const bench_world_t *world, bench_json_t *json)
{
    put_outcome(world, json);
    put_result(world, json);
    put_means(world, json);
}

static void put_table(const bench_travel_t *travel, bench_json_t *json)
{
    bench_json_open(json, "table", '{');
    bench_json_flag(json, "at_rest", travel->at_rest);
    bench_json_number(json, "lowest_deg", travel->lowest_deg);
    bench_json_number(json, "highest_deg", travel->highest_deg);
    bench_json_close(json, '}');
}

void bench_report_simulation(const bench_world_t *world, bench_json_t *json)
{
    const bench_travel_t travel = bench_travel(world);
    put_truth(world, json);
    put_faults(world, json);
    bench_json_number(json, "virtual_s", (double)world->clock.now_us * 1e-6);
    put_table(&travel, json);
}
