/* A life: the memory that it begins with, what its events do, who stands at the bench, and its course. */
#include "world/hostile.h"

#include "canopen/cia402.h"
#include "core/bytes.h"
#include "simulation/block_encode.h"
#include "tumble/sets.h"
#include "world/report.h"

#include <stdlib.h>
#include <string.h>

#define SET_POINT_ID 0x202U
#define DRIVE_SDO_ID 0x602U
#define US_PER_S 1e6
#define RELATIVE_U 1e-4
#define NEXT_US 1000U    /* from one frame of a group to the next */
#define NEAR_US 300U     /* as near as the bus allows */
#define SEGMENT_US 4000U /* from one of a transfer to the next: the server has answered by then */
#define SPOILS 0x55U
#define STREAM_EVENT 1000U /* and its number: the stream of an event, an index of SIM_CAUSE_LIFE */

_Static_assert(LIFE_FAULTS == SIM_FAULT_KINDS && LIFE_EVENTS == LIFE_EVENT_ANY_FRAME + 1 &&
                   LIFE_STATES == TUMBLE_STATE_COUNT && LIFE_REASONS == TUMBLE_REASON_COUNT,
               "all of the closed lists is counted");

/* A whole number from 0 to count - 1; true with this probability. */

static uint32_t pick(sim_random_t *stream, uint32_t count)
{
    return (uint32_t)((sim_random_u64(stream) >> 32) * (uint64_t)count >> 32);
}

static bool chance(sim_random_t *stream, double probability)
{
    return sim_random_unit(stream) < probability;
}

/* The memory: what it begins with, and what a loss of power leaves in it. */

static void settle(tumble_store_t *store)
{
    while (tumble_store_step(store) == TUMBLE_E_PORT_BUSY) {
    }
}

/* An active set, true to this block, as an earlier calibration would have left it. */
static void write_set(bench_life_t *life)
{
    static tumble_store_t store;
    const life_plan_t *const plan = life->plan;
    tumble_set_t set = {.estimator = (uint8_t)life->config->procedure.estimate,
                        .flags = TUMBLE_SET_HAS_UNCERTAINTY,
                        .coefficients = life->world->truth.block};
    memcpy(set.block_serial, life->config->keeping.serial, strlen(life->config->keeping.serial));
    set.date_utc_s = (plan->utc_s != 0U) ? plan->utc_s - 86400U : 0U;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            set.uncertainty.k_v_per_g[i][j] = RELATIVE_U;
        }
        set.uncertainty.u0_v[i] = RELATIVE_U;
    }
    (void)tumble_store_init(&store, &life->memory->nv.nv);
    settle(&store);
    (void)tumble_store_commit(&store, &set);
    settle(&store);
}

static void prepare_memory(bench_life_t *life)
{
    if (life->plan->has_set) {
        write_set(life);
    }
    life->memory->nv.erase_us = life->plan->erase_us;
    life->memory->nv.program_us = life->plan->program_us;
}

/* Each granule is as it was to be, or holds anything: half programmed bits, or nothing that makes sense. */
static void tear_memory(bench_life_t *life, sim_random_t *stream)
{
    sim_nv_t *const nv = &life->memory->nv;
    if (nv->size == 0U || life->world->clock.now_us >= nv->until_us) {
        return;
    }
    const double share = sim_random_unit(stream);
    for (uint32_t i = 0; i < nv->size; i += SIM_NV_GRANULE) {
        if (!chance(stream, share)) {
            continue;
        }
        const uint64_t garbage = sim_random_u64(stream);
        for (uint32_t b = 0; b < SIM_NV_GRANULE; b++) {
            nv->bytes[nv->offset + i + b] |= (uint8_t)(garbage >> 8 * b);
        }
        if (chance(stream, 0.5)) {
            memcpy(&nv->bytes[nv->offset + i], &garbage, SIM_NV_GRANULE);
        }
    }
}

