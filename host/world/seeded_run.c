/* A run of the fault campaign: the memory that it begins with, what its events do, who stands at the bench, and its course. */
#include "world/seeded_run.h"

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
#define STREAM_EVENT 1000U /* and its number: the stream of an event, an index of SIM_CAUSE_CAMPAIGN */

_Static_assert(CAMPAIGN_FAULTS == SIM_FAULT_KINDS && CAMPAIGN_EVENTS == CAMPAIGN_EVENT_ANY_FRAME + 1 &&
                   CAMPAIGN_STATES == TUMBLE_STATE_COUNT && CAMPAIGN_REASONS == TUMBLE_REASON_COUNT,
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
static void write_set(seeded_run_t *run)
{
    static tumble_store_t store;
    const campaign_plan_t *const plan = run->plan;
    tumble_set_t set = {.estimator = (uint8_t)run->config->procedure.estimate,
                        .flags = TUMBLE_SET_HAS_UNCERTAINTY,
                        .coefficients = run->world->truth.block};
    memcpy(set.block_serial, run->config->keeping.serial, strlen(run->config->keeping.serial));
    set.date_utc_s = (plan->utc_s != 0U) ? plan->utc_s - 86400U : 0U;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            set.uncertainty.k_v_per_g[i][j] = RELATIVE_U;
        }
        set.uncertainty.u0_v[i] = RELATIVE_U;
    }
    (void)tumble_store_init(&store, &run->memory->nv.nv);
    settle(&store);
    (void)tumble_store_commit(&store, &set);
    settle(&store);
}

static void prepare_memory(seeded_run_t *run)
{
    if (run->plan->has_set) {
        write_set(run);
    }
    run->memory->nv.erase_us = run->plan->erase_us;
    run->memory->nv.program_us = run->plan->program_us;
}

