#include "world/lives.h"

#include "world/hostile.h"
#include "world/readout.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TEXT_BYTES 240

typedef struct {
    char text[TEXT_BYTES];
} text_t;

struct lives {
    bench_plan_t plan;
    bench_life_t life;
    text_t text;
    const char *undrawn; /* why there is no plan */
};

#define WORD(name, word, ...) word,
#define SENTENCE(name, word, sentence) sentence,
static const char *const VIOLATIONS[] = {BENCH_VIOLATION_LIST(WORD)};
static const char *const SENTENCES[] = {BENCH_VIOLATION_LIST(SENTENCE)};
static const char *const EVENTS[] = {BENCH_HOSTILE_LIST(WORD)};
static const char *const EXCUSES[] = {BENCH_EXCUSE_LIST(WORD)};
static const char *const FAULTS[] = {SIM_FAULT_LIST(WORD)};
#undef WORD
#undef SENTENCE

lives_t *lives_new(void)
{
    return calloc(1, sizeof(lives_t));
}

void lives_free(lives_t *lives)
{
    free(lives);
}

/* Of the plan's events these alone. */
static void keep_events(bench_plan_t *plan, const uint32_t *events, size_t count)
{
    uint32_t kept = 0;
    for (size_t i = 0; i < count && events[i] < plan->count; i++) {
        plan->events[kept++] = plan->events[events[i]];
    }
    plan->count = kept;
}

const char *lives_live(lives_t *lives, uint64_t seed, const uint32_t *events, size_t count)
{
    lives->undrawn = bench_plan_draw(&lives->plan, seed);
    if (events != NULL) {
        keep_events(&lives->plan, events, count);
    }
    if (lives->undrawn != NULL) {
        memset(&lives->life, 0, sizeof lives->life);
        lives->life.watch.violation.kind = BENCH_BROKEN_BENCH;
    } else {
        bench_life_run(&lives->life, &lives->plan);
    }
    const bench_broken_t kind = lives->life.watch.violation.kind;
    return (kind == BENCH_HOLDS) ? NULL : VIOLATIONS[kind];
}

/* In words: its world, its events, and what was violated, a line each. */

static void add(text_t *text, const char *format, ...)
{
    va_list arguments;
    const size_t used = strlen(text->text);
    va_start(arguments, format);
    (void)vsnprintf(&text->text[used], sizeof text->text - used, format, arguments);
    va_end(arguments);
}

/* Without what all names of a list begin with. */
static const char *short_name(const char *name, const char *prefix)
{
    const size_t length = strlen(prefix);
    return (strncmp(name, prefix, length) == 0) ? name + length : name;
}

static const char *state_name(uint32_t state)
{
    return short_name(tumble_state_name((tumble_state_t)state), "TUMBLE_STATE_");
}

static text_t world_in_words(const bench_plan_t *plan)
{
    text_t text = {""};
    const bench_config_t *const config = &plan->config;
    const sim_drive_config_t *const drive = &config->scenario.drive;
    add(&text, "drive: %g deg/s, sign %d, ", drive->speed_deg_s, (int)drive->sign);
    add(&text, (drive->wrap_counts > 0U) ? "wraps at %u, " : "does not wrap, ", (unsigned)drive->wrap_counts);
    add(&text, "takes the %s target, stops by %s", drive->latches_stale_target ? "stale" : "new",
        (config->profile.stop == TUMBLE_STOP_BY_HALT) ? "halt" : "quick stop");
    add(&text, "; memory: erases in %u us, %s; attendant: mends %u%s", (unsigned)plan->erase_us,
        plan->has_set ? "holds a set" : "blank", (unsigned)plan->attendant.mends,
        plan->attendant.resumes ? ", resumes" : "");
    return text;
}

static void add_moment(text_t *text, const bench_moment_t *moment)
{
    add(text, "%10.6f s  ", 1e-6 * (double)moment->at_us);
    if (moment->states == 0U && !moment->writing) {
        return;
    }
    add(text, "or later");
    for (uint32_t s = 0; s < TUMBLE_STATE_COUNT; s++) {
        if ((moment->states >> s & 1U) != 0U) {
            add(text, ", in %s", state_name(s));
        }
    }
    add(text, "%s, plus %.6f s: ", moment->writing ? ", while the memory is written" : "",
        1e-6 * (double)moment->delay_us);
}