/* FNV-1a */
static uint64_t hash(const uint8_t *bytes, uint32_t size)
{
    uint64_t found = 14695981039346656037U;
    for (uint32_t i = 0; i < size; i++) {
        found = (found ^ bytes[i]) * 1099511628211U;
    }
    return found;
}

bool bench_life_is_flipped(const bench_life_t *life, const bench_flipped_t *flipped)
{
    return hash(&life->memory->nv.bytes[flipped->offset], flipped->size) == flipped->hash;
}

/* The set with its mark, or the entry of the history, that this byte belongs to: as it is before the flip. */
static void note_flip(bench_life_t *life, uint32_t first, uint32_t at)
{
    const uint32_t region = at / SIM_NV_SECTOR;
    const bool of_history = region == TUMBLE_REGION_HISTORY || region == TUMBLE_REGION_HISTORY + 1U;
    const bool of_set = region >= TUMBLE_REGION_SLOT_A && region <= TUMBLE_REGION_PROPOSAL;
    const uint32_t size = of_history ? TUMBLE_HISTORY_BYTES : TUMBLE_SET_PLACE_BYTES;
    const uint32_t offset = of_history ? at - at % size : region * SIM_NV_SECTOR;
    if (!of_history && !(of_set && at < offset + size)) {
        return;
    }
    bench_flipped_t flipped = {.offset = offset, .size = size, .sound = hash(&life->memory->nv.bytes[offset], size)};
    for (uint32_t i = 0; i < life->flipped_count; i++) {
        if (life->flipped[i].offset == offset && i >= first) {
            return;
        }
        if (life->flipped[i].offset == offset && life->flipped[i].hash == flipped.sound) {
            flipped.sound = life->flipped[i].sound; /* nobody has written it since */
        }
    }
    if (life->flipped_count < BENCH_FLIPPED) {
        life->flipped[life->flipped_count++] = flipped;
    }
}

/* Their content from now on. What a second flip has put right is none. */
static void take_flipped(bench_life_t *life, uint32_t first)
{
    uint32_t kept = first;
    for (uint32_t i = first; i < life->flipped_count; i++) {
        bench_flipped_t flipped = life->flipped[i];
        flipped.hash = hash(&life->memory->nv.bytes[flipped.offset], flipped.size);
        life->flipped[kept] = flipped;
        kept += (flipped.hash != flipped.sound) ? 1U : 0U;
    }
    life->flipped_count = kept;
}

/* Anywhere, or as often in a mark, which is small and decides. */
static uint32_t draw_place(sim_random_t *stream)
{
    const uint32_t region = TUMBLE_REGION_SLOT_A + pick(stream, 3);
    return chance(stream, 0.5) ? pick(stream, SIM_NV_BYTES)
                               : region * SIM_NV_SECTOR + TUMBLE_SET_BYTES + pick(stream, 8);
}

/* Where something is written: an erased byte means nothing to anyone. */
static void flip_bits(bench_life_t *life, sim_random_t *stream, uint32_t count)
{
    const uint32_t first = life->flipped_count;
    for (uint32_t flipped = 0, tries = 0; flipped < count && tries < 20000U; tries++) {
        const uint32_t at = draw_place(stream);
        if (life->memory->nv.bytes[at] != 0xFFU) {
            note_flip(life, first, at);
            life->memory->nv.bytes[at] ^= (uint8_t)(1U << pick(stream, 8));
            life->found->flipped_bits++;
            flipped++;
        }
    }
    take_flipped(life, first);
}

/* Power of the computer, and commands to it. */

static tumble_status_t give_command(bench_life_t *life, tumble_command_t command, uint8_t argument)
{
    if (life->world->off) {
        return TUMBLE_E_STATE;
    }
    if (command != TUMBLE_COMMAND_ABORT) {
        bench_watch_commanded(life);
    }
    const tumble_status_t status = tumble_navcomp_command(&life->world->navcomp, command, argument);
    if (status == TUMBLE_OK) {
        bench_watch_decide(life, command, false);
    }
    if (command == TUMBLE_COMMAND_ABORT) {
        bench_watch_ended(life);
    }
    sim_clock_set(&life->world->clock, SIM_ACTOR_NAVCOMP, life->world->clock.now_us);
    return status;
}

