#include "node_log.h"

#include "arguments.h"
#include "canopen/sdo.h"
#include "canopen/sdo_frame.h"
#include "core/bytes.h"
#include "event_log.h"
#include "world/report.h"

#include <unistd.h>

#define NODE 1U
#define COMMAND_OBJECT 0x2002U
#define COMMAND 2U

void node_log_ready(const node_options_t *options)
{
    if (event_log_is_on() || (!options->start && options->progress_fd != STDERR_FILENO)) {
        event_log_start("tumble-node", STDERR_FILENO);
    }
    const char *const memory = (options->nv != NULL) ? options->nv : "none";
    event_log_always(EVENT_LOG_NOTICE, "ready",
                     EVENT_FIELDS(EVENT_WHOLE("node", NODE), EVENT_TEXT("interface", options->interface),
                                  EVENT_TEXT("memory", memory)),
                     "node %u on %s, memory %s; %s", NODE, options->interface, memory,
                     options->start ? "begins a calibration" : "waits for commands");
}

/* Commands. */

static bool is_of_command(const tumble_can_frame_t *frame)
{
    return tumble_get_u16(&frame->data[1]) == COMMAND_OBJECT && frame->data[3] == COMMAND;
}

/* A client writes: the value is in the frame itself, or in the segment that follows. */
static void hear_request(node_log_t *log, const tumble_can_frame_t *frame, bool is_second)
{
    const uint8_t service = frame->data[0] & TUMBLE_SDO_COMMAND_MASK;
    if (service == TUMBLE_SDO_DOWNLOAD_SEGMENT_REQUEST && log->in_segments[is_second]) {
        log->asked_by[is_second] = frame->data[1];
    }
    const bool begins = service == TUMBLE_SDO_DOWNLOAD_REQUEST && is_of_command(frame);
    const bool at_once = (frame->data[0] & TUMBLE_SDO_E) != 0U;
    if (begins && at_once) {
        log->asked_by[is_second] = frame->data[4];
    }
    log->in_segments[is_second] = begins && !at_once;
}

void node_log_frame(node_log_t *log, const tumble_can_frame_t *frame)
{
    const unsigned kind = frame->id - NODE;
    const bool is_second = kind == TUMBLE_SDO_SECOND_REQUEST_ID || kind == TUMBLE_SDO_SECOND_RESPONSE_ID;
    if (kind == TUMBLE_SDO_REQUEST_ID || kind == TUMBLE_SDO_SECOND_REQUEST_ID) {
        hear_request(log, frame, is_second);
    } else if ((kind == TUMBLE_SDO_RESPONSE_ID || kind == TUMBLE_SDO_SECOND_RESPONSE_ID) &&
               frame->data[0] == TUMBLE_SDO_ABORT && is_of_command(frame)) {
        log->asked = log->asked_by[is_second];
    }
}

void node_log_refused(const node_log_t *log, const tumble_progress_t *now, uint8_t rung)
{
    const char *const name = tumble_command_name((tumble_command_t)log->asked);
    const char *const state = tumble_state_name(now->state);
    const bool stopping = rung != (uint8_t)TUMBLE_RUNG_NONE && rung != (uint8_t)TUMBLE_RUNG_UNCONFIRMED;
    const bool waits = stopping && log->asked == (uint8_t)TUMBLE_COMMAND_CLEAR_FAULT;
    event_log_tell(EVENT_LOG_WARNING, "refused",
                   EVENT_FIELDS(EVENT_TEXT("command", name), EVENT_WHOLE("command_number", log->asked),
                                EVENT_TEXT("state", state), EVENT_WHOLE("stop_rung", rung)),
                   "refused %s (%u) in %s%s", name, (unsigned)log->asked, state,
                   waits ? ": the axis has been told to stop and is not seen at rest yet" : "");
}

/* After a step. */

static void log_level(node_log_t *log, const tumble_navcomp_t *navcomp)
{
    const bool is_open = tumble_service_is_open(navcomp);
    if (is_open && !log->is_unlocked) {
        event_log_tell(EVENT_LOG_NOTICE, "unlock", EVENT_FIELDS(EVENT_WHOLE("seconds", TUMBLE_SERVICE_S)),
                       "the service level is open, for %u s", TUMBLE_SERVICE_S);
    } else if (!is_open && log->is_unlocked) {
        event_log_tell(EVENT_LOG_NOTICE, "lock", NULL, "the service level is over");
    }
    log->is_unlocked = is_open;
}

