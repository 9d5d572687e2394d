#include "world/border.h"

#include "navcomp/keeper.h"
#include "navcomp/uncertainty.h"
#include "world/config_file.h"
#include "world/readout.h"
#include "world/world_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_LINE 1024

_Static_assert(WORLD_POSITIONS == TUMBLE_MAX_POSITIONS && WORLD_MOUNTINGS == TUMBLE_MAX_MOUNTINGS,
               "all of a schedule fits");

/* The next element; null: no memory. */
static void *append(world_t *world, array_t *array, size_t size)
{
    if (array->count == array->room) {
        const size_t room = (array->room == 0U) ? 64U : 2U * array->room;
        void *const larger = realloc(array->memory, room * size);
        if (larger == NULL) {
            world->no_memory = true;
            return NULL;
        }
        array->memory = larger;
        array->room = room;
    }
    return (char *)array->memory + (size * array->count++);
}

world_t *world_new(void)
{
    world_t *const world = calloc(1, sizeof *world);
    if (world != NULL) {
        bench_config_defaults(&world->config);
        world->heard_us = SIM_NEVER;
    }
    return world;
}

void world_free(world_t *world)
{
    if (world == NULL) {
        return;
    }
    for (int i = 0; i < TUMBLE_MAX_POSITIONS; i++) {
        free(world->taken[i].memory);
    }
    free(world->frames.memory);
    free(world->samples.memory);
    free(world->recording);
    free(world->gains);
    free(world);
}

/* Keys. */

world_key_t world_key(size_t row)
{
    static char range[200];
    if (row >= bench_config_key_count) {
        return (world_key_t){.name = NULL};
    }
    const bench_key_t *const key = &bench_config_keys[row];
    bench_describe_key(key, range, sizeof range);
    return (world_key_t){(key->name != NULL) ? key->name : "", range, key->about, key->count};
}

const char *world_fault_kind(size_t row, const char **about)
{
#define WORD(name, word, sentence) word,
#define SENTENCE(name, word, sentence) sentence,
    static const char *const WORDS[] = {SIM_FAULT_LIST(WORD)};
    static const char *const SENTENCES[] = {SIM_FAULT_LIST(SENTENCE)};
#undef WORD
#undef SENTENCE
    const bool known = row < sizeof WORDS / sizeof WORDS[0];
    *about = known ? SENTENCES[row] : NULL;
    return known ? WORDS[row] : NULL;
}

const char *world_set(world_t *world, const char *line)
{
    char text[MAX_LINE];
    if (strlen(line) >= sizeof text) {
        return "longer than 1022 characters, or no text";
    }
    (void)strcpy(text, line);
    return bench_config_take(&world->config, text, &world->seen, &world->mistake) ? NULL : world->mistake.what;
}

const char *world_set_gains(world_t *world, const uint8_t *record, size_t size)
{
    free(world->gains);
    world->gains = malloc((size > 0U) ? size : 1U);
    if (world->gains == NULL) {
        return "no memory";
    }
    (void)memcpy(world->gains, record, size);
    world->config.gains.record = world->gains;
    world->config.gains.record_bytes = size;
    return NULL;
}

/* What the world tells. */

static void on_change(void *context, const tumble_progress_t *progress)
{
    (void)progress;
    world_t *const world = context;
    world->happened |= WORLD_CHANGE;
    if (world->operator == WORLD_ON_CONFIRM) {
        bench_person_follow(&world->world, &world->world.person.question);
    }
}

/* Of all times that a timestamp can mean, the one nearest to the last one and what has passed here since. */
static uint64_t unwrapped_ms(const world_t *world, uint16_t timestamp_ms)
{
    const uint64_t period_ms = TUMBLE_TIMESTAMP_PERIOD_MS;
    if (world->heard_us == SIM_NEVER) {
        return timestamp_ms;
    }
    const uint64_t passed_ms = (world->world.clock.now_us - world->heard_us) / 1000U;
    const uint64_t most_ms = world->block_ms + passed_ms + period_ms / 2U;
    const uint64_t back_ms = (most_ms + period_ms - timestamp_ms) % period_ms;
    return (back_ms <= most_ms) ? most_ms - back_ms : timestamp_ms;
}