static void add_fault(text_t *text, const sim_fault_t *fault)
{
    static const char *const PHASES[] = {"mount", "home", "move", "settle", "average"};
    if (fault->at_time) {
        add(text, "%10.6f s  ", fault->time_s);
    } else {
        add(text, "at %u.%u %s, plus %.3f s: ", fault->mounting, fault->position, PHASES[fault->phase], fault->delay_s);
    }
    add(text, "fault %s, value %g, count %d, channels %u, ", FAULTS[fault->kind], fault->value, (int)fault->count,
        fault->channels);
    if (fault->kind >= SIM_FAULT_FRAME_DROP) {
        add(text, "id %03Xh, mask %03Xh, probability %.3f, ", fault->id, fault->mask, fault->probability);
    }
    add(text, (fault->duration_s > 0.0) ? "for %.3f s" : "for good", fault->duration_s);
}

static void add_command(text_t *text, const bench_event_t *event)
{
    add(text, "%s", short_name(tumble_command_name(event->command), "TUMBLE_COMMAND_"));
    if (event->command == TUMBLE_COMMAND_TURN_AXIS) {
        add(text, " to %.3f deg", event->angle_deg);
    } else if (event->argument != 0U) {
        add(text, " %u", event->argument);
    }
    add(text, event->by_host ? ", by the board" : ", over CAN");
}

static void add_frame(text_t *text, const bench_event_t *event)
{
    const tumble_can_frame_t *const frame = &event->frame;
    add(text, "%s %03X#", EVENTS[event->kind], frame->id);
    for (uint8_t i = 0; i < frame->length; i++) {
        add(text, "%02X", frame->data[i]);
    }
    if ((frame->id & 0x780U) == 0x600U && frame->length == 8U && (frame->data[0] & 0xE0U) == 0x20U) {
        add(text, " (write %02X%02Xh:%u = ", frame->data[2], frame->data[1], frame->data[3]);
        add(text, "%02X%02X%02X%02Xh)", frame->data[7], frame->data[6], frame->data[5], frame->data[4]);
    }
}

static text_t event_in_words(const bench_event_t *event)
{
    text_t text = {""};
    if (event->kind == BENCH_HOSTILE_FAULT) {
        add_fault(&text, &event->fault);
        return text;
    }
    add_moment(&text, &event->moment);
    switch (event->kind) {
    case BENCH_HOSTILE_COMMAND:
        add_command(&text, event);
        break;
    case BENCH_HOSTILE_CUT:
        add(&text, "power off for %.6f s, %u bits flipped", 1e-6 * (double)event->off_us, (unsigned)event->count);
        break;
    case BENCH_HOSTILE_SET_POINT:
    case BENCH_HOSTILE_SDO_SET_POINT:
        add(&text, "forged set-point %s: %.3f deg%s", (event->kind == BENCH_HOSTILE_SET_POINT) ? "202h" : "602h",
            event->angle_deg, event->relative ? " off the target" : "");
        break;
    case BENCH_HOSTILE_POSITION:
    case BENCH_HOSTILE_NEAR_POSITION:
        add(&text, "%u forged positions 182h, each %.3f deg further%s", (unsigned)event->count, event->angle_deg,
            (event->kind == BENCH_HOSTILE_POSITION) ? "" : ", 0.3 ms apart");
        break;
    case BENCH_HOSTILE_SAMPLE:
    case BENCH_HOSTILE_SPOILT_SAMPLE:
        add(&text, "forged sample, %d counts off, checksum %s", (int)event->counts,
            (event->kind == BENCH_HOSTILE_SAMPLE) ? "good" : "wrong");
        break;
    default:
        add_frame(&text, event);
        break;
    }
    return text;
}

const char *lives_line(lives_t *lives, uint32_t number)
{
    if (lives->undrawn != NULL || number > lives->plan.count) {
        return NULL;
    }
    lives->text = (number == 0U) ? world_in_words(&lives->plan) : event_in_words(&lives->plan.events[number - 1U]);
    return lives->text.text;
}

