#include "world/hostile_event.h"

#include "canopen/cia402.h"
#include "world/hostile_watch.h"

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

const char *bench_broken_sentence(bench_broken_t kind)
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