/* Ordinal 1: the position begins again, and what was recorded of it is void. */
static void on_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    world_t *const world = context;
    const uint32_t wanted = world->config.procedure.samples;
    array_t *const of_position = &world->taken[taken.index];
    world->block_ms = unwrapped_ms(world, sample->timestamp_ms);
    world->heard_us = world->world.clock.now_us;
    if (taken.ordinal == 1U) {
        of_position->count = 0;
    }
    world_sample_t *const recorded = append(world, of_position, sizeof *recorded);
    if (recorded != NULL) {
        *recorded = (world_sample_t){
            .block_ms = world->block_ms,
            .counts = {sample->raw.counts[0], sample->raw.counts[1], sample->raw.counts[2]},
            .ordinal = taken.ordinal,
            .counter = sample->raw.counter,
            .timestamp_ms = sample->timestamp_ms,
            .index = taken.index,
            .temperature_half_c = sample->temperature_half_c,
        };
    }
    if (taken.ordinal % ((wanted < 10U) ? 1U : wanted / 10U) == 0U) {
        world->happened |= WORLD_AVERAGED;
    }
}

static void on_frame(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    world_t *const world = context;
    world_frame_t *const recorded = append(world, &world->frames, sizeof *recorded);
    if (recorded != NULL) {
        *recorded = (world_frame_t){.time_us = time_us, .id = frame->id, .length = frame->length, .sender = sender};
        (void)memcpy(recorded->data, frame->data, frame->length);
    }
    world->happened |= (sender != BENCH_BUS_GUEST) ? WORLD_FRAME : 0U;
}

static bool on_question(void *context, const bench_question_t *question)
{
    (void)question;
    world_t *const world = context;
    world->happened |= WORLD_QUESTION;
    return world->operator != WORLD_BY_ITSELF;
}

/* What was found is judged, and perhaps kept, after the run. */
static bool is_busy(void *context)
{
    const world_t *const world = context;
    return world->has_memory && !world->world.off && tumble_keeper_has_work(&world->memory.keeper);
}

/* Power and time. */

void world_add_memory(world_t *world)
{
    memory_t *const memory = &world->memory;
    const bench_keeping_t *const keeping = &world->config.keeping;
    sim_nv_init(&memory->nv, &world->world.clock);
    memory->keeper_config = (tumble_keeper_config_t){
        .sets = {.serial = keeping->serial,
                 .settings = &keeping->settings,
                 .whole_step = tumble_whole_step,
                 .whole_work = &memory->whole_work},
        .uncertainty = tumble_navcomp_uncertainty,
        .norm = tumble_navcomp_norm,
        .stand_view = tumble_stand_view,
        .stand_memory = &memory->stand_memory,
        .inclinations_view = tumble_inclinations_view,
        .inclinations_memory = &memory->inclinations_memory,
    };
    world->world.port.nv = &memory->nv.nv;
    world->world.navcomp_config.keeping = &tumble_keeper_calls;
    world->world.navcomp_config.keeper = &memory->keeper;
}

void world_set_off(world_t *world, bool off)
{
    bench_world_t *const own = &world->world;
    own->off = off;
    sim_bus_set_down(&own->bus, BENCH_BUS_NAVCOMP, true); /* with it goes what had come for nobody */
    if (off) {
        sim_clock_set(&own->clock, SIM_ACTOR_NAVCOMP, SIM_NEVER);
        world->memory.nv.size = 0;
    } else {
        sim_bus_set_down(&own->bus, BENCH_BUS_NAVCOMP, false);
    }
}

tumble_status_t world_boot(world_t *world)
{
    bench_world_t *const own = &world->world;
    memset(&world->memory.keeper, 0x5A, sizeof world->memory.keeper);
    memset(&world->memory.stand_memory, 0, sizeof world->memory.stand_memory);
    memset(&world->memory.inclinations_memory, 0, sizeof world->memory.inclinations_memory);
    world->memory.keeper.config = &world->memory.keeper_config;
    if (world->config.present.navcomp) {
        sim_clock_set(&own->clock, SIM_ACTOR_NAVCOMP, own->clock.now_us);
    }
    return tumble_navcomp_init(&own->navcomp, &own->navcomp_config);
}

const char *world_check(world_t *world)
{
    if (!bench_config_check(&world->config, &world->seen, &world->mistake)) {
        return world->mistake.what;
    }
    const char *const wrong = bench_config_complete(&world->config);
    return (wrong != NULL) ? wrong : bench_config_refused(&world->config);
}

void world_record_nothing(world_t *world)
{
    world->records_nothing = true;
}

