#include "world/hostile.h"

#include "canopen/cia402.h"
#include "core/bytes.h"
#include "simulation/block_encode.h"
#include "world/world.h"

#include <string.h>

/* What an event does when its moment has come. */

#define NEXT_US 1000U    /* from one frame of a group to the next */
#define NEAR_US 300U     /* as near as the bus allows */
#define SEGMENT_US 4000U /* from one of a transfer to the next: the server has answered by then */
#define SPOILS 0x55U

/* The computer of the board itself is told; SIM_ACTOR_NAVCOMP is woken. */
static tumble_status_t give_command(bench_life_t *life, tumble_command_t command, uint8_t argument);

/* Its power is lost. */
static void cut_power(bench_life_t *life, const bench_event_t *event);

/* A frame of the stranger, now or later. */
static void send_frame(bench_life_t *life, const tumble_can_frame_t *frame, uint32_t after_us)
{
    if (after_us == 0U) {
        (void)sim_bus_send(&life->world.bus, BENCH_BUS_GUEST, frame);
    } else if (life->queued < BENCH_LIFE_QUEUE) {
        life->queue[life->queued++] = (bench_follower_t){life->world.clock.now_us + after_us, *frame};
    }
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

static void send_command(bench_life_t *life, const bench_event_t *event)
{
    tumble_can_frame_t frame;
    uint32_t after_us = 0;
    if (event->command == TUMBLE_COMMAND_TURN_AXIS) {
        after_us = send_angle(life, event->angle_deg);
    } else if (event->argument != 0U) {
        bench_frame_write(&frame, 1, 0x2002, 1, 1, event->argument);
        send_frame(life, &frame, 0);
        after_us = SEGMENT_US;
    }
    bench_frame_write(&frame, 1, 0x2002, 2, 1, (uint32_t)event->command);
    send_frame(life, &frame, after_us);
}

static void command(bench_life_t *life, const bench_event_t *event)
{
    if (!event->by_host) {
        send_command(life, event);
    } else if (event->command != TUMBLE_COMMAND_TURN_AXIS) {
        (void)give_command(life, event->command, event->argument);
    } else if (!life->world.off) {
        bench_watch_commanded(life);
        (void)tumble_navcomp_turn(&life->world.navcomp, event->angle_deg);
    }
}

/* Frames made of what there is at this moment. */

static int32_t counts_of(const bench_life_t *life, double angle_deg)
{
    const sim_drive_config_t *const drive = &life->plan->config.scenario.drive;
    return (int32_t)(angle_deg * (double)drive->sign * (double)drive->counts_per_turn / 360.0);
}

static int32_t wrapped(const bench_life_t *life, int32_t counts)
{
    const int32_t wrap = (int32_t)life->plan->config.scenario.drive.wrap_counts;
    const int32_t within = (wrap > 0) ? counts % wrap : counts;
    return (within < 0 && wrap > 0) ? within + wrap : within;
}

/* Reports with the drive's own statusword, each this much further than the one before. */
static void forge_positions(bench_life_t *life, const bench_event_t *event)
{
    const tumble_drive_objects_t *const objects = &life->world.drive.objects;
    int32_t counts = objects->position_actual_value;
    for (uint32_t i = 0; i < event->count; i++) {
        tumble_can_frame_t frame = {.id = 0x182, .length = 6};
        counts = wrapped(life, counts + counts_of(life, event->angle_deg));
        tumble_put_u16(&frame.data[0], objects->statusword);
        tumble_put_i32(&frame.data[2], counts);
        send_frame(life, &frame, i * ((event->kind == BENCH_HOSTILE_NEAR_POSITION) ? NEAR_US : NEXT_US));
    }
}

/* The target, and then the edge: as process data, or by SDO. */
static void forge_set_point(bench_life_t *life, const bench_event_t *event)
{
    static const uint16_t CONTROLS[] = {0x000F, 0x003F, 0x000F};
    const double from_deg = event->relative ? life->world.drive.target_deg : 0.0;
    const int32_t target = wrapped(life, counts_of(life, from_deg + event->angle_deg));
    tumble_can_frame_t frame = {.id = 0x202, .length = 6};
    tumble_put_i32(&frame.data[2], target);
    if (event->kind == BENCH_HOSTILE_SDO_SET_POINT) {
        bench_frame_write(&frame, 2, TUMBLE_402_TARGET_POSITION, 0, 4, (uint32_t)target);
        send_frame(life, &frame, 0);
    }
    for (uint32_t i = 0; i < 3U; i++) {
        if (event->kind == BENCH_HOSTILE_SDO_SET_POINT) {
            bench_frame_write(&frame, 2, TUMBLE_402_CONTROLWORD, 0, 2, CONTROLS[i]);
            send_frame(life, &frame, (i + 1U) * SEGMENT_US);
            continue;
        }
        tumble_put_u16(&frame.data[0], CONTROLS[i]);
        send_frame(life, &frame, i * 3U * NEXT_US);
    }
}

static void forge_sample(bench_life_t *life, const bench_event_t *event)
{
    const sim_block_t *const block = &life->world.block;
    sim_block_frames_t frames;
    tumble_block_sample_t sample = {.raw.counter = (uint16_t)block->counter,
                                    .timestamp_ms =
                                        (uint16_t)((life->world.clock.now_us - block->powered_us) / 1000U % 4096U),
                                    .temperature_half_c = 50};
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        sample.raw.counts[i] = block->sensor.last[i] + event->counts;
    }
    sim_block_encode(&sample, &frames);
    if (event->kind == BENCH_HOSTILE_SPOILT_SAMPLE) {
        frames.z.data[7] ^= SPOILS;
    } else {
        bench_watch_excuse(life, BENCH_EXCUSE_SAMPLE);
    }
    send_frame(life, &frames.xy, 0);
    send_frame(life, &frames.z, 0);
}

