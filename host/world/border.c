#include "world/border.h"

#include "navcomp/keeper.h"
#include "navcomp/uncertainty.h"
#include "world/config_file.h"
#include "world/report.h"
#include "world/world_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_LINE 1024

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
#define WORD(name, of, word, sentence) word,
#define SENTENCE(name, of, word, sentence) sentence,
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
        bench_operator_follow(&world->world, &world->world.operator.question);
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
    if (bench_is_tenth(&world->world, taken.ordinal)) {
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
    const tumble_status_t status = bench_operator_answer(&world->world, answer, argument);
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

double world_step_v(const world_t *world)
{
    return world->config.procedure.v_per_count;
}

bool world_position(const world_t *world, size_t index, uint8_t *mounting, uint8_t *number)
{
    const tumble_schedule_t *const schedule = &world->config.scenario.schedule;
    if (index >= schedule->position_count) {
        return false;
    }
    *mounting = schedule->positions[index].mounting;
    *number = schedule->positions[index].number;
    return true;
}

/* How it stands. */

const char *world_document(world_t *world)
{
    const bench_world_t *const own = &world->world;
    bench_json_t json = {.text = world->text, .room = sizeof world->text};
    bench_json_open(&json, NULL, '{');
    bench_json_text(&json, "schema", "tumble.bench/1");
    bench_report_run(own, &json);
    bench_json_open(&json, "counters", '{');
    bench_report_counters(own, &json);
    bench_report_bus_counters(own, &json);
    bench_json_close(&json, '}');
    bench_report_truth(own, &json);
    bench_json_number(&json, "virtual_s", (double)own->clock.now_us * 1e-6);
    bench_report_table(own, &json);
    bench_json_close(&json, '}');
    return world->text;
}

const char *world_event(world_t *world, unsigned happened)
{
    const bench_world_t *const own = &world->world;
    const bench_question_t *const question = &own->operator.question;
    bench_json_t json = {.text = world->text, .room = sizeof world->text};
    tumble_navcomp_progress_t progress;
    switch (happened) {
    case WORLD_CHANGE:
        bench_progress_state(own, &json);
        return world->text;
    case WORLD_AVERAGED:
        tumble_navcomp_progress(&own->navcomp, &progress);
        bench_progress_average(own, progress.run.samples, &json);
        return world->text;
    case WORLD_QUESTION:
        bench_progress_question(own, question, &json);
        return (question->kind != BENCH_QUESTION_NONE) ? world->text : NULL;
    default:
        return bench_progress_angle(own, &json) ? world->text : NULL;
    }
}
