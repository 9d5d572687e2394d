#include "replay.h"

#include <string.h>

#define MAGIC "TUMBLELG"
#define MAGIC_BYTES 8U
#define MOST_STEPS 1000U  /* at one moment: more would be a firmware that never waits */
#define AFTER_US 1000000U /* what it gets after the last frame */

static void put(uint8_t *bytes, uint64_t value, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        bytes[i] = (uint8_t)(value >> (8U * i));
    }
}

static uint64_t get(const uint8_t *bytes, uint32_t count)
{
    uint64_t value = 0;
    for (uint32_t i = 0; i < count; i++) {
        value |= (uint64_t)bytes[i] << (8U * i);
    }
    return value;
}

void replay_put_record(const replay_record_t *record, uint8_t bytes[REPLAY_RECORD_BYTES])
{
    put(&bytes[0], record->time_us, 8);
    put(&bytes[8], record->frame.id, 2);
    bytes[10] = record->frame.length;
    bytes[11] = 0;
    (void)memcpy(&bytes[12], record->frame.data, TUMBLE_CAN_MAX_BYTES);
}

void replay_get_record(const uint8_t bytes[REPLAY_RECORD_BYTES], replay_record_t *record)
{
    record->time_us = get(&bytes[0], 8);
    record->frame.id = (uint16_t)get(&bytes[8], 2);
    record->frame.length = bytes[10];
    (void)memcpy(record->frame.data, &bytes[12], TUMBLE_CAN_MAX_BYTES);
}

static const uint8_t *record_at(const uint8_t *recording, uint32_t number)
{
    return &recording[REPLAY_HEADER_BYTES + ((size_t)number * REPLAY_RECORD_BYTES)];
}

static uint32_t checksum(const uint8_t *recording, uint32_t count)
{
    const uint8_t *const bytes = record_at(recording, 0);
    uint32_t sum = 2166136261U;
    for (size_t i = 0; i < ((size_t)count * REPLAY_RECORD_BYTES); i++) {
        sum = (sum ^ bytes[i]) * 16777619U;
    }
    return sum;
}

void replay_put_header(uint8_t *recording, uint32_t count)
{
    (void)memcpy(recording, MAGIC, MAGIC_BYTES);
    put(&recording[8], count, 4);
    put(&recording[12], checksum(recording, count), 4);
}

/* The port. */

static uint64_t now_us(void *context)
{
    return ((const replay_t *)context)->now_us;
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    replay_t *replay = context;
    (void)frame;
    replay->sent++;
    return TUMBLE_OK;
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    replay_t *replay = context;
    if (!replay->waiting) {
        return TUMBLE_E_PORT_EMPTY;
    }
    replay->waiting = false;
    *frame = replay->frame;
    return TUMBLE_OK;
}

static bool times_never_fall(const uint8_t *recording, uint32_t count)
{
    uint64_t last_us = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t next_us = get(record_at(recording, i), 8);
        if (next_us < last_us) {
            return false;
        }
        last_us = next_us;
    }
    return true;
}

tumble_status_t replay_open(replay_t *replay, const uint8_t *recording, size_t size)
{
    if (size < REPLAY_HEADER_BYTES) {
        return TUMBLE_E_FRAME;
    }
    const uint32_t count = (uint32_t)get(&recording[8], 4);
    for (uint32_t i = 0; i < MAGIC_BYTES; i++) {
        if (recording[i] != (uint8_t)MAGIC[i]) {
            return TUMBLE_E_FRAME;
        }
    }
    if (((size - REPLAY_HEADER_BYTES) / REPLAY_RECORD_BYTES) < count) {
        return TUMBLE_E_FRAME;
    }
    if (checksum(recording, count) != (uint32_t)get(&recording[12], 4)) {
        return TUMBLE_E_CRC;
    }
    if (!times_never_fall(recording, count)) {
        return TUMBLE_E_FRAME;
    }
    *replay = (replay_t){.recording = recording, .count = count};
    replay->port =
        (tumble_port_t){.context = replay, .now_us = now_us, .can_send = can_send, .can_receive = can_receive};
    return TUMBLE_OK;
}

/* The course of a replay. */

typedef struct {
    replay_t *replay;
    tumble_navcomp_t *navcomp;
    void (*watch)(void *context);
    void *context;
} course_t;

/* Step, and again for as long as the next step is due at once. */
static void step(const course_t *course)
{
    for (uint32_t steps = 0; steps < MOST_STEPS; steps++) {
        tumble_navcomp_step(course->navcomp);
        if (course->watch != NULL) {
            course->watch(course->context);
        }
        if (tumble_navcomp_next_deadline_us(course->navcomp) > course->replay->now_us) {
            return;
        }
    }
}

/* What is due before that moment happens in time; then it is that moment. */
static void pass_until(const course_t *course, uint64_t moment_us)
{
    replay_t *replay = course->replay;
    uint64_t due_us = tumble_navcomp_next_deadline_us(course->navcomp);
    while (due_us < moment_us) {
        replay->now_us = (due_us > replay->now_us) ? due_us : (replay->now_us + 1U);
        if (replay->now_us >= moment_us) {
            break;
        }
        step(course);
        due_us = tumble_navcomp_next_deadline_us(course->navcomp);
    }
    replay->now_us = (moment_us > replay->now_us) ? moment_us : replay->now_us;
}

static void obey(const course_t *course, const uint8_t data[TUMBLE_CAN_MAX_BYTES])
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(course->navcomp, &progress);
    const tumble_command_t command = (tumble_command_t)data[0];
    const bool asked_for = (command == TUMBLE_COMMAND_CONFIRM_MOUNTING) && (data[1] == 0U);
    const uint8_t argument = asked_for ? progress.run.mounting : data[1];
    if (tumble_navcomp_command(course->navcomp, command, argument) != TUMBLE_OK) {
        course->replay->commands_refused++;
    }
}

void replay_run(replay_t *replay, tumble_navcomp_t *navcomp, void (*watch)(void *context), void *context)
{
    const course_t course = {replay, navcomp, watch, context};
    step(&course);
    for (uint32_t i = 0; i < replay->count; i++) {
        replay_record_t record;
        replay_get_record(record_at(replay->recording, i), &record);
        pass_until(&course, record.time_us);
        if (record.frame.id == REPLAY_COMMAND) {
            obey(&course, record.frame.data);
        } else {
            replay->frame = record.frame;
            replay->waiting = true;
        }
        step(&course);
    }
    pass_until(&course, replay->now_us + AFTER_US);
}
