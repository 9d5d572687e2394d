#include "world/report.h"

#include "canopen/abort.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

const char *bench_end_name(world_end_t end)
{
    static const char *const NAMES[] = {"running", "done", "fault", "interrupted", "too long", "left"};
    return NAMES[end];
}

int bench_exit_code(const bench_world_t *world)
{
    tumble_result_t result;
    if (world->end == WORLD_INTERRUPTED) {
        return WORLD_EXIT_INTERRUPTED;
    }
    if (world->end == WORLD_LEFT) {
        return WORLD_EXIT_PASS;
    }
    if (world->end != WORLD_DONE || tumble_navcomp_result(&world->navcomp, &result) != TUMBLE_OK) {
        return WORLD_EXIT_FAULT;
    }
    return result.pass ? WORLD_EXIT_PASS : WORLD_EXIT_LIMITS;
}

static const char *step_name(uint8_t step)
{
#define NAME(number, name, what) [number] = #name,
    static const char *const NAMES[] = {TUMBLE_STAND_STEP_LIST(NAME)};
#undef NAME
    const bool known = step < sizeof NAMES / sizeof NAMES[0] && NAMES[step] != NULL;
    return known ? NAMES[step] : "UNKNOWN";
}

void bench_refusal_sentence(const tumble_stand_refusal_t *refusal, char *text, size_t size)
{
#define WHAT(number, name, what) [number] = (what),
    static const char *const WHATS[] = {TUMBLE_STAND_STEP_LIST(WHAT)};
#undef WHAT
    const bool known = refusal->step < sizeof WHATS / sizeof WHATS[0] && WHATS[refusal->step] != NULL;
    (void)snprintf(text, size, "drive object %04Xh:%u, abort %04X %04Xh (%s), in %s", (unsigned)refusal->index,
                   (unsigned)refusal->subindex, (unsigned)(refusal->abort >> 16U), (unsigned)(refusal->abort & 0xFFFFU),
                   tumble_abort_sentence(refusal->abort), known ? WHATS[refusal->step] : "a step unknown here");
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
    bench_json_text(json, "step", step_name(refusal.step));
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

bool bench_mean(const bench_world_t *world, uint8_t index, double mean_v[TUMBLE_CHANNELS],
                double error_v[TUMBLE_CHANNELS])
{
    const tumble_averaging_t *const averages = tumble_procedure_averages(tumble_navcomp_procedure(&world->navcomp));
    const double step_v = world->config->procedure.v_per_count;
    if (tumble_averaging_mean(averages, index, mean_v, error_v) != TUMBLE_OK) {
        return false;
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        mean_v[i] *= step_v;
        error_v[i] *= step_v;
    }
    return true;
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

void bench_report_run(const bench_world_t *world, bench_json_t *json)
{
    put_outcome(world, json);
    put_result(world, json);
    put_means(world, json);
}

typedef struct {
    const char *name;
    size_t offset; /* of a uint32_t */
} counter_t;

#define OF(member) offsetof(tumble_navcomp_counters_t, member)

static const counter_t COUNTERS[] = {
    {"frames_sent", OF(link.sent)},
    {"frames_received", OF(link.received)},
    {"frames_busy", OF(link.busy)},
    {"frames_down", OF(link.down)},
    {"frames_invalid", OF(link.invalid)},
    {"frames_ignored", OF(events.frames_ignored)},
    {"commands_refused", OF(events.commands_refused)},
    {"heartbeats_lost", OF(events.heartbeats_lost)},
    {"boot_ups", OF(events.boot_ups)},
    {"starts", OF(events.starts)},
    {"emergencies", OF(events.emergencies)},
    {"samples_received", OF(block.samples)},
    {"samples_lost", OF(block.lost)},
    {"frames_repeated", OF(block.repeated)},
    {"frames_reordered", OF(block.reordered)},
    {"frames_wrong_length", OF(block.wrong_length)},
    {"frames_wrong_crc", OF(block.wrong_crc)},
    {"frames_wrong_pair", OF(block.wrong_pair)},
    {"lone_halves", OF(block.lone_halves)},
    {"averaging_saturated", OF(averaging.saturated)},
    {"averaging_deviating", OF(averaging.deviating)},
    {"averaging_repeated", OF(averaging.repeated)},
    {"averaging_reordered", OF(averaging.reordered)},
    {"averaging_lost", OF(averaging.lost)},
    {"procedure_samples", OF(procedure.samples)},
    {"procedure_corrupted", OF(procedure.corrupted)},
    {"samples_averaged", OF(procedure.averaged)},
    {"positions_kept", OF(procedure.positions)},
    {"positions_refused", OF(procedure.refused)},
    {"retries", OF(procedure.retries)},
    {"timeouts", OF(procedure.timeouts)},
    {"moves", OF(procedure.moves)},
    {"unwinds", OF(procedure.unwinds)},
    {"homings", OF(procedure.homings)},
    {"faults", OF(procedure.faults)},
    {"resumes", OF(procedure.resumes)},
};

void bench_report_counters(const bench_world_t *world, bench_json_t *json)
{
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(&world->navcomp, &counters);
    for (size_t i = 0; i < sizeof COUNTERS / sizeof COUNTERS[0]; i++) {
        bench_json_whole(json, COUNTERS[i].name,
                         *(const uint32_t *)(const void *)((const char *)&counters + COUNTERS[i].offset));
    }
    bench_json_whole(json, "firmware_steps", world->steps);
}

/* What a simulation knows. */

void bench_report_bus_counters(const bench_world_t *world, bench_json_t *json)
{
    const sim_bus_t *const bus = &world->bus;
    uint64_t overflow = 0;
    for (int n = 0; n < SIM_BUS_NODES; n++) {
        overflow += (uint64_t)bus->nodes[n].counters.rx_overflow + bus->nodes[n].counters.tx_overflow;
    }
    bench_json_whole(json, "bus_frames", bus->load.frames);
    bench_json_whole(json, "bus_bits", bus->load.bits);
    bench_json_whole(json, "bus_busy_us", bus->load.busy_us);
    bench_json_whole(json, "bus_overflow", overflow);
}

/* Of a block that is bolted on: then the inclinations of the stand belong to the truth. */
static void put_inclinations(const bench_world_t *world, bench_json_t *json)
{
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    double beta_rad[TUMBLE_MAX_MOUNTINGS];
    bool inclines = false;
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        beta_rad[m] = sim_truth_beta_rad(&world->truth, schedule, m);
        inclines = inclines || schedule->mountings[m].bolting > 0U;
    }
    if (inclines) {
        bench_json_vector(json, "beta_rad", beta_rad, schedule->mounting_count);
        bench_json_vector(json, "tau_rad", world->truth.tau_rad, schedule->mounting_count);
    }
}

/* K and U0 by powers of the degrees above the reference; not of a block that is the same at all temperatures. */
static void put_temperature(const bench_world_t *world, bench_json_t *json)
{
    static const double NONE[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
    const sim_temperature_t *const t = &world->config->scenario.block.sensor.temperature;
    const tumble_coefficients_t *const block = &world->truth.block;
    double slope[TUMBLE_CHANNELS][TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            slope[i][j] = t->scale_per_c[i] * block->k_v_per_g[i][j] + t->k_per_c[i][j];
        }
    }
    if (memcmp(t->scale_per_c, NONE, sizeof t->scale_per_c) == 0 && memcmp(t->k_per_c, NONE, sizeof NONE) == 0 &&
        memcmp(t->k_per_c2, NONE, sizeof NONE) == 0 && memcmp(t->bias_v_per_c, NONE, sizeof t->bias_v_per_c) == 0 &&
        memcmp(t->bias_v_per_c2, NONE, sizeof t->bias_v_per_c2) == 0) {
        return;
    }
    bench_json_open(json, "over_temperature", '{');
    bench_json_number(json, "reference_c", t->reference_c);
    bench_json_open(json, "K", '[');
    bench_json_matrix(json, NULL, block->k_v_per_g);
    bench_json_matrix(json, NULL, slope);
    bench_json_matrix(json, NULL, t->k_per_c2);
    bench_json_close(json, ']');
    bench_json_open(json, "U0", '[');
    bench_json_vector(json, NULL, block->u0_v, TUMBLE_CHANNELS);
    bench_json_vector(json, NULL, t->bias_v_per_c, TUMBLE_CHANNELS);
    bench_json_vector(json, NULL, t->bias_v_per_c2, TUMBLE_CHANNELS);
    bench_json_close(json, ']');
    bench_json_close(json, '}');
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

void bench_report_truth(const bench_world_t *world, bench_json_t *json)
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
    put_temperature(world, json);
    bench_json_close(json, '}');
    put_faults(world, json);
}

bench_travel_t bench_travel(const bench_world_t *world)
{
    bench_travel_t travel = {.at_rest = bench_world_is_at_rest(world)};
    sim_axis_extent(world->axis, world->clock.now_us, &travel.lowest_deg, &travel.highest_deg);
    return travel;
}

void bench_report_table(const bench_world_t *world, bench_json_t *json)
{
    const bench_travel_t travel = bench_travel(world);
    bench_json_open(json, "table", '{');
    bench_json_flag(json, "at_rest", travel.at_rest);
    bench_json_number(json, "lowest_deg", travel.lowest_deg);
    bench_json_number(json, "highest_deg", travel.highest_deg);
    bench_json_close(json, '}');
}
/* As it goes. */

static void begin(bench_json_t *json, const char *event, const bench_world_t *world)
{
    bench_json_open(json, NULL, '{');
    bench_json_text(json, "event", event);
    if (world != NULL) {
        bench_json_number(json, "virtual_s", (double)world->clock.now_us * 1e-6);
    }
}

/* Where the table stands, as long as that is known: it has homed, and the axis has no fault. */
static void put_angle(bench_json_t *json, const bench_world_t *world)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&world->navcomp, &progress);
    const bool moving = progress.stand == TUMBLE_STAND_MOVING;
    if (moving || progress.stand == TUMBLE_STAND_IN_POSITION || progress.stand == TUMBLE_STAND_STOPPED) {
        bench_json_number(json, "angle_deg", progress.angle_deg);
    } else {
        bench_json_null(json, "angle_deg");
    }
}