/* Each granule is as it was to be, or holds anything: half programmed bits, or nothing that makes sense. */
static void tear_memory(seeded_run_t *run, sim_random_t *stream)
{
    sim_nv_t *const nv = &run->memory->nv;
    if (nv->size == 0U || run->world->clock.now_us >= nv->until_us) {
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

bool seeded_run_is_flipped(const seeded_run_t *run, const bench_flipped_t *flipped)
{
    return hash(&run->memory->nv.bytes[flipped->offset], flipped->size) == flipped->hash;
}

/* The set with its mark, or the entry of the history, that this byte belongs to: as it is before the flip. */
static void note_flip(seeded_run_t *run, uint32_t first, uint32_t at)
{
    const uint32_t region = at / SIM_NV_SECTOR;
    const bool of_history = region == TUMBLE_REGION_HISTORY || region == TUMBLE_REGION_HISTORY + 1U;
    const bool of_set = region >= TUMBLE_REGION_SLOT_A && region <= TUMBLE_REGION_PROPOSAL;
    const uint32_t size = of_history ? TUMBLE_HISTORY_BYTES : TUMBLE_SET_PLACE_BYTES;
    const uint32_t offset = of_history ? at - at % size : region * SIM_NV_SECTOR;
    if (!of_history && !(of_set && at < offset + size)) {
        return;
    }
    bench_flipped_t flipped = {.offset = offset, .size = size, .sound = hash(&run->memory->nv.bytes[offset], size)};
    for (uint32_t i = 0; i < run->flipped_count; i++) {
        if (run->flipped[i].offset == offset && i >= first) {
            return;
        }
        if (run->flipped[i].offset == offset && run->flipped[i].hash == flipped.sound) {
            flipped.sound = run->flipped[i].sound; /* nobody has written it since */
        }
    }
    if (run->flipped_count < BENCH_FLIPPED) {
        run->flipped[run->flipped_count++] = flipped;
    }
}

/* Their content from now on. What a second flip has put right is none. */
static void take_flipped(seeded_run_t *run, uint32_t first)
{
    uint32_t kept = first;
    for (uint32_t i = first; i < run->flipped_count; i++) {
        bench_flipped_t flipped = run->flipped[i];
        flipped.hash = hash(&run->memory->nv.bytes[flipped.offset], flipped.size);
        run->flipped[kept] = flipped;
        kept += (flipped.hash != flipped.sound) ? 1U : 0U;
    }
    run->flipped_count = kept;
}

/* Anywhere, or as often in a mark, which is small and decides. */
static uint32_t draw_place(sim_random_t *stream)
{
    const uint32_t region = TUMBLE_REGION_SLOT_A + pick(stream, 3);
    return chance(stream, 0.5) ? pick(stream, SIM_NV_BYTES)
                               : region * SIM_NV_SECTOR + TUMBLE_SET_BYTES + pick(stream, 8);
}

/* Where something is written: an erased byte means nothing to anyone. */
static void flip_bits(seeded_run_t *run, sim_random_t *stream, uint32_t count)
{
    const uint32_t first = run->flipped_count;
    for (uint32_t flipped = 0, tries = 0; flipped < count && tries < 20000U; tries++) {
        const uint32_t at = draw_place(stream);
        if (run->memory->nv.bytes[at] != 0xFFU) {
            note_flip(run, first, at);
            run->memory->nv.bytes[at] ^= (uint8_t)(1U << pick(stream, 8));
            run->found->flipped_bits++;
            flipped++;
        }
    }
    take_flipped(run, first);
}

/* Power of the computer, and commands to it. */

static tumble_status_t give_command(seeded_run_t *run, tumble_command_t command, uint8_t argument)
{
    if (run->world->off) {
        return TUMBLE_E_STATE;
    }
    if (command != TUMBLE_COMMAND_ABORT) {
        bench_watch_commanded(run);
    }
    const tumble_status_t status = tumble_navcomp_command(&run->world->navcomp, command, argument);
    if (status == TUMBLE_OK) {
        bench_watch_decide(run, command, false);
    }
    if (command == TUMBLE_COMMAND_ABORT) {
        bench_watch_ended(run);
    }
    sim_clock_set(&run->world->clock, SIM_ACTOR_NAVCOMP, run->world->clock.now_us);
    return status;
}

/* The firmware begins anew. */
static void boot(seeded_run_t *run)
{
    run->world->mark = BENCH_LOOK_AGAIN;
    if (world_boot(run->own) != TUMBLE_OK) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_BENCH, 0.0, 0);
    } else if (run->plan->utc_s != 0U) {
        const uint64_t now_s = run->world->clock.now_us / 1000000U;
        (void)tumble_keeper_set_utc(&run->memory->keeper, run->plan->utc_s + now_s);
    }
}

static void cut_power(seeded_run_t *run, const campaign_event_t *event)
{
    sim_random_t stream;
    bench_world_t *const world = run->world;
    if (world->off) {
        return;
    }
    sim_random_open(&stream, world->seed, SIM_CAUSE_CAMPAIGN, STREAM_EVENT + event->number);
    const tumble_state_t state = world->progress.state;
    run->run_was_on = state != TUMBLE_STATE_IDLE && state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT;
    run->found->held += run->memory->keeper.counters.held;
    tear_memory(run, &stream);
    world_set_off(run->own, true);
    if (event->count > 0U) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_FLIPPED);
        flip_bits(run, &stream, event->count);
    }
    bench_watch_ended(run);
    run->watch.decided_us = (run->watch.decided_us >= world->clock.now_us) ? SIM_NEVER : 0U;
    run->attend_us = SIM_NEVER;
    run->power_us = world->clock.now_us + event->off_us;
}

static void power_on(seeded_run_t *run)
{
    run->power_us = SIM_NEVER;
    world_set_off(run->own, false);
    bench_watch_power_on(run);
    boot(run);
    run->attend_us = run->run_was_on ? run->world->clock.now_us + 1500000U : SIM_NEVER;
}

/* What an event does when its moment has come. */