/* The firmware begins anew. */
static void boot(bench_life_t *life)
{
    life->world->mark = BENCH_LOOK_AGAIN;
    if (world_boot(life->own) != TUMBLE_OK) {
        bench_watch_break(life, LIFE_BROKEN_BENCH, 0.0, 0);
    } else if (life->plan->utc_s != 0U) {
        const uint64_t now_s = life->world->clock.now_us / 1000000U;
        (void)tumble_keeper_set_utc(&life->memory->keeper, life->plan->utc_s + now_s);
    }
}

static void cut_power(bench_life_t *life, const life_event_t *event)
{
    sim_random_t stream;
    bench_world_t *const world = life->world;
    if (world->off) {
        return;
    }
    sim_random_open(&stream, world->seed, SIM_CAUSE_LIFE, STREAM_EVENT + event->number);
    const tumble_state_t state = world->progress.state;
    life->run_was_on = state != TUMBLE_STATE_IDLE && state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT;
    life->found->held += life->memory->keeper.counters.held;
    tear_memory(life, &stream);
    world_set_off(life->own, true);
    if (event->count > 0U) {
        bench_watch_excuse(life, LIFE_EXCUSE_FLIPPED);
        flip_bits(life, &stream, event->count);
    }
    bench_watch_ended(life);
    life->watch.decided_us = (life->watch.decided_us >= world->clock.now_us) ? SIM_NEVER : 0U;
    life->attend_us = SIM_NEVER;
    life->power_us = world->clock.now_us + event->off_us;
}

static void power_on(bench_life_t *life)
{
    life->power_us = SIM_NEVER;
    world_set_off(life->own, false);
    bench_watch_power_on(life);
    boot(life);
    life->attend_us = life->run_was_on ? life->world->clock.now_us + 1500000U : SIM_NEVER;
}

/* What an event does when its moment has come. */

/* A frame of the stranger, now or later. */
static void send_frame(bench_life_t *life, const tumble_can_frame_t *frame, uint32_t after_us)
{
    if (after_us == 0U) {
        (void)sim_bus_send(&life->world->bus, BENCH_BUS_GUEST, frame);
    } else if (life->queued < BENCH_LIFE_QUEUE) {
        life->queue[life->queued++] = (bench_follower_t){life->world->clock.now_us + after_us, *frame};
    }
}

/* An SDO write of up to four bytes to the server of `node`. */
static tumble_can_frame_t frame_write(uint8_t node, uint16_t index, uint8_t subindex, uint8_t size, uint32_t value)
{
    tumble_can_frame_t frame = {.id = (uint16_t)(0x600U + node), .length = 8};
    frame.data[0] = (uint8_t)(0x23U | (4U - size) << 2);
    tumble_put_u16(&frame.data[1], index);
    frame.data[3] = subindex;
    tumble_put_u32(&frame.data[4], value);
    return frame;
}

/* Commands over CAN: argument or angle, then the command. */

static uint32_t send_angle(bench_life_t *life, double angle_deg)
{
    tumble_can_frame_t frame = {.id = 0x601, .length = 8, .data = {0x21, 0x02, 0x20, 0x03, 8}};
    uint8_t bytes[8];
    tumble_put_f64(bytes, angle_deg);
    send_frame(life, &frame, 0);
    frame = (tumble_can_frame_t){.id = 0x601, .length = 8, .data = {0x00}};
    for (int i = 0; i < 7; i++) {
        frame.data[1 + i] = bytes[i];
    }
    send_frame(life, &frame, SEGMENT_US);
    frame = (tumble_can_frame_t){.id = 0x601, .length = 8, .data = {0x1D, bytes[7]}};
    send_frame(life, &frame, 2U * SEGMENT_US);
    return 3U * SEGMENT_US;
}