static text_t violation_in_words(const bench_violation_t *violation)
{
    static const char *const COEFFICIENTS[TUMBLE_COEFFICIENTS] = {"K_xx", "K_xy", "K_xz", "K_yx", "K_yy", "K_yz",
                                                                  "K_zx", "K_zy", "K_zz", "U0_x", "U0_y", "U0_z"};
    text_t text = {""};
    add(&text, "%s: %s, ", VIOLATIONS[violation->kind], SENTENCES[violation->kind]);
    switch (violation->kind) {
    case BENCH_BROKEN_TRUTH:
        add(&text, "%s by %.1f u", COEFFICIENTS[violation->what], violation->value);
        break;
    case BENCH_BROKEN_LEVEL:
    case BENCH_BROKEN_FINITE:
        add(&text, "%04Xh:%u", violation->what >> 8, violation->what & 0xFFU);
        break;
    case BENCH_BROKEN_DECAYED:
        add(&text, "at %u", violation->what);
        break;
    case BENCH_BROKEN_PROPOSAL:
        add(&text, "%08X", violation->what);
        break;
    case BENCH_BROKEN_MEAN:
        add(&text, "of row %u of the schedule, sample %.0f", violation->what, violation->value);
        break;
    case BENCH_BROKEN_RUN:
    case BENCH_BROKEN_LOST:
    case BENCH_BROKEN_COUNTER:
        add(&text, "from %u to %.0f", violation->what, violation->value);
        break;
    default:
        add(&text, "%.1f deg, in %s", violation->value, state_name(violation->what));
        break;
    }
    add(&text, ", at %.6f s", 1e-6 * (double)violation->at_us);
    return text;
}
const char *lives_violation(lives_t *lives, uint64_t *at_us)
{
    *at_us = lives->life.watch.violation.at_us;
    lives->text = violation_in_words(&lives->life.watch.violation);
    return (lives->undrawn != NULL) ? lives->undrawn : lives->text.text;
}

/* What is counted, in groups. */

typedef enum { OF_VIOLATIONS, OF_FAULTS, OF_EVENTS, OF_EXCUSES, OF_ENDS, OF_SETS, OF_ALL } of_t;

static uint64_t counted(const lives_t *lives, of_t of, tumble_state_t end, size_t row)
{
    const bench_life_t *const life = &lives->life;
    const uint64_t sets[] = {life->counts.committed, life->counts.judged, life->counts.held};
    const uint64_t all[] = {life->counts.flips, life->counts.homings, life->world.clock.now_us,
                            life->world.bus.load.frames, life->world.steps};
    switch (of) {
    case OF_VIOLATIONS:
        return (life->watch.violation.kind == (bench_broken_t)(row + 1U)) ? 1U : 0U;
    case OF_FAULTS:
        return life->counts.faults[row];
    case OF_EVENTS:
        return life->counts.events[row];
    case OF_EXCUSES:
        return life->watch.excuses >> row & 1U;
    case OF_ENDS:
        return life->counts.ends[end][row];
    case OF_SETS:
        return sets[row];
    default:
        return all[row];
    }
}

static const char *const SETS[] = {"committed", "judged", "held"};
static const char *const ALL[] = {"flipped_bits", "homings", "virtual_us", "frames", "steps"};

static const struct {
    const char *group;
    const char *const *names; /* null: of reasons */
    size_t rows;
    of_t of;
    tumble_state_t end;
} GROUPS[] = {
    {"violations", VIOLATIONS + 1, (size_t)BENCH_VIOLATION_KINDS - 1U, OF_VIOLATIONS, 0},
    {"faults", FAULTS, SIM_FAULT_KINDS, OF_FAULTS, 0},
    {"events", EVENTS, BENCH_HOSTILE_KINDS, OF_EVENTS, 0},
    {"excuses", EXCUSES, BENCH_EXCUSES, OF_EXCUSES, 0},
    {"TUMBLE_STATE_IDLE", NULL, TUMBLE_REASON_COUNT, OF_ENDS, TUMBLE_STATE_IDLE},
    {"TUMBLE_STATE_DONE", NULL, TUMBLE_REASON_COUNT, OF_ENDS, TUMBLE_STATE_DONE},
    {"TUMBLE_STATE_FAULT", NULL, TUMBLE_REASON_COUNT, OF_ENDS, TUMBLE_STATE_FAULT},
    {"TUMBLE_STATE_ABORT", NULL, TUMBLE_REASON_COUNT, OF_ENDS, TUMBLE_STATE_ABORT},
    {"sets", SETS, 3, OF_SETS, 0},
    {"all", ALL, 5, OF_ALL, 0},
};

const char *lives_count(const lives_t *lives, size_t row, const char **name, uint64_t *value)
{
    for (size_t g = 0; g < sizeof GROUPS / sizeof GROUPS[0]; g++) {
        if (row < GROUPS[g].rows) {
            *name = (GROUPS[g].names != NULL) ? GROUPS[g].names[row] : tumble_reason_name((tumble_reason_t)row);
            *value = counted(lives, GROUPS[g].of, GROUPS[g].end, row);
            return GROUPS[g].group;
        }
        row -= GROUPS[g].rows;
    }
    return NULL;
}

bool lives_travel(const lives_t *lives, bool *at_rest, double *lowest_deg, double *highest_deg)
{
    if (lives->life.world.clock.now_us == 0U) {
        return false;
    }
    const bench_travel_t travel = bench_travel(&lives->life.world);
    *at_rest = travel.at_rest;
    *lowest_deg = travel.lowest_deg;
    *highest_deg = travel.highest_deg;
    return true;
}