const char *world_power_on(world_t *world, uint64_t seed, world_operator_t operator, bool memory)
{
    bench_config_t *const config = &world->config;
    const char *wrong = world_check(world);
    if (wrong == NULL && memory && config->keeping.serial[0] == '\0') {
        wrong = "keeper.serial is missing: who keeps coefficients must be told whose they are";
    }
    if (wrong != NULL) {
        return wrong;
    }
    world->operator = operator;
    world->has_memory = memory;
    world->watcher = (bench_watcher_t){world, on_change, on_sample, on_frame, on_question, is_busy};
    if (world->records_nothing) {
        world->watcher.on_sample = NULL;
        world->watcher.on_frame = NULL;
    }
    tumble_status_t status = bench_world_init(&world->world, config, seed, &world->watcher);
    if (status == TUMBLE_OK && memory) {
        world_add_memory(world);
        status = world_boot(world); /* the start is forgotten */
    }
    if (status == TUMBLE_OK && memory && config->starts && config->present.navcomp) {
        status = tumble_navcomp_command(&world->world.navcomp, TUMBLE_COMMAND_START, 0);
    }
    return (status == TUMBLE_OK) ? NULL : tumble_status_sentence(status);
}

uint64_t world_now_us(const world_t *world)
{
    return world->world.clock.now_us;
}

unsigned world_advance(world_t *world, uint64_t until_us, unsigned stop_at)
{
    bench_world_t *const own = &world->world;
    world->happened = 0;
    while (!world->no_memory && (bench_world_has_ended(own) || bench_world_next_us(own) <= until_us)) {
        const bool goes_on = bench_world_advance(own);
        if (world->no_memory) {
            break;
        }
        if (!goes_on) {
            return (world->happened & stop_at) | WORLD_ENDED;
        }
        if ((world->happened & stop_at) != 0U) {
            return world->happened & stop_at;
        }
    }
    if (world->no_memory) {
        return WORLD_NO_MEMORY;
    }
    bench_world_pass(own, until_us);
    return 0;
}

void world_end(world_t *world, world_end_t end)
{
    bench_world_end(&world->world, end);
}

/* What is done to it. */

const char *world_send(world_t *world, uint16_t id, uint8_t length, const uint8_t *data)
{
    tumble_can_frame_t frame = {.id = id, .length = length};
    if (id > TUMBLE_CAN_MAX_ID || length > TUMBLE_CAN_MAX_BYTES) {
        return "no classic data frame with an 11-bit identifier";
    }
    (void)memcpy(frame.data, data, length);
    (void)sim_bus_send(&world->world.bus, BENCH_BUS_GUEST, &frame); /* the bus counts those that find the queue full */
    return NULL;
}

const char *world_turn_table(world_t *world, double angle_deg, double speed_deg_s)
{
    if (world->config.present.drive) {
        return "the simulated drive turns the table: present.drive = no leaves it to another";
    }
    if (!(fabs(angle_deg) <= 36000.0 && speed_deg_s >= 1e-5 && speed_deg_s <= 1e5)) {
        return "the table turns to -36000 to 36000 deg, at 1e-5 to 1e5 deg/s";
    }
    bench_world_turn(&world->world, angle_deg, speed_deg_s);
    return NULL;
}

const char *world_answer(world_t *world, world_answer_t answer, uint8_t argument)
{
    const tumble_status_t status = bench_person_answer(&world->world, answer, argument);
    return (status == TUMBLE_OK) ? NULL : tumble_status_sentence(status);
}

/* As when the board's supply fails and returns: what had come for the computer is lost with all that it knew. */
const char *world_set_power(world_t *world, bool on)
{
    bench_world_t *const own = &world->world;
    if (own->off != on) {
        return NULL;
    }
    world_set_off(world, !on);
    if (!on) {
        return NULL;
    }
    const tumble_status_t status = world_boot(world);
    own->mark = BENCH_LOOK_AGAIN;
    own->started = false; /* whatever had ended: there is another run to come */
    own->wanted_end = WORLD_RUNNING;
    own->end = WORLD_RUNNING;
    own->ending_us = SIM_NEVER;
    return (status == TUMBLE_OK) ? NULL : tumble_status_sentence(status);
}

const char *world_start(world_t *world)
{
    const tumble_status_t status = tumble_navcomp_command(&world->world.navcomp, TUMBLE_COMMAND_START, 0);
    sim_clock_set(&world->world.clock, SIM_ACTOR_NAVCOMP, world->world.clock.now_us);
    return (status == TUMBLE_OK) ? NULL : tumble_status_sentence(status);
}

uint8_t *world_memory(world_t *world, size_t *size)
{
    *size = world->has_memory ? sizeof world->memory.nv.bytes : 0U;
    return world->has_memory ? world->memory.nv.bytes : NULL;
}

/* What was recorded. */

const world_frame_t *world_frames(const world_t *world, size_t *count)
{
    *count = world->frames.count;
    return world->frames.memory;
}