/* A frame of the stranger, now or later. */
static void send_frame(seeded_run_t *run, const tumble_can_frame_t *frame, uint32_t after_us)
{
    if (after_us == 0U) {
        (void)sim_bus_send(&run->world->bus, BENCH_BUS_GUEST, frame);
    } else if (run->queued < SEEDED_RUN_QUEUE) {
        run->queue[run->queued++] = (bench_follower_t){run->world->clock.now_us + after_us, *frame};
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

static uint32_t send_angle(seeded_run_t *run, double angle_deg)
{
    tumble_can_frame_t frame = {.id = 0x601, .length = 8, .data = {0x21, 0x02, 0x20, 0x03, 8}};
    uint8_t bytes[8];
    tumble_put_f64(bytes, angle_deg);
    send_frame(run, &frame, 0);
    frame = (tumble_can_frame_t){.id = 0x601, .length = 8, .data = {0x00}};
    for (int i = 0; i < 7; i++) {
        frame.data[1 + i] = bytes[i];
    }
    send_frame(run, &frame, SEGMENT_US);
    frame = (tumble_can_frame_t){.id = 0x601, .length = 8, .data = {0x1D, bytes[7]}};
    send_frame(run, &frame, 2U * SEGMENT_US);
    return 3U * SEGMENT_US;
}

static void send_command(seeded_run_t *run, const campaign_event_t *event)
{
    tumble_can_frame_t frame;
    uint32_t after_us = 0;
    if (event->command == TUMBLE_COMMAND_TURN_AXIS) {
        after_us = send_angle(run, event->angle_deg);
    } else if (event->argument != 0U) {
        frame = frame_write(1, 0x2002, 1, 1, event->argument);
        send_frame(run, &frame, 0);
        after_us = SEGMENT_US;
    }
    frame = frame_write(1, 0x2002, 2, 1, event->command);
    send_frame(run, &frame, after_us);
}

static void command(seeded_run_t *run, const campaign_event_t *event)
{
    if (!event->by_host) {
        send_command(run, event);
    } else if (event->command != TUMBLE_COMMAND_TURN_AXIS) {
        (void)give_command(run, (tumble_command_t)event->command, event->argument);
    } else if (!run->world->off) {
        bench_watch_commanded(run);
        (void)tumble_navcomp_turn(&run->world->navcomp, event->angle_deg);
    }
}

/* Frames made of what there is at this moment. */

static int32_t counts_of(const seeded_run_t *run, double angle_deg)
{
    const sim_drive_config_t *const drive = &run->config->scenario.drive;
    return (int32_t)(angle_deg * (double)drive->sign * (double)drive->counts_per_turn / 360.0);
}

static int32_t wrapped(const seeded_run_t *run, int32_t counts)
{
    const int32_t wrap = (int32_t)run->config->scenario.drive.wrap_counts;
    const int32_t within = (wrap > 0) ? counts % wrap : counts;
    return (within < 0 && wrap > 0) ? within + wrap : within;
}

/* Reports with the drive's own statusword, each this much further than the one before. */
static void forge_positions(seeded_run_t *run, const campaign_event_t *event)
{
    const tumble_drive_objects_t *const objects = &run->world->drive.objects;
    int32_t counts = objects->position_actual_value;
    for (uint32_t i = 0; i < event->count; i++) {
        tumble_can_frame_t frame = {.id = 0x182, .length = 6};
        counts = wrapped(run, counts + counts_of(run, event->angle_deg));
        tumble_put_u16(&frame.data[0], objects->statusword);
        tumble_put_i32(&frame.data[2], counts);
        send_frame(run, &frame, i * ((event->kind == CAMPAIGN_EVENT_NEAR_POSITION) ? NEAR_US : NEXT_US));
    }
}

/* The target, and then the edge: as process data, or by SDO. */
static void forge_set_point(seeded_run_t *run, const campaign_event_t *event)
{
    static const uint16_t CONTROLS[] = {0x000F, 0x003F, 0x000F};
    const double from_deg = event->relative ? run->world->drive.target_deg : 0.0;
    const int32_t target = wrapped(run, counts_of(run, from_deg + event->angle_deg));
    tumble_can_frame_t frame = {.id = 0x202, .length = 6};
    tumble_put_i32(&frame.data[2], target);
    if (event->kind == CAMPAIGN_EVENT_SDO_SET_POINT) {
        frame = frame_write(2, TUMBLE_402_TARGET_POSITION, 0, 4, (uint32_t)target);
        send_frame(run, &frame, 0);
    }
    for (uint32_t i = 0; i < 3U; i++) {
        if (event->kind == CAMPAIGN_EVENT_SDO_SET_POINT) {
            frame = frame_write(2, TUMBLE_402_CONTROLWORD, 0, 2, CONTROLS[i]);
            send_frame(run, &frame, (i + 1U) * SEGMENT_US);
            continue;
        }
        tumble_put_u16(&frame.data[0], CONTROLS[i]);
        send_frame(run, &frame, i * 3U * NEXT_US);
    }
}

static void forge_sample(seeded_run_t *run, const campaign_event_t *event)
{
    const sim_block_t *const block = &run->world->block;
    sim_block_frames_t frames;
    tumble_block_sample_t sample = {.raw.counter = (uint16_t)block->counter,
                                    .timestamp_ms =
                                        (uint16_t)((run->world->clock.now_us - block->powered_us) / 1000U % 4096U),
                                    .temperature_half_c = 50};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        sample.raw.counts[i] = block->sensor.last[i] + event->counts;
    }
    sim_block_encode(&sample, &frames);
    if (event->kind == CAMPAIGN_EVENT_SPOILT_SAMPLE) {
        frames.z.data[7] ^= SPOILS;
    } else {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_SAMPLE);
    }
    send_frame(run, &frames.xy, 0);
    send_frame(run, &frames.z, 0);
}

