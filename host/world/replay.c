#include "world/replay.h"

#include "commissioning.h"
#include "world/world.h"
#include "world/world_parts.h"

#include <stdlib.h>
#include <string.h>

#define STATE_PDO 0x181U
#define SDO_REQUEST 0x601U
#define HEARTBEAT 0x701U
#define NODE 1U
#define HEARD_BEFORE_US 150000U

_Static_assert(WORLD_COMMISSIONING_BYTES == ZCU102_COMMISSIONING_BYTES, "there is room for the largest record");

/* The recording. */

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

static void add_frame(recorder_t *recorder, uint64_t time_us, const world_frame_t *recorded)
{
    tumble_can_frame_t frame = {.id = recorded->id, .length = recorded->length};
    (void)memcpy(frame.data, recorded->data, recorded->length);
    add(recorder, time_us, &frame);
}

static void add_command(recorder_t *recorder, uint64_t time_us, tumble_command_t command)
{
    const tumble_can_frame_t frame = {.id = REPLAY_COMMAND, .length = 2, .data = {(uint8_t)command}};
    if (!recorder->carried[command]) {
        add(recorder, time_us, &frame);
    }
}

/* An SDO request that writes 2002h:2, one byte. */
static bool is_command(const world_frame_t *frame)
{
    const uint8_t *const data = frame->data;
    return frame->id == SDO_REQUEST && frame->length == 8U && (data[0] & 0xE2U) == 0x22U && data[1] == 0x02U &&
           data[2] == 0x20U && data[3] == 2U && data[4] < (uint8_t)TUMBLE_COMMAND_COUNT;
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
    const tumble_reason_t reason_before = recorder->reason;
    recorder->state = state;
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
                    bench_operator_must_mount(reason_before) ? TUMBLE_COMMAND_CONFIRM_MOUNTING : TUMBLE_COMMAND_RESUME);
    }
}

/* What node 1 sent tells what it had been told. */
static void watch_node_1(recorder_t *recorder, uint64_t time_us, const bench_config_t *config,
                         const world_frame_t *frame)
{
    if (frame->id == STATE_PDO && frame->length >= 2U) {
        note_state(recorder, time_us, (tumble_state_t)frame->data[0], (tumble_reason_t)frame->data[1]);
    } else if (is_receive_pdo(config, frame->id) && recorder->state == TUMBLE_STATE_WAIT_MOUNTING) {
        note_state(recorder, time_us, TUMBLE_STATE_MOVE, TUMBLE_REASON_NONE);
    }
}

/* Where node 1 comes to life, with its last boot-up message. Its controller listens a little before that message is on
 * the bus (an emulator takes up to 0.1 s), and a heartbeat heard then makes it begin: better one too many than one too
 * few. Without such a message it was there all the time. */
static size_t find_beginning(const world_frame_t *frames, size_t count)
{
    size_t at = 0;
    for (size_t i = 0; i < count; i++) {
        if (frames[i].id == HEARTBEAT && frames[i].length == 1U && frames[i].data[0] == 0U) {
            at = i;
        }
    }
    const uint64_t boot_us = frames[at].time_us;
    while (at > 0U && frames[at - 1U].time_us + HEARD_BEFORE_US >= boot_us) {
        at--;
    }
    return at;
}

/* Started at once, unless it is seen to be idle. */
static void note_beginning(recorder_t *recorder, const world_frame_t *frames, size_t count)
{
    const world_frame_t *first = NULL; /* that tells its state */
    for (size_t i = 0; i < count; i++) {
        if (is_command(&frames[i])) {
            recorder->carried[frames[i].data[4]] = true;
        }
        first = (first == NULL && frames[i].id == STATE_PDO) ? &frames[i] : first;
    }
    if (first == NULL || first->data[0] != (uint8_t)TUMBLE_STATE_IDLE) {
        recorder->started = true;
        add_command(recorder, 0, TUMBLE_COMMAND_START);
    }
}

