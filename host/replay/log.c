#define _POSIX_C_SOURCE 200809L

#include "log.h"

#include "bench/person.h"
#include "replay/replay.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define MAX_LINE 256
#define MAX_FRAMES 100000000U
#define STATE_PDO 0x181U
#define SDO_REQUEST 0x601U
#define HEARTBEAT 0x701U
#define NODE 1U
#define HEARD_BEFORE_US 150000U

/* Reading. */

typedef enum { LINE_FRAME, LINE_FOREIGN, LINE_WRONG } line_kind_t;

static int digit(char c)
{
    const char lower = (char)tolower((unsigned char)c);
    return isdigit((unsigned char)c) ? c - '0' : (lower >= 'a' && lower <= 'f') ? lower - 'a' + 10 : -1;
}

/* "(seconds.microseconds)" */
static bool read_time(const char *text, uint64_t *time_us)
{
    uint64_t seconds = 0;
    uint32_t fraction = 0;
    int length = 0;
    if (sscanf(text, "(%10" SCNu64 ".%6" SCNu32 ")%n", &seconds, &fraction, &length) != 2 || length == 0 ||
        text[length] != '\0' || text[1] == '-' || strlen(strchr(text, '.')) != 8U) {
        return false;
    }
    *time_us = seconds * 1000000U + fraction;
    return true;
}

static line_kind_t read_data(const char *text, tumble_can_frame_t *frame)
{
    const size_t digits = strlen(text);
    if (text[0] == 'R' || text[0] == '#') {
        return LINE_FOREIGN; /* remote, or CAN FD */
    }
    if (digits % 2U != 0U || digits > 2U * TUMBLE_CAN_MAX_BYTES) {
        return LINE_WRONG;
    }
    for (size_t i = 0; i < digits; i += 2U) {
        const int high = digit(text[i]);
        const int low = digit(text[i + 1U]);
        if (high < 0 || low < 0) {
            return LINE_WRONG;
        }
        frame->data[i / 2U] = (uint8_t)(high * 16 + low);
    }
    frame->length = (uint8_t)(digits / 2U);
    return LINE_FRAME;
}

/* "ID#DATA" */
static line_kind_t read_frame(const char *text, tumble_can_frame_t *frame)
{
    const char *const mark = strchr(text, '#');
    const size_t digits = (mark != NULL) ? (size_t)(mark - text) : 0U;
    uint32_t id = 0;
    for (size_t i = 0; i < digits; i++) {
        if (digit(text[i]) < 0) {
            return LINE_WRONG;
        }
        id = id * 16U + (uint32_t)digit(text[i]);
    }
    *frame = (tumble_can_frame_t){.id = (uint16_t)id};
    if (digits == 8U) {
        return LINE_FOREIGN; /* extended, or an error frame */
    }
    return (digits == 3U && id <= TUMBLE_CAN_MAX_ID) ? read_data(mark + 1, frame) : LINE_WRONG;
}

static line_kind_t read_line(char *text, log_line_t *line)
{
    char *rest = NULL;
    const char *const time = strtok_r(text, " \t\r\n", &rest);
    const char *const interface = strtok_r(NULL, " \t\r\n", &rest);
    const char *const frame = strtok_r(NULL, " \t\r\n", &rest);
    if (frame == NULL || interface == NULL || !read_time(time, &line->time_us)) {
        return LINE_WRONG;
    }
    return read_frame(frame, &line->frame);
}

static bool keep(bus_log_t *log, size_t *room, const log_line_t *line)
{
    if (log->count == *room) {
        *room = (*room == 0U) ? 4096U : 2U * *room;
        log_line_t *const larger = (*room <= MAX_FRAMES) ? realloc(log->lines, *room * sizeof *larger) : NULL;
        if (larger == NULL) {
            return false;
        }
        log->lines = larger;
    }
    if (log->count == 0U) {
        log->first_us = line->time_us;
    }
    const uint64_t last_us = (log->count == 0U) ? 0U : log->lines[log->count - 1U].time_us;
    const uint64_t since_us = (line->time_us > log->first_us) ? line->time_us - log->first_us : 0U;
    log->lines[log->count] = *line;
    log->lines[log->count].time_us = (since_us > last_us) ? since_us : last_us;
    log->count++;
    return true;
}

