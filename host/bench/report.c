#include "bench/report.h"

#include "canopen/abort.h"

#include <stddef.h>

int bench_exit_code(const bench_world_t *world)
{
    tumble_result_t result;
    if (world->end == BENCH_INTERRUPTED) {
        return BENCH_EXIT_INTERRUPTED;
    }
    if (world->end == BENCH_LEFT) {
        return BENCH_EXIT_PASS;
    }
    if (world->end != BENCH_DONE || tumble_navcomp_result(&world->navcomp, &result) != TUMBLE_OK) {
        return BENCH_EXIT_FAULT;
    }
    return result.pass ? BENCH_EXIT_PASS : BENCH_EXIT_LIMITS;
}

const char *bench_step_name(uint8_t step)
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

const char *bench_end_name(bench_end_t end)
{
    static const char *const NAMES[] = {"running", "done", "fault", "interrupted", "too long", "left"};
    return NAMES[end];
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

double bench_largest_delta_g(const tumble_gravity_check_t *check)
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
    bench_json_number(json, "max_abs_delta_g_g", bench_largest_delta_g(check));
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
    bench_json_vector(json, "encoder_rad", truth->encoder_rad, TUMBLE_WAVES);
    bench_json_vector(json, "drift_v", truth->drift_v, TUMBLE_CHANNELS);
    bench_json_close(json, '}');
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

enum { FIRMWARE_COUNTERS = sizeof COUNTERS / sizeof COUNTERS[0], BUS_COUNTERS = 4 };

static const char *bus_counter(const sim_bus_t *bus, size_t row, uint64_t *value)
{
    static const char *const NAMES[BUS_COUNTERS] = {"bus_frames", "bus_bits", "bus_busy_us", "bus_overflow"};
    uint64_t overflow = 0;
    for (int n = 0; n < SIM_BUS_NODES; n++) {
        overflow += (uint64_t)bus->nodes[n].counters.rx_overflow + bus->nodes[n].counters.tx_overflow;
    }
    const uint64_t values[BUS_COUNTERS] = {bus->load.frames, bus->load.bits, bus->load.busy_us, overflow};
    *value = (row < BUS_COUNTERS) ? values[row] : 0U;
    return (row < BUS_COUNTERS) ? NAMES[row] : NULL;
}

static const char *firmware_counter(const bench_world_t *world, size_t row, uint64_t *value)
{
    if (row == FIRMWARE_COUNTERS) {
        *value = world->steps;
        return "firmware_steps";
    }
    tumble_navcomp_counters_t counters;
    tumble_navcomp_counters(&world->navcomp, &counters);
    *value = *(const uint32_t *)(const void *)((const char *)&counters + COUNTERS[row].offset);
    return COUNTERS[row].name;
}

const char *bench_counter(const bench_world_t *world, size_t row, uint64_t *value)
{
    return (row <= FIRMWARE_COUNTERS) ? firmware_counter(world, row, value)
                                      : bus_counter(&world->bus, row - FIRMWARE_COUNTERS - 1U, value);
}

void bench_report_bus_counters(const sim_bus_t *bus, bench_json_t *json)
{
    uint64_t value = 0;
    for (size_t row = 0; row < BUS_COUNTERS; row++) {
        const char *const name = bus_counter(bus, row, &value);
        bench_json_whole(json, name, value);
    }
}

void bench_report_firmware_counters(const bench_world_t *world, bench_json_t *json)
{
    uint64_t value = 0;
    for (size_t row = 0; row <= FIRMWARE_COUNTERS; row++) {
        const char *const name = firmware_counter(world, row, &value);
        bench_json_whole(json, name, value);
    }
}

void bench_report_counters(const bench_world_t *world, bench_json_t *json)
{
    bench_json_open(json, "counters", '{');
    bench_report_firmware_counters(world, json);
    bench_report_bus_counters(&world->bus, json);
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

void bench_report_firmware(const bench_world_t *world, bench_json_t *json)
{
    put_outcome(world, json);
    put_result(world, json);
    put_means(world, json);
}

bench_travel_t bench_travel(const bench_world_t *world)
{
    bench_travel_t travel = {.at_rest = bench_world_is_at_rest(world)};
    sim_axis_extent(world->axis, world->clock.now_us, &travel.lowest_deg, &travel.highest_deg);
    return travel;
}

void bench_travel_add(bench_travel_t *all, const bench_travel_t *one, bool first)
{
    all->at_rest = one->at_rest && (first || all->at_rest);
    all->lowest_deg = (first || one->lowest_deg < all->lowest_deg) ? one->lowest_deg : all->lowest_deg;
    all->highest_deg = (first || one->highest_deg > all->highest_deg) ? one->highest_deg : all->highest_deg;
}

void bench_report_table(const bench_travel_t *travel, bench_json_t *json)
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
    bench_report_table(&travel, json);
}

void bench_report_document(const bench_world_t *world, FILE *out)
{
    bench_json_t json = {.out = out};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.bench/1");
    bench_report_firmware(world, &json);
    bench_report_counters(world, &json);
    bench_report_simulation(world, &json);
    bench_json_close(&json, '}');
    (void)fputc('\n', out);
}
