#include "report.h"

#include "arguments.h"
#include "json.h"
#include "world/readout.h"

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

static void put_counters(const bench_world_t *world, bench_json_t *json)
{
    uint64_t value = 0;
    const char *name;
    for (size_t row = 0; (name = bench_firmware_counter(world, row, &value)) != NULL; row++) {
        bench_json_whole(json, name, value);
    }
}

static void put_interface(const computer_t *computer, bench_json_t *json)
{
    const can_socket_t *const can = &computer->bus.can;
    bench_json_whole(json, "frames_foreign", computer->bus.foreign);
    bench_json_interface(json, &can->counters);
    bench_json_whole(json, "receive_buffer_bytes", can->receive_buffer);
    bench_json_whole(json, "latest_step_us", computer->latest_us);
}

/* The run's first fault, whatever followed from it (the reason of a run that was aborted in FAULT is the command); null
 * where there was none, or the run got over it. */
static void put_cause(const tumble_progress_t *fault, bench_json_t *json)
{
    if (fault->reason == TUMBLE_REASON_NONE) {
        bench_json_null(json, "cause");
        return;
    }
    bench_json_open(json, "cause", '{');
    bench_json_text(json, "failed_in", tumble_state_name(fault->failed_in));
    bench_json_text(json, "reason", tumble_reason_name(fault->reason));
    bench_json_whole(json, "reason_number", (uint64_t)fault->reason);
    bench_json_text(json, "reason_sentence", tumble_reason_sentence(fault->reason));
    bench_json_whole(json, "drive_code", fault->drive_code);
    bench_json_close(json, '}');
}

void node_report(const bench_world_t *world, const computer_t *computer, const tumble_progress_t *cause, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.node/1");
    bench_json_text(&json, "interface", computer->bus.can.name);
    put_outcome(world, &json);
    put_result(world, &json);
    put_means(world, &json);
    put_cause(cause, &json);
    bench_json_open(&json, "counters", '{');
    put_counters(world, &json);
    put_interface(computer, &json);
    bench_json_close(&json, '}');
    bench_json_number(&json, "virtual_s", (double)world->clock.now_us * 1e-6);
    bench_json_end(&json);
}

/* As it goes. */

static bench_json_t begin(const char *event, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "event", event);
    return json;
}

static void put_time(bench_json_t *json, const bench_world_t *world)
{
    bench_json_number(json, "virtual_s", (double)world->clock.now_us * 1e-6);
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

void bench_progress_state(const bench_world_t *world, const tumble_progress_t *progress, FILE *out)
{
    bench_json_t json = begin("state", out);
    put_time(&json, world);
    put_place(&json, progress);
    put_angle(&json, world);
    bench_json_end(&json);
}

void bench_progress_average(const bench_world_t *world, tumble_taken_t taken, FILE *out)
{
    const uint32_t wanted = world->config->procedure.samples;
    const uint32_t tenth = (wanted < 10U) ? 1U : wanted / 10U;
    tumble_navcomp_progress_t progress;
    if (taken.ordinal % tenth != 0U) {
        return;
    }
    tumble_navcomp_progress(&world->navcomp, &progress);
    bench_json_t json = begin("average", out);
    put_time(&json, world);
    put_place(&json, &progress.run);
    put_angle(&json, world);
    bench_json_whole(&json, "samples", taken.ordinal);
    bench_json_whole(&json, "wanted", wanted);
    if (progress.has_mean) {
        bench_json_vector(&json, "mean_v", progress.mean_v, TUMBLE_CHANNELS);
        bench_json_vector(&json, "standard_error_v", progress.standard_error_v, TUMBLE_CHANNELS);
    } else {
        bench_json_null(&json, "mean_v");
        bench_json_null(&json, "standard_error_v");
    }
    bench_json_end(&json);
}

void bench_progress_question(const bench_world_t *world, const bench_question_t *question, FILE *out)
{
    static const char *const KINDS[] = {"none", "mounting", "angle", "fault"};
    bench_json_t json = begin("question", out);
    put_time(&json, world);
    bench_json_text(&json, "kind", KINDS[question->kind]);
    bench_json_whole(&json, "mounting", question->mounting);
    if (question->kind == BENCH_QUESTION_ANGLE) {
        bench_json_number(&json, "angle_deg", question->angle_deg);
    } else if (question->kind == BENCH_QUESTION_FAULT) {
        bench_json_text(&json, "reason", tumble_reason_name(question->reason));
        bench_json_text(&json, "sentence", tumble_reason_sentence(question->reason));
    }
    bench_json_end(&json);
}

void bench_progress_refused(const char *what, FILE *out)
{
    bench_json_t json = begin("refused", out);
    bench_json_text(&json, "what", what);
    bench_json_end(&json);
}

void bench_progress_end(const bench_world_t *world, FILE *out)
{
    bench_json_t json = begin("end", out);
    put_time(&json, world);
    bench_json_text(&json, "end", bench_end_name(world->end));
    bench_json_whole(&json, "exit", (uint64_t)bench_exit_code(world));
    bench_json_end(&json);
}