const char *log_read(bus_log_t *log, FILE *file, size_t *line)
{
    char text[MAX_LINE];
    size_t room = 0;
    *log = (bus_log_t){0};
    for (*line = 1; fgets(text, sizeof text, file) != NULL; (*line)++) {
        log_line_t read;
        if (text[strspn(text, " \t\r\n")] == '\0') {
            continue;
        }
        const line_kind_t kind = read_line(text, &read);
        if (kind == LINE_WRONG) {
            return "is not a line of candump -L: (seconds.microseconds) interface ID#DATA";
        }
        log->foreign += (kind == LINE_FOREIGN) ? 1U : 0U;
        if (kind == LINE_FRAME && !keep(log, &room, &read)) {
            return "the log is too long for this machine's memory";
        }
    }
    *line = 0;
    if (ferror(file) != 0) {
        return "cannot be read";
    }
    return (log->count == 0U) ? "holds no frames" : NULL;
}

void log_free(bus_log_t *log)
{
    free(log->lines);
    log->lines = NULL;
    log->count = 0;
}

/* Recording. */

typedef struct {
    uint8_t *bytes;
    size_t count;
    bool carried[TUMBLE_COMMAND_COUNT]; /* kinds of commands that came over the bus */
    tumble_state_t state;               /* of node 1, as last seen */
    tumble_reason_t reason;
    bool started;
} recorder_t;

static void add(recorder_t *recorder, uint64_t time_us, const tumble_can_frame_t *frame)
{
    const replay_record_t record = {time_us, *frame};
    replay_put_record(&record, recorder->bytes + REPLAY_HEADER_BYTES + recorder->count * REPLAY_RECORD_BYTES);
    recorder->count++;
}

static void add_command(recorder_t *recorder, uint64_t time_us, tumble_command_t command)
{
    const tumble_can_frame_t frame = {.id = REPLAY_COMMAND, .length = 2, .data = {(uint8_t)command}};
    if (!recorder->carried[command]) {
        add(recorder, time_us, &frame);
    }
}

/* An SDO request that writes 2002h:2, one byte. */
static bool is_command(const tumble_can_frame_t *frame, tumble_command_t *command)
{
    const uint8_t *const data = frame->data;
    if (frame->id != SDO_REQUEST || frame->length != 8U || (data[0] & 0xE2U) != 0x22U || data[1] != 0x02U ||
        data[2] != 0x20U || data[3] != 2U) {
        return false;
    }
    *command = (tumble_command_t)data[4];
    return data[4] < (uint8_t)TUMBLE_COMMAND_COUNT;
}

static bool is_receive_pdo(const bench_config_t *config, uint16_t id)
{
    bool found = false;
    for (uint8_t i = 0; i < config->profile.receive_count; i++) {
        found = found || (config->profile.receive[i].setup.cob_id & TUMBLE_CAN_MAX_ID) == id;
    }
    return found;
}

static bool is_of_node_1(const bench_config_t *config, uint16_t id)
{
    static const uint16_t OWN[] = {0x000,        0x080 + NODE, STATE_PDO, 0x380 + NODE,
                                   0x580 + NODE, 0x602,        0x603,     0x700 + NODE};
    bool found = is_receive_pdo(config, id);
    for (size_t i = 0; i < sizeof OWN / sizeof OWN[0]; i++) {
        found = found || OWN[i] == id;
    }
    return found;
}