/* What an event excuses. */

static bool hits(const sim_fault_t *fault, uint16_t id)
{
    return (id & fault->mask) == (fault->id & fault->mask);
}

/* A fault in force. */
static void excuse_fault(seeded_run_t *run, const sim_fault_t *fault)
{
    const bool corrupts = fault->kind == SIM_FAULT_FRAME_CORRUPT;
    if ((corrupts || fault->kind == SIM_FAULT_FRAME_DELAY || fault->kind == SIM_FAULT_FRAME_REORDER) &&
        hits(fault, SET_POINT_ID)) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_COMMANDED);
    }
    if (corrupts && hits(fault, DRIVE_SDO_ID)) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_REWRITTEN);
    } else if (fault->kind == SIM_FAULT_STEP) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_STEP);
    } else if (fault->kind == SIM_FAULT_SLIP) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_SLIP);
    } else if (fault->kind == SIM_FAULT_SWAPPED || fault->kind == SIM_FAULT_INVERTED) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_CHANNEL);
    } else if (fault->kind == SIM_FAULT_NEVER_REACHED && fault->value < run->config->procedure.position_tolerance_deg) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_SHORT);
    }
}

/* A frame that may command the drive, or write to it. Speed, acceleration and limits are what the navigation computer
 * reads back before a motion. */
static void excuse_frame(seeded_run_t *run, const campaign_event_t *event)
{
    const bool download = event->id == DRIVE_SDO_ID && event->length > 0U && (event->data[0] & 0xE0U) <= 0x20U;
    const uint16_t index = tumble_get_u16(&event->data[1]);
    const bool of_motion = index == TUMBLE_402_CONTROLWORD || index == TUMBLE_402_TARGET_POSITION;
    const bool is_read_back = index == TUMBLE_402_PROFILE_VELOCITY || index == TUMBLE_402_PROFILE_ACCELERATION ||
                              index == TUMBLE_402_SOFTWARE_LIMIT;
    if (event->kind == CAMPAIGN_EVENT_SET_POINT || event->kind == CAMPAIGN_EVENT_SDO_SET_POINT ||
        event->id == SET_POINT_ID || (download && of_motion)) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_COMMANDED);
    }
    if (download && !((event->data[0] & 0xE0U) == 0x20U && (of_motion || is_read_back))) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_REWRITTEN);
    }
}