const world_sample_t *world_samples(world_t *world, size_t *count)
{
    double mean_v[TUMBLE_CHANNELS];
    double error_v[TUMBLE_CHANNELS];
    world->samples.count = 0;
    for (uint8_t i = 0; i < world->config.scenario.schedule.position_count; i++) {
        const world_sample_t *const taken = world->taken[i].memory;
        const size_t kept = bench_mean(&world->world, i, mean_v, error_v) ? world->taken[i].count : 0U;
        for (size_t n = 0; n < kept; n++) {
            world_sample_t *const sample = append(world, &world->samples, sizeof *sample);
            if (sample != NULL) {
                *sample = taken[n];
            }
        }
    }
    *count = world->samples.count;
    return world->samples.memory;
}

/* How it stands. */

static void report_procedure(world_t *world, world_report_t *report)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&world->world.navcomp, &progress);
    const tumble_progress_t *const run = &world->world.progress;
    report->state = tumble_state_name(run->state);
    report->failed_in = tumble_state_name(run->failed_in);
    report->reason = tumble_reason_name(run->reason);
    report->reason_sentence = tumble_reason_sentence(run->reason);
    report->status = tumble_status_name(run->status);
    report->reason_number = (uint32_t)run->reason;
    report->drive_code = run->drive_code;
    report->mounting = run->mounting;
    report->position = run->position;
    report->index = run->index;
    report->count = run->count;
    report->finished = progress.run.finished;
    report->attempt = run->attempt;
    report->samples = progress.run.samples;
    report->wanted = world->config.procedure.samples;
    report->has_mean = progress.has_mean;
    memcpy(report->mean_v, progress.mean_v, sizeof report->mean_v);
    memcpy(report->standard_error_v, progress.standard_error_v, sizeof report->standard_error_v);
    report->moving = progress.stand == TUMBLE_STAND_MOVING;
    report->has_angle =
        report->moving || progress.stand == TUMBLE_STAND_IN_POSITION || progress.stand == TUMBLE_STAND_STOPPED;
    report->angle_deg = report->has_angle ? progress.angle_deg : 0.0;
}

static void report_question(const bench_question_t *question, world_report_t *report)
{
    static const char *const KINDS[] = {NULL, "mounting", "angle", "fault"};
    report->question = KINDS[question->kind];
    report->question_mounting = question->mounting;
    report->question_deg = question->angle_deg;
    report->question_reason = tumble_reason_name(question->reason);
    report->question_sentence = tumble_reason_sentence(question->reason);
}

static void report_refusal(const world_t *world, world_report_t *report)
{
    const tumble_stand_refusal_t refusal = tumble_navcomp_drive_refusal(&world->world.navcomp);
    report->refused_index = refusal.index;
    report->refused_subindex = refusal.subindex;
    report->refused_abort = refusal.abort;
    report->refused_step = bench_step_name(refusal.step);
    bench_refusal_sentence(&refusal, report->refused_sentence, sizeof report->refused_sentence);
}

static void report_result(const world_t *world, world_report_t *report)
{
#define NAME(number, name, ...) #name,
    static const char *const ESTIMATORS[TUMBLE_ESTIMATE_COUNT] = {TUMBLE_ESTIMATOR_LIST(NAME, NAME)};
#undef NAME
    const tumble_navcomp_t *const navcomp = &world->world.navcomp;
    tumble_result_t result;
    report->estimator = ESTIMATORS[world->config.procedure.estimate];
    report->limit_g = world->config.procedure.gravity_limit_g;
    report->v_per_count = world->config.procedure.v_per_count;
    report->has_result = tumble_navcomp_result(navcomp, &result) == TUMBLE_OK;
    if (!report->has_result) {
        return;
    }
    report->pass = result.pass;
    memcpy(report->k_v_per_g, result.coefficients->k_v_per_g, sizeof report->k_v_per_g);
    memcpy(report->u0_v, result.coefficients->u0_v, sizeof report->u0_v);
    report->max_abs_fit_g = result.check->max_abs_fit_g;
    report->max_abs_check_g = result.check->max_abs_check_g;
    for (uint8_t i = 0; i < report->position_count; i++) {
        report->positions[i].delta_g_g = result.check->delta_g_g[i];
    }
    for (uint8_t m = 0; m < report->mounting_count; m++) {
        report->closure_g[m] = tumble_procedure_closure_g(tumble_navcomp_procedure(navcomp), m);
    }
}