static void record(recorder_t *recorder, const bench_config_t *config, const world_frame_t *frames, size_t count)
{
    note_beginning(recorder, frames, count);
    for (size_t i = 0; i < count; i++) {
        const uint64_t time_us = frames[i].time_us - frames[0].time_us;
        if (is_of_node_1(config, frames[i].id)) {
            watch_node_1(recorder, time_us, config, &frames[i]);
        } else {
            add_frame(recorder, time_us, &frames[i]);
        }
    }
    replay_put_header(recorder->bytes, (uint32_t)recorder->count);
}

const char *world_recording(world_t *world, const world_frame_t *frames, size_t count, const uint8_t **recording,
                            size_t *size)
{
    const size_t most = 2U * count + 1U; /* at most one command a frame */
    free(world->recording);
    world->recording =
        (most <= UINT32_MAX && count > 0U) ? malloc(REPLAY_HEADER_BYTES + most * REPLAY_RECORD_BYTES) : NULL;
    if (world->recording == NULL) {
        return "holds no frames, or more than there is memory for";
    }
    recorder_t recorder = {.bytes = world->recording};
    const size_t from = find_beginning(frames, count);
    record(&recorder, &world->config, frames + from, count - from);
    *recording = world->recording;
    *size = REPLAY_HEADER_BYTES + recorder.count * REPLAY_RECORD_BYTES;
    return NULL;
}

/* Here. */

/* The world's clock is that of the recording. */
static void on_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    world_t *const world = context;
    world->world.clock.now_us = world->replay.now_us;
    if (world->watcher.on_sample != NULL) {
        world->watcher.on_sample(world, taken, sample);
    }
}

/* The firmware anew, with the recording for a bus. */
static tumble_status_t power_on(world_t *world)
{
    bench_world_t *const own = &world->world;
    world->heard_us = SIM_NEVER; /* another log begins */
    world->replay_hooks = (tumble_navcomp_hooks_t){world, on_sample};
    own->navcomp_config.port = &world->replay.port;
    own->navcomp_config.hooks = &world->replay_hooks;
    return tumble_navcomp_init(&own->navcomp, &own->navcomp_config);
}

static void play(world_t *world)
{
    bench_world_t *const own = &world->world;
    replay_run(&world->replay, &own->navcomp, NULL, NULL);
    own->clock.now_us = world->replay.now_us;
    tumble_procedure_progress(tumble_navcomp_procedure(&own->navcomp), &own->progress);
    own->end = (own->progress.state == TUMBLE_STATE_DONE) ? WORLD_DONE : WORLD_FAULT;
    own->wanted_end = own->end;
    own->ending_us = own->clock.now_us;
}

const char *world_replay(world_t *world, const world_frame_t *frames, size_t count, uint32_t *commands_refused)
{
    const uint8_t *recording = NULL;
    size_t size = 0;
    const char *wrong = world_recording(world, frames, count, &recording, &size);
    wrong = (wrong != NULL) ? wrong : world_power_on(world, 0, WORLD_NEVER, false);
    if (wrong != NULL) {
        return wrong;
    }
    tumble_status_t status = replay_open(&world->replay, recording, size);
    status = (status == TUMBLE_OK) ? power_on(world) : status;
    if (status != TUMBLE_OK) {
        return tumble_status_sentence(status);
    }
    play(world);
    *commands_refused = world->replay.commands_refused;
    return NULL;
}

/* On the board. */

const char *world_commissioning(world_t *world, uint8_t *record, size_t *size)
{
    zcu102_commissioned_t commissioned;
    const tumble_navcomp_config_t navcomp = bench_navcomp_config(&world->config, NULL, NULL, NULL);
    if (zcu102_commission(&commissioned, &navcomp) != TUMBLE_OK) {
        return "the board zcu102 cannot do this run: it needs a drive, with a profile and mountings that fit its record";
    }
    *size = zcu102_commissioning_write(&commissioned, record);
    return NULL;
}