static void act_on_event(seeded_run_t *run, const campaign_event_t *event)
{
    tumble_can_frame_t frame = {.id = event->id, .length = event->length};
    run->found->events[event->kind]++;
    excuse_frame(run, event);
    switch (event->kind) {
    case CAMPAIGN_EVENT_COMMAND:
        command(run, event);
        break;
    case CAMPAIGN_EVENT_POWER_CUT:
        cut_power(run, event);
        break;
    case CAMPAIGN_EVENT_SET_POINT:
    case CAMPAIGN_EVENT_SDO_SET_POINT:
        forge_set_point(run, event);
        break;
    case CAMPAIGN_EVENT_POSITION:
    case CAMPAIGN_EVENT_NEAR_POSITION:
        forge_positions(run, event);
        break;
    case CAMPAIGN_EVENT_SAMPLE:
    case CAMPAIGN_EVENT_SPOILT_SAMPLE:
        forge_sample(run, event);
        break;
    default:
        memcpy(frame.data, event->data, sizeof frame.data);
        send_frame(run, &frame, 0);
        break;
    }
}

/* Who stands at the bench: he mounts the block and confirms, mends faults, and goes on after a loss of power. */

static void attend_to(seeded_run_t *run, const tumble_progress_t *progress)
{
    const campaign_plan_t *const attendant = run->plan;
    double after_s = -1.0;
    if (progress->state == TUMBLE_STATE_WAIT_MOUNTING) {
        after_s = attendant->mount_s;
    } else if (progress->state == TUMBLE_STATE_FAULT && run->mended < attendant->mends) {
        after_s = attendant->mend_s;
    }
    run->attend_us = (after_s >= 0.0) ? run->world->clock.now_us + (uint64_t)(after_s * US_PER_S) : SIM_NEVER;
}

static void mount(seeded_run_t *run, uint8_t asked)
{
    const bool errs = run->plan->errs && !run->erred && asked == 2U;
    run->erred = run->erred || errs;
    const uint8_t number = errs ? 1U : asked;
    if (run->lies != number) {
        run->lies = number;
        bench_world_mount(run->world, (uint8_t)(number - 1U));
    }
    (void)give_command(run, TUMBLE_COMMAND_CONFIRM_MOUNTING, asked);
}

static void mend(seeded_run_t *run, const tumble_progress_t *progress)
{
    run->mended++;
    bench_fault_script_mend(run->world);
    if (bench_operator_must_mount(progress->reason)) {
        mount(run, progress->mounting);
    } else {
        (void)give_command(run, TUMBLE_COMMAND_RESUME, 0);
    }
}

/* After a loss of power a run that was on goes on, or begins anew. */
static void go_on(seeded_run_t *run)
{
    tumble_sets_state_t state;
    tumble_keeper_state(&run->memory->keeper, &state);
    const bool resumes = run->plan->resumes && state.resumable > 0U;
    run->run_was_on = false;
    (void)give_command(run, resumes ? TUMBLE_COMMAND_RESUME : TUMBLE_COMMAND_START, 0);
}

static void attend(seeded_run_t *run)
{
    const tumble_progress_t progress = run->world->progress;
    run->attend_us = SIM_NEVER;
    if (run->world->off) {
        return;
    }
    if (progress.state == TUMBLE_STATE_WAIT_MOUNTING) {
        mount(run, progress.mounting);
        attend_to(run, &progress); /* again, should it be refused */
    } else if (progress.state == TUMBLE_STATE_FAULT) {
        mend(run, &progress);
    } else if (progress.state == TUMBLE_STATE_IDLE && run->run_was_on) {
        go_on(run);
    }
}

/* What the world tells. */

static bool is_reached(const seeded_run_t *run, const campaign_event_t *event)
{
    const bool in_state = event->states == 0U || (event->states >> run->watch.state & 1U) != 0U;
    return in_state && (!event->writing || run->memory->nv.size != 0U);
}

static bool has_condition(const campaign_event_t *event)
{
    return event->states != 0U || event->writing;
}