/* As the firmware states them, for the noise that it looks at first. */
static void report_uncertainty(const world_t *world, world_report_t *report)
{
    const tumble_navcomp_t *const navcomp = &world->world.navcomp;
    const tumble_noise_t *noise = NULL;
    tumble_uncertainty_t u;
    tumble_status_t status = tumble_navcomp_uncertainty(navcomp, TUMBLE_ALL_COEFFICIENTS, &u);
    if (status == TUMBLE_E_PORT_BUSY) { /* the noise has been looked at */
        status = tumble_navcomp_uncertainty(navcomp, TUMBLE_ALL_COEFFICIENTS, &u);
    }
    report->has_uncertainty = status == TUMBLE_OK;
    if (report->has_uncertainty) {
        memcpy(report->u_k_v_per_g, u.k_v_per_g, sizeof report->u_k_v_per_g);
        memcpy(report->u_u0_v, u.u0_v, sizeof report->u_u0_v);
    }
    report->has_noise = tumble_navcomp_noise(navcomp, &noise) == TUMBLE_OK;
    if (report->has_noise) {
        report->block_samples = world->config.noise.blocks.block_samples;
        memcpy(report->noise_v, noise->noise_v, sizeof report->noise_v);
        report->declared_v = noise->declared_v;
        report->above = noise->above;
    }
}

static void report_positions(const world_t *world, world_report_t *report)
{
    const tumble_schedule_t *const schedule = &world->config.scenario.schedule;
    const tumble_averaging_t *const averages =
        tumble_procedure_averages(tumble_navcomp_procedure(&world->world.navcomp));
    report->mounting_count = schedule->mounting_count;
    report->position_count = schedule->position_count;
    for (uint8_t i = 0; i < schedule->position_count; i++) {
        world_position_t *const position = &report->positions[i];
        position->mounting = schedule->positions[i].mounting;
        position->number = schedule->positions[i].number;
        position->fit = schedule->positions[i].use == TUMBLE_USE_FIT;
        position->measured = bench_mean(&world->world, i, position->u_v, position->standard_error_v);
        position->samples = position->measured ? averages->averages[i].samples : 0U;
        position->alpha4_rad = world->world.truth.alpha4_rad[i];
    }
}

static void report_inclinations(const world_t *world, world_report_t *report)
{
    const sim_truth_t *const truth = &world->world.truth;
    const tumble_schedule_t *const schedule = &world->config.scenario.schedule;
    report->inclines = bench_inclines(schedule);
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        report->beta_rad[m] = sim_truth_beta_rad(truth, schedule, m);
        report->tau_rad[m] = truth->tau_rad[m];
    }
}

static void report_truth(const world_t *world, world_report_t *report)
{
    const sim_truth_t *const truth = &world->world.truth;
    memcpy(report->true_k_v_per_g, truth->block.k_v_per_g, sizeof report->true_k_v_per_g);
    memcpy(report->true_u0_v, truth->block.u0_v, sizeof report->true_u0_v);
    report->alpha1_rad = truth->alpha1_rad;
    report->alpha2_rad = truth->alpha2_rad;
    memcpy(report->alpha3_rad, truth->alpha3_rad, sizeof report->alpha3_rad);
    memcpy(report->theta_h_rad, truth->theta_h_rad, sizeof report->theta_h_rad);
    memcpy(report->theta_n_rad, truth->theta_n_rad, sizeof report->theta_n_rad);
    report_inclinations(world, report);
    memcpy(report->encoder_rad, truth->encoder_rad, sizeof report->encoder_rad);
    memcpy(report->drift_v, truth->drift_v, sizeof report->drift_v);
    report->fault_count = world->config.scenario.fault_count;
    for (uint32_t i = 0; i < report->fault_count; i++) {
        report->faults[i] =
            (world_fault_t){sim_fault_word(world->config.scenario.faults[i].kind), world->world.script.states[i].times};
    }
}

void world_report(world_t *world, world_report_t *report)
{
    const bench_travel_t travel = bench_travel(&world->world);
    memset(report, 0, sizeof *report);
    report->seed = world->world.seed;
    report->now_us = world->world.clock.now_us;
    report->frames = world->world.bus.load.frames;
    report->end = world->world.end;
    report->at_rest = travel.at_rest;
    report->lowest_deg = travel.lowest_deg;
    report->highest_deg = travel.highest_deg;
    report_procedure(world, report);
    report_question(&world->world.person.question, report);
    report_refusal(world, report);
    report_positions(world, report);
    report_result(world, report);
    report_uncertainty(world, report);
    report_truth(world, report);
}

const char *world_counter(const world_t *world, size_t row, uint64_t *value)
{
    return bench_counter(&world->world, row, value);
}