static void note_state(recorder_t *recorder, uint64_t time_us, tumble_state_t state, tumble_reason_t reason)
{
    const tumble_state_t before = recorder->state;
    recorder->state = state;
    const tumble_reason_t reason_before = recorder->reason;
    recorder->reason = reason;
    if (state != TUMBLE_STATE_IDLE && !recorder->started) {
        recorder->started = true;
        add_command(recorder, time_us, TUMBLE_COMMAND_START);
    }
    if (state == before) {
        return;
    }
    if (state == TUMBLE_STATE_ABORT) {
        add_command(recorder, time_us, TUMBLE_COMMAND_ABORT);
    } else if (before == TUMBLE_STATE_WAIT_MOUNTING && state != TUMBLE_STATE_FAULT) {
        add_command(recorder, time_us, TUMBLE_COMMAND_CONFIRM_MOUNTING);
    } else if (before == TUMBLE_STATE_FAULT) {
        add_command(recorder, time_us,
                    bench_person_must_mount(reason_before) ? TUMBLE_COMMAND_CONFIRM_MOUNTING : TUMBLE_COMMAND_RESUME);
    }
}

/* What node 1 sent tells what it had been told. */
static void watch_node_1(recorder_t *recorder, const bench_config_t *config, const log_line_t *line)
{
    const tumble_can_frame_t *const frame = &line->frame;
    if (frame->id == STATE_PDO && frame->length >= 2U) {
        note_state(recorder, line->time_us, (tumble_state_t)frame->data[0], (tumble_reason_t)frame->data[1]);
    } else if (is_receive_pdo(config, frame->id) && recorder->state == TUMBLE_STATE_WAIT_MOUNTING) {
        note_state(recorder, line->time_us, TUMBLE_STATE_MOVE, TUMBLE_REASON_NONE);
    }
}

/* Where node 1 comes to life, with its last boot-up message. Its controller listens a little before that message is on
 * the bus (an emulator takes up to 0.1 s), and a heartbeat heard then makes it begin: better one too many than one too
 * few. Without such a message it was there all the time. */
static size_t find_beginning(const bus_log_t *log)
{
    size_t at = 0;
    for (size_t i = 0; i < log->count; i++) {
        const tumble_can_frame_t *const frame = &log->lines[i].frame;
        if (frame->id == HEARTBEAT && frame->length == 1U && frame->data[0] == 0U) {
            at = i;
        }
    }
    const uint64_t boot_us = log->lines[at].time_us;
    while (at > 0U && log->lines[at - 1U].time_us + HEARD_BEFORE_US >= boot_us) {
        at--;
    }
    return at;
}

static void note_carried(recorder_t *recorder, const bus_log_t *log, size_t from)
{
    for (size_t i = from; i < log->count; i++) {
        tumble_command_t command;
        if (is_command(&log->lines[i].frame, &command)) {
            recorder->carried[command] = true;
        }
    }
}

/* Started at once, unless it is seen to be idle. */
static void start(recorder_t *recorder, const bus_log_t *log, size_t from)
{
    size_t i = from;
    while (i < log->count && log->lines[i].frame.id != STATE_PDO) {
        i++;
    }
    if (i == log->count || log->lines[i].frame.data[0] != (uint8_t)TUMBLE_STATE_IDLE) {
        recorder->started = true;
        add_command(recorder, 0, TUMBLE_COMMAND_START);
    }
}

uint8_t *log_recording(const bus_log_t *log, const bench_config_t *config, size_t *size)
{
    const size_t most = 2U * log->count + 1U; /* at most one command a frame */
    recorder_t recorder = {.bytes = malloc(REPLAY_HEADER_BYTES + most * REPLAY_RECORD_BYTES)};
    if (recorder.bytes == NULL || most > UINT32_MAX) {
        free(recorder.bytes);
        return NULL;
    }
    const size_t from = find_beginning(log);
    note_carried(&recorder, log, from);
    start(&recorder, log, from);
    for (size_t i = from; i < log->count; i++) {
        log_line_t line = log->lines[i];
        line.time_us -= log->lines[from].time_us;
        if (is_of_node_1(config, line.frame.id)) {
            watch_node_1(&recorder, config, &line);
        } else {
            add(&recorder, line.time_us, &line.frame);
        }
    }
    replay_put_header(recorder.bytes, (uint32_t)recorder.count);
    *size = REPLAY_HEADER_BYTES + recorder.count * REPLAY_RECORD_BYTES;
    return recorder.bytes;
}