static void send_command(bench_life_t *life, const life_event_t *event)
{
    tumble_can_frame_t frame;
    uint32_t after_us = 0;
    if (event->command == TUMBLE_COMMAND_TURN_AXIS) {
        after_us = send_angle(life, event->angle_deg);
    } else if (event->argument != 0U) {
        frame = frame_write(1, 0x2002, 1, 1, event->argument);
        send_frame(life, &frame, 0);
        after_us = SEGMENT_US;
    }
    frame = frame_write(1, 0x2002, 2, 1, event->command);
    send_frame(life, &frame, after_us);
}

static void command(bench_life_t *life, const life_event_t *event)
{
    if (!event->by_host) {
        send_command(life, event);
    } else if (event->command != TUMBLE_COMMAND_TURN_AXIS) {
        (void)give_command(life, (tumble_command_t)event->command, event->argument);
    } else if (!life->world->off) {
        bench_watch_commanded(life);
        (void)tumble_navcomp_turn(&life->world->navcomp, event->angle_deg);
    }
}

/* Frames made of what there is at this moment. */

static int32_t counts_of(const bench_life_t *life, double angle_deg)
{
    const sim_drive_config_t *const drive = &life->config->scenario.drive;
    return (int32_t)(angle_deg * (double)drive->sign * (double)drive->counts_per_turn / 360.0);
}

static int32_t wrapped(const bench_life_t *life, int32_t counts)
{
    const int32_t wrap = (int32_t)life->config->scenario.drive.wrap_counts;
    const int32_t within = (wrap > 0) ? counts % wrap : counts;
    return (within < 0 && wrap > 0) ? within + wrap : within;
}

/* Reports with the drive's own statusword, each this much further than the one before. */
static void forge_positions(bench_life_t *life, const life_event_t *event)
{
    const tumble_drive_objects_t *const objects = &life->world->drive.objects;
    int32_t counts = objects->position_actual_value;
    for (uint32_t i = 0; i < event->count; i++) {
        tumble_can_frame_t frame = {.id = 0x182, .length = 6};
        counts = wrapped(life, counts + counts_of(life, event->angle_deg));
        tumble_put_u16(&frame.data[0], objects->statusword);
        tumble_put_i32(&frame.data[2], counts);
        send_frame(life, &frame, i * ((event->kind == LIFE_EVENT_NEAR_POSITION) ? NEAR_US : NEXT_US));
    }
}

/* The target, and then the edge: as process data, or by SDO. */
static void forge_set_point(bench_life_t *life, const life_event_t *event)
{
    static const uint16_t CONTROLS[] = {0x000F, 0x003F, 0x000F};
    const double from_deg = event->relative ? life->world->drive.target_deg : 0.0;
    const int32_t target = wrapped(life, counts_of(life, from_deg + event->angle_deg));
    tumble_can_frame_t frame = {.id = 0x202, .length = 6};
    tumble_put_i32(&frame.data[2], target);
    if (event->kind == LIFE_EVENT_SDO_SET_POINT) {
        frame = frame_write(2, TUMBLE_402_TARGET_POSITION, 0, 4, (uint32_t)target);
        send_frame(life, &frame, 0);
    }
    for (uint32_t i = 0; i < 3U; i++) {
        if (event->kind == LIFE_EVENT_SDO_SET_POINT) {
            frame = frame_write(2, TUMBLE_402_CONTROLWORD, 0, 2, CONTROLS[i]);
            send_frame(life, &frame, (i + 1U) * SEGMENT_US);
            continue;
        }
        tumble_put_u16(&frame.data[0], CONTROLS[i]);
        send_frame(life, &frame, i * 3U * NEXT_US);
    }
}