static void find_next(seeded_run_t *run)
{
    run->next_us = SIM_NEVER;
    for (size_t i = 0; i < run->event_count; i++) {
        run->next_us = (run->due_us[i] < run->next_us) ? run->due_us[i] : run->next_us;
    }
}

/* Events that wait for a state, or for the memory to be at work, may come now. */
static void check_waiting(seeded_run_t *run)
{
    for (size_t i = 0; i < run->event_count; i++) {
        const campaign_event_t *const event = &run->events[i];
        if (run->waits[i] && is_reached(run, event)) {
            run->waits[i] = false;
            run->waiting_for_writing -= event->writing ? 1U : 0U;
            run->due_us[i] = run->world->clock.now_us + event->delay_us;
        }
    }
    find_next(run);
}

static void on_change(void *context, const tumble_progress_t *progress)
{
    seeded_run_t *const run = context;
    bench_watch_change(run, progress);
    attend_to(run, progress);
    check_waiting(run);
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

static void send_followers(seeded_run_t *run)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < run->queued; i++) {
        if (run->queue[i].due_us <= run->world->clock.now_us) {
            (void)sim_bus_send(&run->world->bus, BENCH_BUS_GUEST, &run->queue[i].frame);
        } else {
            run->queue[kept++] = run->queue[i];
        }
    }
    run->queued = kept;
}

/* Its time has come: it happens, or begins to wait for what it waits for. */
static void act_on_due(seeded_run_t *run)
{
    for (size_t i = 0; i < run->event_count; i++) {
        const campaign_event_t *const event = &run->events[i];
        if (run->due_us[i] > run->world->clock.now_us) {
            continue;
        }
        run->due_us[i] = SIM_NEVER;
        if (has_condition(event) && !run->waited[i]) {
            run->waited[i] = true;
            run->waits[i] = true;
            run->waiting_for_writing += event->writing ? 1U : 0U;
        } else {
            act_on_event(run, event);
        }
    }
    check_waiting(run);
}

static uint64_t earliest(const seeded_run_t *run)
{
    uint64_t first_us = (run->attend_us < run->next_us) ? run->attend_us : run->next_us;
    first_us = (run->power_us < first_us) ? run->power_us : first_us;
    for (uint32_t i = 0; i < run->queued; i++) {
        first_us = (run->queue[i].due_us < first_us) ? run->queue[i].due_us : first_us;
    }
    return first_us;
}

static void act(seeded_run_t *run)
{
    const uint64_t now_us = run->world->clock.now_us;
    if (run->power_us <= now_us) {
        power_on(run);
    }
    if (run->attend_us <= now_us) {
        attend(run);
    }
    send_followers(run);
    if (run->next_us <= now_us) {
        act_on_due(run);
    }
}

/* Faults that have come to pass, for what they excuse, as long as they are in force. */
static void note_faults(seeded_run_t *run)
{
    for (uint32_t i = 0; i < run->config->scenario.fault_count; i++) {
        if (run->world->script.states[i].in_force) {
            excuse_fault(run, &run->config->scenario.faults[i]);
        }
    }
}

/* False: the run is over. */
static bool advance(seeded_run_t *run)
{
    bench_world_t *const world = run->world;
    const uint64_t mine_us = earliest(run);
    const uint64_t worlds_us = bench_world_next_us(world);
    if (mine_us > run->plan->lasts_us && worlds_us > run->plan->lasts_us) {
        return false;
    }
    if (mine_us <= worlds_us) {
        bench_world_pass(world, mine_us);
        act(run);
    } else if (!bench_world_advance(world)) {
        return false;
    }
    if (run->waiting_for_writing > 0U && run->memory->nv.size != 0U) {
        check_waiting(run);
    }
    note_faults(run);
    bench_watch_check(run);
    return run->found->kind == CAMPAIGN_VIOLATION_NONE;
}