static void note_excuses(bench_life_t *life, const bench_event_t *event)
{
    if (bench_event_commands_drive(event)) {
        bench_watch_excuse(life, BENCH_EXCUSE_COMMANDED);
    }
    if (bench_event_rewrites_drive(event)) {
        bench_watch_excuse(life, BENCH_EXCUSE_REWRITTEN);
    }
}

void bench_life_excuse_fault(bench_life_t *life, const sim_fault_t *fault)
{
    const bench_event_t event = {.kind = BENCH_HOSTILE_FAULT, .fault = *fault};
    note_excuses(life, &event);
    if (fault->kind == SIM_FAULT_STEP) {
        bench_watch_excuse(life, BENCH_EXCUSE_STEP);
    } else if (fault->kind == SIM_FAULT_SLIP) {
        bench_watch_excuse(life, BENCH_EXCUSE_SLIP);
    } else if (fault->kind == SIM_FAULT_SWAPPED || fault->kind == SIM_FAULT_INVERTED) {
        bench_watch_excuse(life, BENCH_EXCUSE_CHANNEL);
    } else if (fault->kind == SIM_FAULT_NEVER_REACHED &&
               fault->value < life->plan->config.procedure.position_tolerance_deg) {
        bench_watch_excuse(life, BENCH_EXCUSE_SHORT);
    }
}

void bench_life_act(bench_life_t *life, const bench_event_t *event)
{
    life->counts.events[event->kind]++;
    note_excuses(life, event);
    switch (event->kind) {
    case BENCH_HOSTILE_COMMAND:
        command(life, event);
        break;
    case BENCH_HOSTILE_CUT:
        cut_power(life, event);
        break;
    case BENCH_HOSTILE_SET_POINT:
    case BENCH_HOSTILE_SDO_SET_POINT:
        forge_set_point(life, event);
        break;
    case BENCH_HOSTILE_POSITION:
    case BENCH_HOSTILE_NEAR_POSITION:
        forge_positions(life, event);
        break;
    case BENCH_HOSTILE_SAMPLE:
    case BENCH_HOSTILE_SPOILT_SAMPLE:
        forge_sample(life, event);
        break;
    default:
        send_frame(life, &event->frame, 0);
        break;
    }
}

/* Who stands at the bench: he mounts the block and confirms, mends faults, and goes on after a loss of power. */

#define US_PER_S 1e6

void bench_life_attend_to(bench_life_t *life, const tumble_progress_t *progress)
{
    const bench_attendant_t *const attendant = &life->plan->attendant;
    double after_s = -1.0;
    if (progress->state == TUMBLE_STATE_WAIT_MOUNTING) {
        after_s = attendant->mount_s;
    } else if (progress->state == TUMBLE_STATE_FAULT && life->mended < attendant->mends) {
        after_s = attendant->mend_s;
    }
    life->attend_us = (after_s >= 0.0) ? life->world.clock.now_us + (uint64_t)(after_s * US_PER_S) : SIM_NEVER;
}

static void lay(bench_life_t *life, uint8_t number)
{
    if (life->lies != number) {
        life->lies = number;
        bench_world_mount(&life->world, (uint8_t)(number - 1U));
    }
}