static void forge_sample(bench_life_t *life, const life_event_t *event)
{
    const sim_block_t *const block = &life->world->block;
    sim_block_frames_t frames;
    tumble_block_sample_t sample = {.raw.counter = (uint16_t)block->counter,
                                    .timestamp_ms =
                                        (uint16_t)((life->world->clock.now_us - block->powered_us) / 1000U % 4096U),
                                    .temperature_half_c = 50};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        sample.raw.counts[i] = block->sensor.last[i] + event->counts;
    }
    sim_block_encode(&sample, &frames);
    if (event->kind == LIFE_EVENT_SPOILT_SAMPLE) {
        frames.z.data[7] ^= SPOILS;
    } else {
        bench_watch_excuse(life, LIFE_EXCUSE_SAMPLE);
    }
    send_frame(life, &frames.xy, 0);
    send_frame(life, &frames.z, 0);
}

/* What an event excuses. */

static bool hits(const sim_fault_t *fault, uint16_t id)
{
    return (id & fault->mask) == (fault->id & fault->mask);
}

/* A fault in force. */
static void excuse_fault(bench_life_t *life, const sim_fault_t *fault)
{
    const bool corrupts = fault->kind == SIM_FAULT_FRAME_CORRUPT;
    if ((corrupts || fault->kind == SIM_FAULT_FRAME_DELAY || fault->kind == SIM_FAULT_FRAME_REORDER) &&
        hits(fault, SET_POINT_ID)) {
        bench_watch_excuse(life, LIFE_EXCUSE_COMMANDED);
    }
    if (corrupts && hits(fault, DRIVE_SDO_ID)) {
        bench_watch_excuse(life, LIFE_EXCUSE_REWRITTEN);
    } else if (fault->kind == SIM_FAULT_STEP) {
        bench_watch_excuse(life, LIFE_EXCUSE_STEP);
    } else if (fault->kind == SIM_FAULT_SLIP) {
        bench_watch_excuse(life, LIFE_EXCUSE_SLIP);
    } else if (fault->kind == SIM_FAULT_SWAPPED || fault->kind == SIM_FAULT_INVERTED) {
        bench_watch_excuse(life, LIFE_EXCUSE_CHANNEL);
    } else if (fault->kind == SIM_FAULT_NEVER_REACHED &&
               fault->value < life->config->procedure.position_tolerance_deg) {
        bench_watch_excuse(life, LIFE_EXCUSE_SHORT);
    }
}

/* A frame that may command the drive, or write to it. Speed, acceleration and limits are what the navigation computer
 * reads back before a motion. */
static void excuse_frame(bench_life_t *life, const life_event_t *event)
{
    const bool download = event->id == DRIVE_SDO_ID && event->length > 0U && (event->data[0] & 0xE0U) <= 0x20U;
    const uint16_t index = tumble_get_u16(&event->data[1]);
    const bool of_motion = index == TUMBLE_402_CONTROLWORD || index == TUMBLE_402_TARGET_POSITION;
    const bool is_read_back = index == TUMBLE_402_PROFILE_VELOCITY || index == TUMBLE_402_PROFILE_ACCELERATION ||
                              index == TUMBLE_402_SOFTWARE_LIMIT;
    if (event->kind == LIFE_EVENT_SET_POINT || event->kind == LIFE_EVENT_SDO_SET_POINT || event->id == SET_POINT_ID ||
        (download && of_motion)) {
        bench_watch_excuse(life, LIFE_EXCUSE_COMMANDED);
    }
    if (download && !((event->data[0] & 0xE0U) == 0x20U && (of_motion || is_read_back))) {
        bench_watch_excuse(life, LIFE_EXCUSE_REWRITTEN);
    }
}