static void begin(seeded_run_t *run)
{
    run->lies = 1;
    run->attend_us = SIM_NEVER;
    run->power_us = SIM_NEVER;
    for (size_t i = 0; i < run->event_count; i++) {
        run->due_us[i] = run->events[i].at_us;
    }
    find_next(run);
    bench_watch_init(run);
    run->watch.has_set = run->plan->has_set;
    run->watch.counter = run->plan->has_set ? 1U : 0U;
    world_add_memory(run->own);
    run->memory->keeper_config.sets.whole_step = NULL; /* what is judged in time is enough */
    prepare_memory(run);
    boot(run);
}

/* What came to pass of the faults; and what there was at the end. */
static void sum_up(seeded_run_t *run)
{
    campaign_found_t *const found = run->found;
    const bench_world_t *const world = run->world;
    for (uint32_t i = 0; i < run->config->scenario.fault_count; i++) {
        const uint32_t times = world->script.states[i].times;
        found->faults[run->config->scenario.faults[i].kind] += times;
        found->events[CAMPAIGN_EVENT_FAULT] += times;
    }
    if (!world->off) {
        found->held += run->memory->keeper.counters.held;
        bench_watch_read_all(run);
    }
    const bench_travel_t travel = bench_travel(world);
    found->virtual_us = world->clock.now_us;
    found->frames = world->bus.load.frames;
    found->steps = world->steps;
    found->at_rest = travel.at_rest;
    found->lowest_deg = travel.lowest_deg;
    found->highest_deg = travel.highest_deg;
}

const char *campaign_execute(world_t *world, uint64_t seed, const campaign_plan_t *plan, const campaign_event_t *events,
                             size_t count, campaign_found_t *found)
{
    world->config.profile.velocity_deg_s = plan->velocity_deg_s;
    const char *const wrong = world_check(world);
    seeded_run_t *const run = (wrong == NULL) ? calloc(1, sizeof *run) : NULL;
    if (run == NULL) {
        return (wrong != NULL) ? wrong : "no memory";
    }
    *run = (seeded_run_t){.plan = plan,
                          .events = events,
                          .event_count = (count < CAMPAIGN_MOST_EVENTS) ? count : CAMPAIGN_MOST_EVENTS,
                          .found = found,
                          .own = world,
                          .config = &world->config,
                          .world = &world->world,
                          .memory = &world->memory,
                          .watcher = {run, on_change, on_sample, on_frame, NULL, NULL}};
    memset(found, 0, sizeof *found);
    const tumble_status_t status = bench_world_init(run->world, run->config, seed, &run->watcher);
    if (status == TUMBLE_OK) {
        begin(run);
        while (advance(run)) {
        }
        sum_up(run);
    }
    free(run);
    return (status == TUMBLE_OK) ? NULL : tumble_status_sentence(status);
}

/* For the program that draws plans and reports runs. */

void campaign_stream_open(campaign_stream_t *stream, uint64_t seed, uint32_t index)
{
    sim_random_t random;
    sim_random_open(&random, seed, SIM_CAUSE_CAMPAIGN, index);
    memcpy(stream->s, random.s, sizeof stream->s);
}

uint64_t campaign_stream_next(campaign_stream_t *stream)
{
    sim_random_t random;
    memcpy(random.s, stream->s, sizeof random.s);
    const uint64_t found = sim_random_u64(&random);
    memcpy(stream->s, random.s, sizeof stream->s);
    return found;
}

const char *campaign_name(campaign_names_t of, uint32_t number)
{
    switch (of) {
    case CAMPAIGN_NAMES_OF_FAULTS:
        return (number < SIM_FAULT_KINDS) ? sim_fault_word((sim_fault_kind_t)number) : NULL;
    case CAMPAIGN_NAMES_OF_STATES:
        return (number < TUMBLE_STATE_COUNT) ? tumble_state_name((tumble_state_t)number) : NULL;
    case CAMPAIGN_NAMES_OF_REASONS:
        return (number < TUMBLE_REASON_COUNT) ? tumble_reason_name((tumble_reason_t)number) : NULL;
    default:
        return (number < TUMBLE_COMMAND_COUNT) ? tumble_command_name((tumble_command_t)number) : NULL;
    }
}
