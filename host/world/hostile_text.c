#include "world/hostile.h"

#include "canopen/cia402.h"
#include "tumble/core.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define SET_POINT_ID 0x202U
#define DRIVE_SDO_ID 0x602U

#define WORD(name, word, ...) word,
#define SENTENCE(name, word, sentence) sentence,

const char *bench_hostile_name(bench_hostile_t kind)
{
    static const char *const NAMES[] = {BENCH_HOSTILE_LIST(WORD)};
    return NAMES[kind];
}

const char *bench_broken_name(bench_broken_t kind)
{
    static const char *const NAMES[] = {BENCH_VIOLATION_LIST(WORD)};
    return NAMES[kind];
}

static const char *broken_sentence(bench_broken_t kind)
{
    static const char *const SENTENCES[] = {BENCH_VIOLATION_LIST(SENTENCE)};
    return SENTENCES[kind];
}

const char *bench_excuse_name(bench_excuse_t excuse)
{
    static const char *const NAMES[] = {BENCH_EXCUSE_LIST(WORD)};
    return NAMES[excuse];
}

static bool is_download(const tumble_can_frame_t *frame)
{
    return frame->id == DRIVE_SDO_ID && frame->length > 0U && (frame->data[0] & 0xE0U) <= 0x20U;
}

static bool is_of_motion(const tumble_can_frame_t *frame)
{
    const uint16_t index = (uint16_t)(frame->data[1] | frame->data[2] << 8);
    return index == TUMBLE_402_CONTROLWORD || index == TUMBLE_402_TARGET_POSITION;
}

/* What the navigation computer reads back before a motion. */
static bool is_read_back(const tumble_can_frame_t *frame)
{
    const uint16_t index = (uint16_t)(frame->data[1] | frame->data[2] << 8);
    return index == TUMBLE_402_PROFILE_VELOCITY || index == TUMBLE_402_PROFILE_ACCELERATION ||
           index == TUMBLE_402_SOFTWARE_LIMIT;
}

static bool hits(const sim_fault_t *fault, uint16_t id)
{
    return (id & fault->mask) == (fault->id & fault->mask);
}

bool bench_event_rewrites_drive(const bench_event_t *event)
{
    if (event->kind == BENCH_HOSTILE_FAULT) {
        return event->fault.kind == SIM_FAULT_FRAME_CORRUPT && hits(&event->fault, DRIVE_SDO_ID);
    }
    const bool is_frame = event->kind >= BENCH_HOSTILE_SDO_NAVCOMP;
    return is_frame && is_download(&event->frame) &&
           !((event->frame.data[0] & 0xE0U) == 0x20U && (is_of_motion(&event->frame) || is_read_back(&event->frame)));
}

bool bench_event_commands_drive(const bench_event_t *event)
{
    const sim_fault_kind_t kind = event->fault.kind;
    if (event->kind == BENCH_HOSTILE_FAULT) {
        return (kind == SIM_FAULT_FRAME_CORRUPT || kind == SIM_FAULT_FRAME_DELAY || kind == SIM_FAULT_FRAME_REORDER) &&
               hits(&event->fault, SET_POINT_ID);
    }
    return event->kind == BENCH_HOSTILE_SET_POINT || event->kind == BENCH_HOSTILE_SDO_SET_POINT ||
           (event->kind >= BENCH_HOSTILE_SDO_NAVCOMP &&
            (event->frame.id == SET_POINT_ID || (is_download(&event->frame) && is_of_motion(&event->frame))));
}

static void add(bench_text_t *text, const char *format, ...)
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

bench_text_t bench_text_world(const bench_plan_t *plan)
{
    bench_text_t text = {""};
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

static void add_moment(bench_text_t *text, const bench_moment_t *moment)
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

static void add_fault(bench_text_t *text, const sim_fault_t *fault)
{
    static const char *const PHASES[] = {"mount", "home", "move", "settle", "average"};
    if (fault->at_time) {
        add(text, "%10.6f s  ", fault->time_s);
    } else {
        add(text, "at %u.%u %s, plus %.3f s: ", fault->mounting, fault->position, PHASES[fault->phase], fault->delay_s);
    }
    add(text, "fault %s, value %g, count %d, channels %u, ", sim_fault_word(fault->kind), fault->value,
        (int)fault->count, fault->channels);
    if (fault->kind >= SIM_FAULT_FRAME_DROP) {
        add(text, "id %03Xh, mask %03Xh, probability %.3f, ", fault->id, fault->mask, fault->probability);
    }
    add(text, (fault->duration_s > 0.0) ? "for %.3f s" : "for good", fault->duration_s);
}

static void add_command(bench_text_t *text, const bench_event_t *event)
{
    add(text, "%s", short_name(tumble_command_name(event->command), "TUMBLE_COMMAND_"));
    if (event->command == TUMBLE_COMMAND_TURN_AXIS) {
        add(text, " to %.3f deg", event->angle_deg);
    } else if (event->argument != 0U) {
        add(text, " %u", event->argument);
    }
    add(text, event->by_host ? ", by the board" : ", over CAN");
}

static void add_frame(bench_text_t *text, const bench_event_t *event)
{
    const tumble_can_frame_t *const frame = &event->frame;
    add(text, "%s %03X#", bench_hostile_name(event->kind), frame->id);
    for (uint8_t i = 0; i < frame->length; i++) {
        add(text, "%02X", frame->data[i]);
    }
    if ((frame->id & 0x780U) == 0x600U && frame->length == 8U && (frame->data[0] & 0xE0U) == 0x20U) {
        add(text, " (write %02X%02Xh:%u = ", frame->data[2], frame->data[1], frame->data[3]);
        add(text, "%02X%02X%02X%02Xh)", frame->data[7], frame->data[6], frame->data[5], frame->data[4]);
    }
}

bench_text_t bench_text_event(const bench_event_t *event)
{
    bench_text_t text = {""};
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

bench_text_t bench_text_violation(const bench_violation_t *violation)
{
    static const char *const COEFFICIENTS[TUMBLE_COEFFICIENTS] = {"K_xx", "K_xy", "K_xz", "K_yx", "K_yy", "K_yz",
                                                                  "K_zx", "K_zy", "K_zz", "U0_x", "U0_y", "U0_z"};
    bench_text_t text = {""};
    add(&text, "%s: %s, ", bench_broken_name(violation->kind), broken_sentence(violation->kind));
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