static void act_on_event(bench_life_t *life, const life_event_t *event)
{
    tumble_can_frame_t frame = {.id = event->id, .length = event->length};
    life->found->events[event->kind]++;
    excuse_frame(life, event);
    switch (event->kind) {
    case LIFE_EVENT_COMMAND:
        command(life, event);
        break;
    case LIFE_EVENT_POWER_CUT:
        cut_power(life, event);
        break;
    case LIFE_EVENT_SET_POINT:
    case LIFE_EVENT_SDO_SET_POINT:
        forge_set_point(life, event);
        break;
    case LIFE_EVENT_POSITION:
    case LIFE_EVENT_NEAR_POSITION:
        forge_positions(life, event);
        break;
    case LIFE_EVENT_SAMPLE:
    case LIFE_EVENT_SPOILT_SAMPLE:
        forge_sample(life, event);
        break;
    default:
        memcpy(frame.data, event->data, sizeof frame.data);
        send_frame(life, &frame, 0);
        break;
    }
}

/* Who stands at the bench: he mounts the block and confirms, mends faults, and goes on after a loss of power. */

static void attend_to(bench_life_t *life, const tumble_progress_t *progress)
{
    const life_plan_t *const attendant = life->plan;
    double after_s = -1.0;
    if (progress->state == TUMBLE_STATE_WAIT_MOUNTING) {
        after_s = attendant->mount_s;
    } else if (progress->state == TUMBLE_STATE_FAULT && life->mended < attendant->mends) {
        after_s = attendant->mend_s;
    }
    life->attend_us = (after_s >= 0.0) ? life->world->clock.now_us + (uint64_t)(after_s * US_PER_S) : SIM_NEVER;
}

static void mount(bench_life_t *life, uint8_t asked)
{
    const bool errs = life->plan->errs && !life->erred && asked == 2U;
    life->erred = life->erred || errs;
    const uint8_t number = errs ? 1U : asked;
    if (life->lies != number) {
        life->lies = number;
        bench_world_mount(life->world, (uint8_t)(number - 1U));
    }
    (void)give_command(life, TUMBLE_COMMAND_CONFIRM_MOUNTING, asked);
}

static void mend(bench_life_t *life, const tumble_progress_t *progress)
{
    life->mended++;
    bench_fault_script_mend(life->world);
    if (bench_person_must_mount(progress->reason)) {
        mount(life, progress->mounting);
    } else {
        (void)give_command(life, TUMBLE_COMMAND_RESUME, 0);
    }
}

/* After a loss of power a run that was on goes on, or begins anew. */
static void go_on(bench_life_t *life)
{
    tumble_sets_state_t state;
    tumble_keeper_state(&life->memory->keeper, &state);
    const bool resumes = life->plan->resumes && state.resumable > 0U;
    life->run_was_on = false;
    (void)give_command(life, resumes ? TUMBLE_COMMAND_RESUME : TUMBLE_COMMAND_START, 0);
}

static void attend(bench_life_t *life)
{
    const tumble_progress_t progress = life->world->progress;
    life->attend_us = SIM_NEVER;
    if (life->world->off) {
        return;
    }
    if (progress.state == TUMBLE_STATE_WAIT_MOUNTING) {
        mount(life, progress.mounting);
        attend_to(life, &progress); /* again, should it be refused */
    } else if (progress.state == TUMBLE_STATE_FAULT) {
        mend(life, &progress);
    } else if (progress.state == TUMBLE_STATE_IDLE && life->run_was_on) {
        go_on(life);
    }
}

/* What the world tells. */

static bool is_reached(const bench_life_t *life, const life_event_t *event)
{
    const bool in_state = event->states == 0U || (event->states >> life->watch.state & 1U) != 0U;
    return in_state && (!event->writing || life->memory->nv.size != 0U);
}

static bool has_condition(const life_event_t *event)
{
    return event->states != 0U || event->writing;
}

static void find_next(bench_life_t *life)
{
    life->next_us = SIM_NEVER;
    for (size_t i = 0; i < life->event_count; i++) {
        life->next_us = (life->due_us[i] < life->next_us) ? life->due_us[i] : life->next_us;
    }
}