static void mount(bench_life_t *life, uint8_t asked)
{
    const bool errs = life->plan->attendant.errs && !life->erred && asked == 2U;
    life->erred = life->erred || errs;
    lay(life, errs ? 1U : asked);
    (void)give_command(life, TUMBLE_COMMAND_CONFIRM_MOUNTING, asked);
}

static void mend(bench_life_t *life, const tumble_progress_t *progress)
{
    life->mended++;
    bench_fault_script_mend(&life->world);
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
    tumble_sets_state(&life->keeper.sets, &state);
    const bool resumes = life->plan->attendant.resumes && state.resumable > 0U;
    life->run_was_on = false;
    (void)give_command(life, resumes ? TUMBLE_COMMAND_RESUME : TUMBLE_COMMAND_START, 0);
}

void bench_life_attend(bench_life_t *life)
{
    const tumble_progress_t progress = life->world.progress;
    life->attend_us = SIM_NEVER;
    if (life->world.off) {
        return;
    }
    if (progress.state == TUMBLE_STATE_WAIT_MOUNTING) {
        mount(life, progress.mounting);
        bench_life_attend_to(life, &progress); /* again, should it be refused */
    } else if (progress.state == TUMBLE_STATE_FAULT) {
        mend(life, &progress);
    } else if (progress.state == TUMBLE_STATE_IDLE && life->run_was_on) {
        go_on(life);
    }
}

/* Power of the computer, and commands to it. */

static tumble_status_t give_command(bench_life_t *life, tumble_command_t command, uint8_t argument)
{
    if (life->world.off) {
        return TUMBLE_E_STATE;
    }
    if (command != TUMBLE_COMMAND_ABORT) {
        bench_watch_commanded(life);
    }
    const tumble_status_t status = tumble_navcomp_command(&life->world.navcomp, command, argument);
    if (status == TUMBLE_OK) {
        bench_watch_decide(life, command, false);
    }
    if (command == TUMBLE_COMMAND_ABORT) {
        bench_watch_ended(life);
    }
    sim_clock_set(&life->world.clock, SIM_ACTOR_NAVCOMP, life->world.clock.now_us);
    return status;
}

void bench_life_boot(bench_life_t *life)
{
    bench_world_t *const world = &life->world;
    memset(&life->keeper, 0x5A, sizeof life->keeper);
    life->keeper.config = &life->keeper_config;
    if (tumble_navcomp_init(&world->navcomp, &world->navcomp_config) != TUMBLE_OK) {
        bench_watch_break(life, BENCH_BROKEN_BENCH, 0.0, 0);
        return;
    }
    if (life->plan->utc_s != 0U) {
        (void)tumble_sets_set_utc(&life->keeper.sets, life->plan->utc_s + world->clock.now_us / 1000000U);
    }
    world->mark = BENCH_LOOK_AGAIN;
    sim_clock_set(&world->clock, SIM_ACTOR_NAVCOMP, world->clock.now_us);
}

static void cut_power(bench_life_t *life, const bench_event_t *event)
{
    sim_random_t stream;
    bench_world_t *const world = &life->world;
    if (world->off) {
        return;
    }
    sim_random_open(&stream, life->plan->seed, SIM_CAUSE_LIFE, BENCH_STREAM_EVENT + event->number);
    const tumble_state_t state = world->progress.state;
    life->run_was_on = state != TUMBLE_STATE_IDLE && state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT;
    life->counts.held += tumble_sets_counters(&life->keeper.sets)->held;
    world->off = true;
    sim_bus_set_down(&world->bus, BENCH_BUS_NAVCOMP, true);
    sim_clock_set(&world->clock, SIM_ACTOR_NAVCOMP, SIM_NEVER);
    bench_life_tear_memory(life, &stream);
    life->nv.size = 0;
    if (event->count > 0U) {
        bench_watch_excuse(life, BENCH_EXCUSE_FLIPPED);
        bench_life_flip_bits(life, &stream, event->count);
    }
    bench_watch_ended(life);
    life->watch.decided_us = (life->watch.decided_us >= world->clock.now_us) ? SIM_NEVER : 0U;
    life->attend_us = SIM_NEVER;
    life->power_us = world->clock.now_us + event->off_us;
}

void bench_life_power_on(bench_life_t *life)
{
    bench_world_t *const world = &life->world;
    life->power_us = SIM_NEVER;
    world->off = false;
    sim_bus_set_down(&world->bus, BENCH_BUS_NAVCOMP, true); /* what had come for nobody */
    sim_bus_set_down(&world->bus, BENCH_BUS_NAVCOMP, false);
    bench_watch_power_on(life);
    bench_life_boot(life);
    life->attend_us = life->run_was_on ? world->clock.now_us + 1500000U : SIM_NEVER;
}