/* In a run its fault tells the reason; what a drive has refused, and what goes wrong between runs, is told here. */
static void log_stand(node_log_t *log, const tumble_navcomp_t *navcomp)
{
    static const char *const FAULTS[] = {
        "none",        "the drive's own",    "stall",    "heartbeat",       "homing", "protocol", "power",
        "not reached", "stop not confirmed", "position", "foreign command",
    };
    const uint8_t fault = (uint8_t)navcomp->stand.kind->fault(navcomp->stand.self);
    if (fault == log->stand_fault) {
        return;
    }
    log->stand_fault = fault;
    const char *const name = (fault < sizeof FAULTS / sizeof FAULTS[0]) ? FAULTS[fault] : "unknown";
    char refused[BENCH_REFUSAL_BYTES] = "";
    const tumble_stand_refusal_t refusal = tumble_navcomp_drive_refusal(navcomp);
    if (refusal.index != 0U) {
        bench_refusal_sentence(&refusal, refused, sizeof refused);
    }
    event_log_tell((fault == 0U) ? EVENT_LOG_NOTICE : EVENT_LOG_ERROR, "stand",
                   EVENT_FIELDS(EVENT_WHOLE("stand_fault", fault), EVENT_TEXT("sentence", name),
                                EVENT_TEXT((*refused != '\0') ? "refusal" : NULL, refused)),
                   "fault of the stand: %s%s%s", name, (*refused != '\0') ? ": " : "", refused);
}

void node_log_update(node_log_t *log, const tumble_navcomp_t *navcomp, const tumble_keeper_t *keeper,
                     const can_socket_t *can)
{
    tumble_sets_state_t state;
    if (!event_log_is_on()) {
        return;
    }
    link_log_update(&log->link, can);
    log_level(log, navcomp);
    log_stand(log, navcomp);
    if (keeper == NULL) {
        return;
    }
    tumble_keeper_state(keeper, &state);
    run_log_sets(&log->sets, &state);
}

void node_log_unread(bool *told, uint32_t lost, const char *output)
{
    if (lost > 0U && !*told) {
        *told = true;
        event_log_tell(EVENT_LOG_WARNING, "unread", EVENT_FIELDS(EVENT_TEXT("output", output)),
                       "nobody reads %s, lines of it are left out", output);
    }
}

/* The end. */

int node_log_unwritten(const char *folder, const char *why)
{
    if (!event_log_is_on()) {
        return arguments_fail(folder, why, BENCH_EXIT_FAULT);
    }
    event_log_tell(EVENT_LOG_ERROR, "unwritten", EVENT_FIELDS(EVENT_TEXT("folder", folder), EVENT_TEXT("why", why)),
                   "%s: %s", folder, why);
    return BENCH_EXIT_FAULT;
}

void node_log_end(const bench_world_t *world, int code, const tumble_progress_t *cause)
{
    const event_log_level_t well = (cause->reason == TUMBLE_REASON_NONE) ? EVENT_LOG_NOTICE : EVENT_LOG_WARNING;
    const event_log_level_t level = (code == BENCH_EXIT_FAULT) ? EVENT_LOG_ERROR : well;
    const char *const end = bench_end_name(world->end);
    if (cause->reason == TUMBLE_REASON_NONE) {
        event_log_end(level, EVENT_FIELDS(EVENT_TEXT("end", end), EVENT_WHOLE("exit", (uint64_t)code)),
                      "ends with exit code %d (%s)", code, end);
        return;
    }
    const char *const reason = tumble_reason_name(cause->reason);
    const char *const failed_in = tumble_state_name(cause->failed_in);
    const char *const sentence = tumble_reason_sentence(cause->reason);
    const char *const remedy = tumble_reason_remedy(cause->reason);
    event_log_end(level,
                  EVENT_FIELDS(EVENT_TEXT("end", end), EVENT_WHOLE("exit", (uint64_t)code),
                               EVENT_TEXT("state", failed_in), EVENT_WHOLE("mounting", cause->mounting),
                               EVENT_WHOLE("position", cause->position), EVENT_TEXT("cause", reason),
                               EVENT_WHOLE("cause_number", (uint64_t)cause->reason), EVENT_TEXT("sentence", sentence),
                               EVENT_TEXT("remedy", remedy), EVENT_WHOLE("drive_code", cause->drive_code)),
                  "ends with exit code %d (%s); cause, at position %u.%u: %s in %s, %s. Remedy: %s", code, end,
                  cause->mounting, cause->position, reason, failed_in, sentence, remedy);
}