/* Events that wait for a state, or for the memory to be at work, may come now. */
static void look_at_waiting(bench_life_t *life)
{
    for (size_t i = 0; i < life->event_count; i++) {
        const life_event_t *const event = &life->events[i];
        if (life->waits[i] && is_reached(life, event)) {
            life->waits[i] = false;
            life->waiting_for_writing -= event->writing ? 1U : 0U;
            life->due_us[i] = life->world->clock.now_us + event->delay_us;
        }
    }
    find_next(life);
}

static void on_change(void *context, const tumble_progress_t *progress)
{
    bench_life_t *const life = context;
    bench_watch_change(life, progress);
    attend_to(life, progress);
    look_at_waiting(life);
}

static void on_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    bench_watch_sample(context, taken, sample);
}

/* As it is delivered: whatever a fault has made of it. */
static void on_frame(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    (void)time_us;
    bench_watch_frame(context, sender, frame);
}

/* The course. */

static void send_followers(bench_life_t *life)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < life->queued; i++) {
        if (life->queue[i].due_us <= life->world->clock.now_us) {
            (void)sim_bus_send(&life->world->bus, BENCH_BUS_GUEST, &life->queue[i].frame);
        } else {
            life->queue[kept++] = life->queue[i];
        }
    }
    life->queued = kept;
}

/* Its time has come: it happens, or begins to wait for what it waits for. */
static void act_on_due(bench_life_t *life)
{
    for (size_t i = 0; i < life->event_count; i++) {
        const life_event_t *const event = &life->events[i];
        if (life->due_us[i] > life->world->clock.now_us) {
            continue;
        }
        life->due_us[i] = SIM_NEVER;
        if (has_condition(event) && !life->waited[i]) {
            life->waited[i] = true;
            life->waits[i] = true;
            life->waiting_for_writing += event->writing ? 1U : 0U;
        } else {
            act_on_event(life, event);
        }
    }
    look_at_waiting(life);
}

static uint64_t earliest(const bench_life_t *life)
{
    uint64_t first_us = (life->attend_us < life->next_us) ? life->attend_us : life->next_us;
    first_us = (life->power_us < first_us) ? life->power_us : first_us;
    for (uint32_t i = 0; i < life->queued; i++) {
        first_us = (life->queue[i].due_us < first_us) ? life->queue[i].due_us : first_us;
    }
    return first_us;
}

static void act(bench_life_t *life)
{
    const uint64_t now_us = life->world->clock.now_us;
    if (life->power_us <= now_us) {
        power_on(life);
    }
    if (life->attend_us <= now_us) {
        attend(life);
    }
    send_followers(life);
    if (life->next_us <= now_us) {
        act_on_due(life);
    }
}

/* Faults that have come to pass, for what they excuse, as long as they are in force. */
static void note_faults(bench_life_t *life)
{
    for (uint32_t i = 0; i < life->config->scenario.fault_count; i++) {
        if (life->world->script.states[i].in_force) {
            excuse_fault(life, &life->config->scenario.faults[i]);
        }
    }
}

/* False: the life is over. */
static bool advance(bench_life_t *life)
{
    bench_world_t *const world = life->world;
    const uint64_t mine_us = earliest(life);
    const uint64_t worlds_us = bench_world_next_us(world);
    if (mine_us > life->plan->lasts_us && worlds_us > life->plan->lasts_us) {
        return false;
    }
    if (mine_us <= worlds_us) {
        bench_world_pass(world, mine_us);
        act(life);
    } else if (!bench_world_advance(world)) {
        return false;
    }
    if (life->waiting_for_writing > 0U && life->memory->nv.size != 0U) {
        look_at_waiting(life);
    }
    note_faults(life);
    bench_watch_look(life);
    return life->found->kind == LIFE_BROKEN_NONE;
}