static void put_place(bench_json_t *json, const tumble_progress_t *progress)
{
    bench_json_text(json, "state", tumble_state_name(progress->state));
    bench_json_whole(json, "mounting", progress->mounting);
    bench_json_whole(json, "position", progress->position);
    bench_json_whole(json, "index", progress->index);
    bench_json_whole(json, "count", progress->count);
    bench_json_whole(json, "finished", progress->finished);
    bench_json_whole(json, "attempt", progress->attempt);
    bench_json_text(json, "reason", tumble_reason_name(progress->reason));
}

void bench_progress_state(const bench_world_t *world, bench_json_t *json)
{
    begin(json, "state", world);
    put_place(json, &world->progress);
    put_angle(json, world);
    bench_json_end(json);
}

bool bench_progress_angle(const bench_world_t *world, bench_json_t *json)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&world->navcomp, &progress);
    begin(json, "angle", world);
    put_angle(json, world);
    bench_json_end(json);
    return progress.stand == TUMBLE_STAND_MOVING;
}

bool bench_is_tenth(const bench_world_t *world, uint32_t samples)
{
    const uint32_t wanted = world->config->procedure.samples;
    return samples % ((wanted < 10U) ? 1U : wanted / 10U) == 0U;
}

void bench_progress_average(const bench_world_t *world, uint32_t samples, bench_json_t *json)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&world->navcomp, &progress);
    begin(json, "average", world);
    put_place(json, &progress.run);
    put_angle(json, world);
    bench_json_whole(json, "samples", samples);
    bench_json_whole(json, "wanted", world->config->procedure.samples);
    if (progress.has_mean) {
        bench_json_vector(json, "mean_v", progress.mean_v, TUMBLE_CHANNELS);
        bench_json_vector(json, "standard_error_v", progress.standard_error_v, TUMBLE_CHANNELS);
    } else {
        bench_json_null(json, "mean_v");
        bench_json_null(json, "standard_error_v");
    }
    bench_json_end(json);
}

void bench_progress_question(const bench_world_t *world, const bench_question_t *question, bench_json_t *json)
{
    static const char *const KINDS[] = {"none", "mounting", "angle", "fault"};
    begin(json, "question", world);
    bench_json_text(json, "kind", KINDS[question->kind]);
    bench_json_whole(json, "mounting", question->mounting);
    if (question->kind == BENCH_QUESTION_ANGLE) {
        bench_json_number(json, "angle_deg", question->angle_deg);
    } else if (question->kind == BENCH_QUESTION_FAULT) {
        bench_json_text(json, "reason", tumble_reason_name(question->reason));
        bench_json_text(json, "sentence", tumble_reason_sentence(question->reason));
    }
    bench_json_end(json);
}

void bench_progress_refused(const char *what, bench_json_t *json)
{
    begin(json, "refused", NULL);
    bench_json_text(json, "what", what);
    bench_json_end(json);
}

void bench_progress_end(const bench_world_t *world, bench_json_t *json)
{
    begin(json, "end", world);
    bench_json_text(json, "end", bench_end_name(world->end));
    bench_json_whole(json, "exit", (uint64_t)bench_exit_code(world));
    bench_json_end(json);
}