static void begin(bench_life_t *life)
{
    life->lies = 1;
    life->attend_us = SIM_NEVER;
    life->power_us = SIM_NEVER;
    for (size_t i = 0; i < life->event_count; i++) {
        life->due_us[i] = life->events[i].at_us;
    }
    find_next(life);
    bench_watch_init(life);
    life->watch.has_set = life->plan->has_set;
    life->watch.counter = life->plan->has_set ? 1U : 0U;
    world_add_memory(life->own);
    life->memory->keeper_config.sets.whole_step = NULL; /* what is judged in time is enough */
    prepare_memory(life);
    boot(life);
}

/* What came to pass of the faults; and what there was at the end. */
static void sum_up(bench_life_t *life)
{
    life_found_t *const found = life->found;
    const bench_world_t *const world = life->world;
    for (uint32_t i = 0; i < life->config->scenario.fault_count; i++) {
        const uint32_t times = world->script.states[i].times;
        found->faults[life->config->scenario.faults[i].kind] += times;
        found->events[LIFE_EVENT_FAULT] += times;
    }
    if (!world->off) {
        found->held += life->memory->keeper.counters.held;
        bench_watch_read_all(life);
    }
    const bench_travel_t travel = bench_travel(world);
    found->virtual_us = world->clock.now_us;
    found->frames = world->bus.load.frames;
    found->steps = world->steps;
    found->at_rest = travel.at_rest;
    found->lowest_deg = travel.lowest_deg;
    found->highest_deg = travel.highest_deg;
}

const char *lives_live(world_t *world, uint64_t seed, const life_plan_t *plan, const life_event_t *events, size_t count,
                       life_found_t *found)
{
    world->config.profile.velocity_deg_s = plan->velocity_deg_s;
    const char *const wrong = world_check(world);
    bench_life_t *const life = (wrong == NULL) ? calloc(1, sizeof *life) : NULL;
    if (life == NULL) {
        return (wrong != NULL) ? wrong : "no memory";
    }
    *life = (bench_life_t){.plan = plan,
                           .events = events,
                           .event_count = (count < LIFE_MOST_EVENTS) ? count : LIFE_MOST_EVENTS,
                           .found = found,
                           .own = world,
                           .config = &world->config,
                           .world = &world->world,
                           .memory = &world->memory,
                           .watcher = {life, on_change, on_sample, on_frame, NULL, NULL}};
    memset(found, 0, sizeof *found);
    const tumble_status_t status = bench_world_init(life->world, life->config, seed, &life->watcher);
    if (status == TUMBLE_OK) {
        begin(life);
        while (advance(life)) {
        }
        sum_up(life);
    }
    free(life);
    return (status == TUMBLE_OK) ? NULL : tumble_status_sentence(status);
}

/* For who draws plans and tells of lives. */

void lives_open(life_stream_t *stream, uint64_t seed, uint32_t index)
{
    sim_random_t random;
    sim_random_open(&random, seed, SIM_CAUSE_LIFE, index);
    memcpy(stream->s, random.s, sizeof stream->s);
}

uint64_t lives_random(life_stream_t *stream)
{
    sim_random_t random;
    memcpy(random.s, stream->s, sizeof random.s);
    const uint64_t found = sim_random_u64(&random);
    memcpy(stream->s, random.s, sizeof stream->s);
    return found;
}

const char *lives_name(life_names_t of, uint32_t number)
{
    switch (of) {
    case LIFE_NAMES_OF_FAULTS:
        return (number < SIM_FAULT_KINDS) ? sim_fault_word((sim_fault_kind_t)number) : NULL;
    case LIFE_NAMES_OF_STATES:
        return (number < TUMBLE_STATE_COUNT) ? tumble_state_name((tumble_state_t)number) : NULL;
    case LIFE_NAMES_OF_REASONS:
        return (number < TUMBLE_REASON_COUNT) ? tumble_reason_name((tumble_reason_t)number) : NULL;
    default:
        return (number < TUMBLE_COMMAND_COUNT) ? tumble_command_name((tumble_command_t)number) : NULL;
    }
}
