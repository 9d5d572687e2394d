/* What happens in a life, drawn from its seed: single frames of a stranger; the world and the ordinary course; faults;
 * and scenes of what belongs together, as a fault alone or a frame alone seldom meets the moment at which it hurts. */
#include "world/hostile.h"

#include "canopen/cia402.h"
#include "core/bytes.h"
#include "navcomp/service.h"

#include <stdlib.h>
#include <string.h>

#define BURST_FRAMES 150U
#define FOR_GOOD 0.0
#define LIFE_FAULTS 4U
#define COUNT(list) (sizeof(list) / sizeof((list)[0]))

/* Streams: the index of SIM_CAUSE_LIFE, below BENCH_STREAM_EVENT. */
enum { STREAM_WORLD = 0, STREAM_COURSE, STREAM_FAULTS, STREAM_FRAMES, STREAM_CUTS, STREAM_SCENES };

static sim_random_t open_stream(const bench_plan_t *plan, uint32_t number)
{
    sim_random_t stream;
    sim_random_open(&stream, plan->seed, SIM_CAUSE_LIFE, number);
    return stream;
}

/* One of a list, each as likely. */
#define ONE_OF(stream, list) ((list)[bench_pick(stream, COUNT(list))])

/* Uniform from low to high. */
static double draw(sim_random_t *stream, double low, double high)
{
    return low + (high - low) * sim_random_unit(stream);
}

uint32_t bench_pick(sim_random_t *stream, uint32_t count)
{
    return (uint32_t)((sim_random_u64(stream) >> 32) * (uint64_t)count >> 32);
}

bool bench_chance(sim_random_t *stream, double probability)
{
    return sim_random_unit(stream) < probability;
}

static bench_event_t *add_event(bench_plan_t *plan, bench_hostile_t kind, double at_s)
{
    static bench_event_t beyond;
    bench_event_t *const event = (plan->count < BENCH_PLAN_EVENTS) ? &plan->events[plan->count] : &beyond;
    *event = (bench_event_t){.kind = kind, .number = plan->count};
    event->moment.at_us = (uint64_t)((at_s > 0.0) ? at_s * 1e6 : 0.0);
    plan->count += (event != &beyond) ? 1U : 0U;
    return event;
}

static bench_event_t *add_command(bench_plan_t *plan, double at_s, tumble_command_t command, uint8_t argument)
{
    bench_event_t *const event = add_event(plan, BENCH_HOSTILE_COMMAND, at_s);
    event->command = command;
    event->argument = argument;
    return event;
}

/* Frames that a stranger, or a node gone mad, puts on the bus. */

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint32_t value;
} write_t;

/* What the stop, the watch over the drive and the way of its reports depend on. */
static const write_t STOP_WRITES[] = {
    {0x1800, 1, 4, 0x80000202U}, {0x1800, 1, 4, 0x80000202U}, {0x1800, 1, 4, 0x80000000U}, {0x1800, 1, 4, 0x80000000U},
    {0x1800, 1, 4, 0x80000202U}, {0x1800, 1, 4, 0x80000202U}, {0x1800, 1, 4, 0x80000202U}, {0x1800, 2, 1, 240},
    {0x1800, 2, 1, 0},           {0x1800, 3, 2, 0xFFFFU},     {0x1A00, 0, 1, 0},           {0x1400, 1, 4, 0x80000182U},
    {0x1600, 0, 1, 0},           {0x1016, 1, 4, 0},           {0x1016, 1, 4, 0x00021388U}, {0x1016, 2, 4, 0},
    {0x1017, 0, 2, 0},           {0x1017, 0, 2, 60000},       {0x1029, 1, 1, 0},           {0x1029, 1, 1, 2},
    {0x1802, 1, 4, 0x80000181U}, {0x1802, 1, 4, 0x202},       {0x1804, 1, 4, 0x800006C1U}, {0x1804, 1, 4, 0x202},
    {0x2006, 1, 4, 0x76726573U}, {0x2006, 1, 4, 0x76726573U}, {0x2006, 1, 4, 0x73657276U}, {0x2006, 1, 4, 0},
};

/* Other objects of the navigation computer that can be written, most with a value that might do harm. */
/* clang-format off: four in a row */
static const write_t OTHER_WRITES[] = {
    {0x1802, 1, 4, 0x80000181U}, {0x1803, 1, 4, 0x80000681U},
    {0x1A02, 0, 1, 0},           {0x1801, 1, 4, 0x202},
    {0x1401, 1, 4, 0x182},       {0x1003, 0, 1, 0},
    {0x1010, 1, 4, 0x65766173U}, {0x1011, 1, 4, 0x64616F6CU},
    {0x2040, 1, 2, 0x0F},        {0x2040, 2, 4, 360000},
    {0x2040, 4, 2, 0x0627},      {0x2040, 5, 4, 720000},
    {0x2050, 1, 4, 1},           {0x2050, 2, 1, 2},
    {0x2050, 3, 2, 0},           {0x2050, 4, 1, 255},
    {0x2121, 2, 2, 1},           {0x2121, 2, 2, 0},
    {0x2122, 2, 4, 1},           {0x2122, 6, 1, 1},
    {0x2122, 3, 4, 60},          {0x2123, 1, 4, 0x41200000U},
    {0x2123, 2, 1, 3},           {0x2123, 2, 1, 0},
    {0x2124, 1, 4, 0x3F800000U}, {0x2125, 10, 4, 0x3F800000U},
    {0x2126, 4, 4, 0x3F800000U}, {0x2150, 1, 1, 17},
    {0x2160, 1, 1, 3},           {0x2002, 1, 1, 2},
    {0x2001, 0, 1, 1},           {0x2152, 1, 4, 10},
};
/* clang-format on */

/* Of the drive: the first are commands, the others settings. */
static const write_t DRIVE_COMMANDS[] = {
    {0x6040, 0, 2, 0x0F},     {0x6040, 0, 2, 0x1F},  {0x6040, 0, 2, 0x3F},  {0x6040, 0, 2, 0x02},
    {0x6040, 0, 2, 0x00},     {0x6040, 0, 2, 0x80},  {0x607A, 0, 4, 90000}, {0x607A, 0, 4, 500000U},
    {0x607A, 0, 4, 1440000U}, {0x6040, 0, 2, 0x10F},
};
static const write_t DRIVE_SETTINGS[] = {
    {0x6060, 0, 1, 6}, {0x6098, 0, 1, 37},          {0x6085, 0, 4, 100}, {0x607C, 0, 4, 5000},        {0x1016, 1, 4, 0},
    {0x1017, 0, 2, 0}, {0x1400, 1, 4, 0x80000202U}, {0x605A, 0, 2, 0},   {0x1800, 1, 4, 0x80000182U}, {0x6007, 0, 2, 0},
};

/* Those that the navigation computer reads back before a motion. */
static const write_t READ_BACK[] = {
    {0x6081, 0, 4, 265000},      {0x6081, 0, 4, 265000},      {0x6081, 0, 4, 265000},
    {0x6081, 0, 4, 0},           {0x6081, 0, 4, 1000},        {0x6083, 0, 4, 2000},
    {0x607D, 1, 4, 0x80000000U}, {0x607D, 2, 4, 0x7FFFFFFFU}, {0x607A, 0, 4, 500000},
};

void bench_frame_write(tumble_can_frame_t *frame, uint8_t node, uint16_t index, uint8_t subindex, uint8_t size,
                       uint32_t value)
{
    *frame = (tumble_can_frame_t){.id = (uint16_t)(0x600U + node), .length = 8};
    frame->data[0] = (uint8_t)(0x23U | (4U - size) << 2);
    tumble_put_u16(&frame->data[1], index);
    frame->data[3] = subindex;
    tumble_put_u32(&frame->data[4], value);
}

static void write_of(tumble_can_frame_t *frame, uint8_t node, const write_t *write)
{
    bench_frame_write(frame, node, write->index, write->subindex, write->size, write->value);
}

static void draw_stop_write(sim_random_t *stream, tumble_can_frame_t *frame)
{
    write_of(frame, 1, &ONE_OF(stream, STOP_WRITES));
}

static void draw_read_back_write(sim_random_t *stream, tumble_can_frame_t *frame)
{
    write_of(frame, 2, &ONE_OF(stream, READ_BACK));
}

static void fill(sim_random_t *stream, tumble_can_frame_t *frame, uint16_t id, uint8_t length)
{
    *frame = (tumble_can_frame_t){.id = id, .length = length};
    for (uint8_t i = 0; i < length; i++) {
        frame->data[i] = (uint8_t)sim_random_u64(stream);
    }
}

static void draw_navcomp_frame(sim_random_t *stream, tumble_can_frame_t *frame)
{
    if (bench_chance(stream, 0.35)) {
        draw_stop_write(stream, frame);
    } else if (bench_chance(stream, 0.7)) {
        write_of(frame, 1, &ONE_OF(stream, OTHER_WRITES));
        frame->id = bench_chance(stream, 0.2) ? 0x401U : frame->id; /* the other server */
    } else {
        fill(stream, frame, 0x601, 8); /* segments, aborts, reads of anything */
        frame->data[0] = (uint8_t)(bench_pick(stream, 8) << 5);
        frame->data[2] = (uint8_t)(0x10U + bench_pick(stream, 0x12));
    }
}

static void draw_drive_frame(sim_random_t *stream, tumble_can_frame_t *frame)
{
    if (bench_chance(stream, 0.4)) {
        fill(stream, frame, 0x602, 8);
        frame->data[0] = 0x40; /* a read, which may come between a transfer of the node's */
        frame->data[2] = 0x60;
    } else if (bench_chance(stream, 0.3)) {
        draw_read_back_write(stream, frame);
    } else if (bench_chance(stream, 0.7)) {
        write_of(frame, 2, &ONE_OF(stream, DRIVE_COMMANDS));
    } else {
        write_of(frame, 2, &ONE_OF(stream, DRIVE_SETTINGS));
    }
}

static void draw_answer(sim_random_t *stream, tumble_can_frame_t *frame)
{
    static const uint8_t COMMANDS[] = {0x60, 0x43, 0x4B, 0x4F, 0x80, 0x20, 0x00};
    static const uint16_t INDICES[] = {0x607A, 0x6040, 0x1016, 0x1017, 0x1400, 0x1600, 0x6081, 0x6060};
    fill(stream, frame, bench_chance(stream, 0.9) ? 0x582 : 0x583, 8);
    frame->data[0] = ONE_OF(stream, COMMANDS);
    tumble_put_u16(&frame->data[1], ONE_OF(stream, INDICES));
    frame->data[3] = (uint8_t)bench_pick(stream, 3);
}

static void draw_nmt(sim_random_t *stream, tumble_can_frame_t *frame)
{
    static const uint8_t COMMANDS[] = {0x01, 0x02, 0x80, 0x81, 0x82, 0x55};
    *frame = (tumble_can_frame_t){.id = 0, .length = 2};
    frame->data[0] = ONE_OF(stream, COMMANDS);
    frame->data[1] = (uint8_t)bench_pick(stream, 5);
}

static void draw_heartbeat(sim_random_t *stream, tumble_can_frame_t *frame)
{
    static const uint8_t STATES[] = {0x00, 0x04, 0x05, 0x7F, 0x85, 0x33};
    *frame = (tumble_can_frame_t){.id = (uint16_t)(0x701U + bench_pick(stream, 4)), .length = 1};
    frame->data[0] = ONE_OF(stream, STATES);
}

/* Some within the window in which the drive is at its target. */
static void draw_set_point(sim_random_t *stream, bench_event_t *event)
{
    event->relative = bench_chance(stream, 0.3);
    event->angle_deg = event->relative ? draw(stream, -0.2, 0.2) : draw(stream, -1500.0, 1500.0);
}

/* Eight of 45 deg are a turn. */
static void draw_near_positions(sim_random_t *stream, bench_event_t *event)
{
    const double sign = bench_chance(stream, 0.5) ? 1.0 : -1.0;
    event->count = 7U + bench_pick(stream, 4);
    event->angle_deg = sign * (bench_chance(stream, 0.5) ? 360.0 / event->count : draw(stream, 30.0, 45.0));
}

/* Of the kinds whose frame is made when it is sent, only what it is made with. */
static void draw_content(sim_random_t *stream, bench_event_t *event)
{
    switch (event->kind) {
    case BENCH_HOSTILE_SDO_NAVCOMP:
        draw_navcomp_frame(stream, &event->frame);
        break;
    case BENCH_HOSTILE_SDO_DRIVE:
        draw_drive_frame(stream, &event->frame);
        break;
    case BENCH_HOSTILE_SDO_ANSWER:
        draw_answer(stream, &event->frame);
        break;
    case BENCH_HOSTILE_SET_POINT:
    case BENCH_HOSTILE_SDO_SET_POINT:
        draw_set_point(stream, event);
        break;
    case BENCH_HOSTILE_NEAR_POSITION:
        draw_near_positions(stream, event);
        break;
    case BENCH_HOSTILE_POSITION:
        event->angle_deg = draw(stream, -360.0, 360.0);
        event->count = 1U + bench_pick(stream, 4);
        break;
    case BENCH_HOSTILE_SAMPLE:
    case BENCH_HOSTILE_SPOILT_SAMPLE:
        event->counts = (int32_t)draw(stream, -2e6, 2e6);
        break;
    case BENCH_HOSTILE_NMT:
        draw_nmt(stream, &event->frame);
        break;
    case BENCH_HOSTILE_HEARTBEAT:
        draw_heartbeat(stream, &event->frame);
        break;
    case BENCH_HOSTILE_EMERGENCY:
        fill(stream, &event->frame, (uint16_t)(0x081U + bench_pick(stream, 3)), 8);
        break;
    case BENCH_HOSTILE_SYNC:
        fill(stream, &event->frame, 0x080, (uint8_t)bench_pick(stream, 2));
        break;
    case BENCH_HOSTILE_LSS:
        fill(stream, &event->frame, bench_chance(stream, 0.5) ? 0x7E5 : 0x7E4, 8);
        break;
    default:
        fill(stream, &event->frame, (uint16_t)bench_pick(stream, 0x800), (uint8_t)bench_pick(stream, 9));
        break;
    }
}

/* The world. */

static void draw_drive(bench_config_t *config, sim_random_t *stream)
{
    static const uint32_t WRAPS[] = {0, 0, 360000, 360000, 720000};
    static const double SPEEDS[] = {90.0, 90.0, 60.0, 30.0};
    sim_drive_config_t *const drive = &config->scenario.drive;
    drive->wrap_counts = ONE_OF(stream, WRAPS);
    drive->sign = bench_chance(stream, 0.5) ? 1 : -1;
    drive->latches_stale_target = bench_chance(stream, 0.5);
    drive->reaction_us = (uint32_t)draw(stream, 200.0, 20000.0);
    drive->report_us = (uint32_t)draw(stream, 5000.0, 50000.0);
    drive->speed_deg_s = ONE_OF(stream, SPEEDS);
    drive->axis.settling_s = 0.1;
    config->profile.homing_fast_deg_s = (drive->speed_deg_s < 45.0) ? drive->speed_deg_s : 45.0;
    config->profile.velocity_deg_s = (drive->speed_deg_s >= 60.0 && bench_chance(stream, 0.5)) ? 30.0 : 0.0;
    config->profile.stop = (uint8_t)(bench_chance(stream, 0.3) ? TUMBLE_STOP_BY_HALT : TUMBLE_STOP_BY_QUICK_STOP);
}

static void draw_measuring(bench_config_t *config, sim_random_t *stream)
{
    static const tumble_estimate_t ESTIMATES[] = {TUMBLE_ESTIMATE_AVERAGED, TUMBLE_ESTIMATE_REFINED,
                                                  TUMBLE_ESTIMATE_LEAST_SQUARES};
    tumble_procedure_config_t *const procedure = &config->procedure;
    config->scenario.stand.remount_rad = 4e-5;
    config->scenario.block.sample_period_us = bench_chance(stream, 0.5) ? 10000U : 20000U;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        config->scenario.block.sensor.noise_v[i] = 2e-4;
    }
    procedure->samples = 24;
    procedure->estimate = ONE_OF(stream, ESTIMATES);
    procedure->settle_ms = 100;
    procedure->warm_up_samples = 5;
    procedure->mounting_timeout_ms = 20000;
    procedure->warm_up_timeout_ms = 20000;
    procedure->retries = (uint8_t)bench_pick(stream, 3);
}

static void draw_keeping(bench_plan_t *plan, sim_random_t *stream)
{
    bench_keeping_t *const keeping = &plan->config.keeping;
    (void)strcpy(keeping->serial, "TB-0001");
    keeping->first = bench_chance(stream, 0.7); /* else the first result is held */
    keeping->settings.gravity_m_s2 = 9.81;
    plan->has_set = bench_chance(stream, 0.5);
    plan->utc_s = bench_chance(stream, 0.7) ? 1800000000U : 0U;
    plan->erase_us = bench_chance(stream, 0.5) ? (uint32_t)draw(stream, 1000.0, 80000.0) : 0U;
    plan->program_us = bench_chance(stream, 0.5) ? (uint32_t)draw(stream, 20.0, 3000.0) : 0U;
}

static void draw_attendant(bench_plan_t *plan, sim_random_t *stream)
{
    plan->attendant = (bench_attendant_t){
        .mount_s = draw(stream, 0.3, 3.0),
        .mend_s = draw(stream, 1.0, 10.0),
        .mends = bench_pick(stream, 4),
        .resumes = bench_chance(stream, 0.6),
        .errs = bench_chance(stream, 0.03),
    };
    plan->config.scenario.person =
        (sim_operator_config_t){.mount_s = -1.0, .incline_s = -1.0, .turn_s = -1.0, .mend_s = -1.0};
}

static void draw_world(bench_plan_t *plan)
{
    sim_random_t stream = open_stream(plan, STREAM_WORLD);
    bench_config_t *const config = &plan->config;
    bench_config_defaults(config);
    draw_drive(config, &stream);
    draw_measuring(config, &stream);
    draw_keeping(plan, &stream);
    draw_attendant(plan, &stream);
    config->starts = false;
    plan->lasts_us = (uint64_t)(draw(&stream, 80.0, 180.0) * 1e6);
    config->virtual_limit_s = 1e-6 * (double)plan->lasts_us + 1.0; /* the plan ends it */
}

/* The ordinary course: a run, perhaps another, and what people do besides. */

static void draw_command(bench_plan_t *plan, sim_random_t *stream)
{
    static const tumble_command_t COMMANDS[] = {TUMBLE_COMMAND_START,
                                                TUMBLE_COMMAND_ABORT,
                                                TUMBLE_COMMAND_ABORT,
                                                TUMBLE_COMMAND_HOME_AXIS,
                                                TUMBLE_COMMAND_TURN_AXIS,
                                                TUMBLE_COMMAND_TURN_AXIS,
                                                TUMBLE_COMMAND_RESUME,
                                                TUMBLE_COMMAND_CLEAR_FAULT,
                                                TUMBLE_COMMAND_REPEAT_POSITION,
                                                TUMBLE_COMMAND_REPEAT_MOUNTING,
                                                TUMBLE_COMMAND_CONFIRM_MOUNTING,
                                                TUMBLE_COMMAND_ACCEPT,
                                                TUMBLE_COMMAND_DISCARD,
                                                TUMBLE_COMMAND_ROLLBACK};
    const double at_s = draw(stream, 0.0, 1e-6 * (double)plan->lasts_us);
    const tumble_command_t command = ONE_OF(stream, COMMANDS);
    const bool of_a_mounting = command == TUMBLE_COMMAND_REPEAT_MOUNTING || command == TUMBLE_COMMAND_CONFIRM_MOUNTING;
    bench_event_t *const event =
        add_command(plan, at_s, command, (uint8_t)(of_a_mounting ? 1U + bench_pick(stream, 2) : 0U));
    event->by_host = bench_chance(stream, 0.3);
    if (command == TUMBLE_COMMAND_REPEAT_POSITION) {
        event->argument = (uint8_t)bench_pick(stream, 20);
    } else if (command == TUMBLE_COMMAND_TURN_AXIS) {
        event->angle_deg = draw(stream, -40.0, 410.0);
    }
}

static void draw_course(bench_plan_t *plan)
{
    sim_random_t stream = open_stream(plan, STREAM_COURSE);
    const uint32_t commands = bench_chance(&stream, 0.5) ? bench_pick(&stream, 7) : 0U;
    if (bench_chance(&stream, 0.85)) {
        add_command(plan, draw(&stream, 0.2, 4.0), TUMBLE_COMMAND_START, 0)->by_host = true;
    }
    if (bench_chance(&stream, 0.6)) {
        add_command(plan, draw(&stream, 60.0, 120.0), TUMBLE_COMMAND_START, 0);
    }
    for (uint32_t i = 0; i < commands; i++) {
        draw_command(plan, &stream);
    }
}

static void draw_cuts(bench_plan_t *plan)
{
    sim_random_t stream = open_stream(plan, STREAM_CUTS);
    const uint32_t cuts = bench_chance(&stream, 0.35) ? 1U + bench_pick(&stream, 3) : 0U;
    for (uint32_t i = 0; i < cuts; i++) {
        const double at_s = draw(&stream, 0.0, 1e-6 * (double)plan->lasts_us);
        bench_event_t *const cut = add_event(plan, BENCH_HOSTILE_CUT, at_s);
        cut->off_us = (uint32_t)(1e6 * draw(&stream, 0.01, 8.0));
        cut->moment.writing = bench_chance(&stream, 0.5);
        cut->moment.delay_us = bench_chance(&stream, 0.5) ? (uint32_t)draw(&stream, 0.0, 20000.0) : 0U;
        const uint32_t flips = bench_chance(&stream, 0.5) ? 1U : 1U + bench_pick(&stream, 8);
        cut->count = bench_chance(&stream, 0.3) ? flips : 0U;
    }
}

/* Faults. */

/* A fault that begins at a time. */
static sim_fault_t *add_fault(bench_plan_t *plan, sim_fault_kind_t kind, double at_s, double duration_s)
{
    sim_fault_t *const fault = &add_event(plan, BENCH_HOSTILE_FAULT, at_s)->fault;
    *fault = (sim_fault_t){.kind = kind,
                           .at_time = true,
                           .time_s = at_s,
                           .duration_s = duration_s,
                           .times = 1,
                           .channels = 1,
                           .count = UINT32_MAX,
                           .probability = 1.0,
                           .mask = TUMBLE_CAN_MAX_ID};
    return fault;
}

static uint16_t draw_identifier(sim_random_t *stream)
{
    static const uint16_t IDS[] = {0x000, 0x082, 0x083, 0x181, 0x182, 0x182, 0x202, 0x202, 0x582,
                                   0x602, 0x581, 0x601, 0x683, 0x683, 0x693, 0x701, 0x702, 0x703};
    return ONE_OF(stream, IDS);
}

static void draw_frame_fault(sim_random_t *stream, sim_fault_t *fault)
{
    fault->id = draw_identifier(stream);
    fault->mask = bench_chance(stream, 0.2) ? 0x780U : (bench_chance(stream, 0.1) ? 0U : TUMBLE_CAN_MAX_ID);
    fault->count = bench_chance(stream, 0.7) ? 1U + bench_pick(stream, 30) : UINT32_MAX;
    fault->probability = bench_chance(stream, 0.5) ? draw(stream, 0.01, 0.7) : 1.0;
    fault->value = draw(stream, 0.001, 1.0); /* of a delay, s */
}

/* The value of a fault, where it means anything: as likely small as large. */
static void draw_value(sim_random_t *stream, sim_fault_t *fault)
{
    static const uint8_t PAIRS[] = {3, 5, 6};
    static const double SCALES[] = {0.1, 0.25, 0.5, 0.9, 1.1, 2.0, 4.0, 10.0};
    const double sign = bench_chance(stream, 0.5) ? 1.0 : -1.0;
    const double size = draw(stream, 0.0, 1.0);
    fault->channels = (uint8_t)(1U + bench_pick(stream, 7));
    switch (fault->kind) {
    case SIM_FAULT_DRIVE_FAULT:
        fault->value = 0x3210;
        break;
    case SIM_FAULT_NEVER_REACHED:
        fault->value = 0.2 + 20.0 * size;
        break;
    case SIM_FAULT_RUNAWAY:
        fault->value = bench_chance(stream, 0.5) ? 0.0 : 720.0 * size * size;
        break;
    case SIM_FAULT_POSITION_SCALE:
        fault->value = ONE_OF(stream, SCALES);
        break;
    case SIM_FAULT_SLIP:
        fault->value = sign * 20.0 * size * size;
        fault->count = bench_pick(stream, 2);
        break;
    case SIM_FAULT_NOISY:
        fault->value = 2e-4 + 0.02 * size * size;
        break;
    case SIM_FAULT_SWAPPED:
        fault->channels = ONE_OF(stream, PAIRS);
        break;
    case SIM_FAULT_STEP:
        fault->value = sign * 0.2 * size * size * size;
        break;
    case SIM_FAULT_STATUS:
        fault->value = (double)(1U << bench_pick(stream, 4));
        break;
    case SIM_FAULT_WARM:
        fault->value = sign * 20.0 * size;
        break;
    default:
        fault->count = bench_chance(stream, 0.7) ? 1U + bench_pick(stream, 40) : UINT32_MAX;
        break;
    }
}

static void draw_faults(bench_plan_t *plan)
{
    sim_random_t stream = open_stream(plan, STREAM_FAULTS);
    const uint32_t faults = bench_chance(&stream, 0.7) ? 1U + bench_pick(&stream, LIFE_FAULTS) : 0U;
    for (uint32_t i = 0; i < faults; i++) {
        const double at_s = draw(&stream, 0.0, 1e-6 * (double)plan->lasts_us);
        const double short_s = draw(&stream, 0.01, 2.0);
        const double long_s = draw(&stream, 1.0, 30.0);
        const double duration_s = bench_chance(&stream, 0.4) ? short_s : bench_chance(&stream, 0.7) ? long_s : FOR_GOOD;
        sim_fault_t *const fault =
            add_fault(plan, (sim_fault_kind_t)bench_pick(&stream, SIM_FAULT_KINDS), at_s, duration_s);
        if (fault->kind >= SIM_FAULT_FRAME_DROP) {
            draw_frame_fault(&stream, fault);
        } else {
            draw_value(&stream, fault);
        }
        if (bench_chance(&stream, 0.4)) {
            fault->at_time = false;
            fault->mounting = (uint8_t)(1U + bench_pick(&stream, 2));
            fault->position = (uint8_t)(1U + bench_pick(&stream, 9));
            fault->phase = (sim_phase_t)bench_pick(&stream, 5);
            fault->delay_s = draw(&stream, 0.0, 0.8);
        }
    }
}

/* Scenes. */

/* The table is set in motion by command, the way to stop it is tampered with, and then it is told to stop. */
static void void_the_stop(bench_plan_t *plan, sim_random_t *stream)
{
    const bool turns = bench_chance(stream, 0.4);
    const double at_s = draw(stream, 2.0, 8.0);
    const double moves_s = turns ? at_s + 16.0 : at_s;
    const double writes_s = moves_s + draw(stream, -0.5, 2.5);
    plan->count = 0; /* a run would be in the way */
    add_command(plan, at_s, TUMBLE_COMMAND_HOME_AXIS, 0);
    if (turns) {
        add_command(plan, moves_s, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = draw(stream, 200.0, 399.0);
    } else if (bench_chance(stream, 0.8)) {
        (void)add_fault(plan, SIM_FAULT_HOMING_ENDLESS, draw(stream, 0.0, 2.0), FOR_GOOD);
    }
    if (bench_chance(stream, 0.3)) { /* the stranger knows the key */
        bench_event_t *const key = add_event(plan, BENCH_HOSTILE_SDO_NAVCOMP, writes_s - 0.1);
        bench_frame_write(&key->frame, 1, 0x2006, 1, 4, TUMBLE_SERVICE_KEY);
    }
    for (uint32_t i = 1U + bench_pick(stream, 2); i > 0U; i--) {
        bench_event_t *const event = add_event(plan, BENCH_HOSTILE_SDO_NAVCOMP, writes_s);
        draw_stop_write(stream, &event->frame);
    }
    bench_event_t *const abort = add_command(plan, writes_s + draw(stream, 0.05, 3.0), TUMBLE_COMMAND_ABORT, 0);
    abort->by_host = bench_chance(stream, 0.3);
}

static void lose_the_mark(bench_plan_t *plan, sim_random_t *stream)
{
    const sim_fault_kind_t kind = bench_chance(stream, 0.7) ? SIM_FAULT_HOMING_ENDLESS : SIM_FAULT_HOMING_FAILS;
    const double at_s = draw(stream, 0.0, 1.0);
    (void)add_fault(plan, kind, at_s, bench_chance(stream, 0.7) ? FOR_GOOD : draw(stream, 10.0, 60.0));
    if (bench_chance(stream, 0.4)) {
        add_command(plan, at_s + 1.0, TUMBLE_COMMAND_HOME_AXIS, 0);
    }
}

/* Position reports that nobody sent, while nothing moves: each a part of a turn further than the one before. */
static void garble_the_count(bench_plan_t *plan, sim_random_t *stream)
{
    static const double STEPS_DEG[] = {120.0, -120.0, 120.0, -120.0, 90.0, -90.0, 170.0, 240.0};
    static const uint32_t STATES[] = {1U << TUMBLE_STATE_WAIT_MOUNTING, 1U << TUMBLE_STATE_WAIT_MOUNTING,
                                      1U << TUMBLE_STATE_DONE, 1U << TUMBLE_STATE_AVERAGE | 1U << TUMBLE_STATE_SETTLE,
                                      1U << TUMBLE_STATE_MOVE};
    bench_event_t *const event = add_event(plan, BENCH_HOSTILE_POSITION, draw(stream, 10.0, 60.0));
    event->moment.states = ONE_OF(stream, STATES);
    event->moment.delay_us = (uint32_t)draw(stream, 5000.0, 250000.0);
    event->angle_deg = ONE_OF(stream, STEPS_DEG);
    event->count = 1U + bench_pick(stream, 3);
    if (bench_chance(stream, 0.4)) {
        event->kind = BENCH_HOSTILE_NEAR_POSITION;
        draw_near_positions(stream, event);
    }
    plan->attendant.errs = false;
    if (event->moment.states == 1U << TUMBLE_STATE_DONE) {
        bench_event_t *const turn = add_command(plan, 1e-6 * (double)event->moment.at_us, TUMBLE_COMMAND_TURN_AXIS, 0);
        turn->moment.states = event->moment.states;
        turn->moment.delay_us = event->moment.delay_us + (uint32_t)draw(stream, 1e5, 2e6);
        turn->angle_deg = draw(stream, -30.0, 400.0);
    }
}

/* The limits first, then set-points, each less than half a turn off: by the shorter way of a drive that wraps. */
static void lead_away(bench_plan_t *plan, sim_random_t *stream, double at_s)
{
    const double sign = bench_chance(stream, 0.5) ? 1.0 : -1.0;
    const uint32_t count = 1U + bench_pick(stream, 5);
    bench_frame_write(&add_event(plan, BENCH_HOSTILE_SDO_DRIVE, at_s - 0.1)->frame, 2, TUMBLE_402_SOFTWARE_LIMIT, 1, 4,
                      0x80000001U);
    bench_frame_write(&add_event(plan, BENCH_HOSTILE_SDO_DRIVE, at_s - 0.05)->frame, 2, TUMBLE_402_SOFTWARE_LIMIT, 2, 4,
                      0x7FFFFFFFU);
    for (uint32_t i = 0; i < count; i++) {
        bench_event_t *const event = add_event(plan, BENCH_HOSTILE_SDO_SET_POINT, at_s + 0.8 * i);
        draw_set_point(stream, event);
        if (i > 0U) {
            event->relative = true;
            event->angle_deg = sign * draw(stream, 100.0, 175.0);
        }
    }
}

/* The table turns by command, alone on the stand, and something is wrong with what moves it or tells where it is. */
static void spoil_a_motion(bench_plan_t *plan, sim_random_t *stream)
{
    static const sim_fault_kind_t KINDS[] = {SIM_FAULT_RUNAWAY, SIM_FAULT_RUNAWAY, SIM_FAULT_FROZEN_POSITION,
                                             SIM_FAULT_POSITION_SCALE};
    const double at_s = draw(stream, 2.0, 8.0);
    const bool homes = bench_chance(stream, 0.4);
    const double moves_s = at_s + (homes ? 0.0 : 16.0);
    const double spoils_s = moves_s + draw(stream, -0.5, 2.5);
    const uint32_t what = bench_pick(stream, 10);
    plan->count = 0; /* a run would be in the way */
    add_command(plan, at_s, TUMBLE_COMMAND_HOME_AXIS, 0);
    if (!homes) {
        const double angle_deg = bench_chance(stream, 0.5) ? draw(stream, -30.0, 400.0) : 400.0;
        add_command(plan, moves_s, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = angle_deg;
    }
    if (homes && bench_chance(stream, 0.5)) {
        (void)add_fault(plan, SIM_FAULT_HOMING_ENDLESS, at_s - 1.0, FOR_GOOD);
    }
    if (what < 4U) {
        sim_fault_t *const fault = add_fault(plan, KINDS[what], spoils_s, FOR_GOOD);
        draw_value(stream, fault);
    } else if (what < 6U) {
        plan->config.scenario.drive.speed_deg_s = 90.0; /* which makes such steps plausible */
        plan->config.profile.velocity_deg_s = 0.0;
        draw_near_positions(stream, add_event(plan, BENCH_HOSTILE_NEAR_POSITION, spoils_s));
        add_command(plan, moves_s + 12.0, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = 395.0;
    } else if (what < 8U) {
        lead_away(plan, stream, spoils_s);
    } else {
        plan->config.profile.velocity_deg_s = 0.5 * plan->config.scenario.drive.speed_deg_s;
        draw_read_back_write(stream, &add_event(plan, BENCH_HOSTILE_SDO_DRIVE, spoils_s)->frame);
        add_command(plan, moves_s + 30.0, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = 185.0;
        add_command(plan, moves_s + 50.0, TUMBLE_COMMAND_TURN_AXIS, 0)->angle_deg = -25.0;
    }
}

/* A result waits for its operator, and power is lost. */
static void leave_a_proposal(bench_plan_t *plan, sim_random_t *stream)
{
    bench_event_t *const cut = add_event(plan, BENCH_HOSTILE_CUT, 10.0);
    cut->off_us = (uint32_t)draw(stream, 1e4, 8e6);
    cut->moment.states = 1U << TUMBLE_STATE_DONE;
    cut->moment.delay_us = (uint32_t)draw(stream, 1e3, 15e6);
    cut->count = bench_chance(stream, 0.5) ? 1U : 0U;
    plan->has_set = false;
    plan->config.keeping.first = false;
}

static void command_the_drive(bench_plan_t *plan, sim_random_t *stream)
{
    const bench_hostile_t kind = bench_chance(stream, 0.5) ? BENCH_HOSTILE_SET_POINT : BENCH_HOSTILE_SDO_SET_POINT;
    bench_event_t *const event = add_event(plan, kind, draw(stream, 1.0, 1e-6 * (double)plan->lasts_us));
    draw_set_point(stream, event);
    if (bench_chance(stream, 0.5)) {
        event->moment.states = bench_chance(stream, 0.5) ? 1U << TUMBLE_STATE_IDLE : 1U << TUMBLE_STATE_WAIT_MOUNTING;
    }
}

static void draw_scene(bench_plan_t *plan)
{
    static void (*const SCENES[])(bench_plan_t *plan, sim_random_t *stream) = {
        void_the_stop,  lose_the_mark,  garble_the_count, garble_the_count, command_the_drive,
        spoil_a_motion, spoil_a_motion, spoil_a_motion,   leave_a_proposal};
    sim_random_t stream = open_stream(plan, STREAM_SCENES);
    if (bench_chance(&stream, 0.4)) {
        ONE_OF(&stream, SCENES)(plan, &stream);
    }
}
/* Frames by themselves. */

/* What commands or rewrites the drive itself excuses much (hostile.h), and so comes in few lives. */
static bench_hostile_t draw_kind(sim_random_t *stream, bool spares_drive)
{
    const uint32_t first = BENCH_HOSTILE_SDO_NAVCOMP;
    bench_hostile_t kind = (bench_hostile_t)(first + bench_pick(stream, BENCH_HOSTILE_KINDS - first));
    if (spares_drive &&
        (kind == BENCH_HOSTILE_SDO_DRIVE || kind == BENCH_HOSTILE_SET_POINT || kind == BENCH_HOSTILE_SDO_SET_POINT)) {
        kind = BENCH_HOSTILE_SDO_NAVCOMP;
    }
    return kind;
}

static uint32_t draw_count(sim_random_t *stream)
{
    const double kind = draw(stream, 0.0, 1.0);
    return (kind < 0.4) ? 0U : (kind < 0.95) ? 1U + bench_pick(stream, 16) : BURST_FRAMES;
}

static void draw_frames(bench_plan_t *plan)
{
    sim_random_t stream = open_stream(plan, STREAM_FRAMES);
    const uint32_t count = draw_count(&stream);
    const bool spares_drive = bench_chance(&stream, 0.85);
    const double from_s = draw(&stream, 0.0, 0.8e-6 * (double)plan->lasts_us);
    const double for_s = bench_chance(&stream, 0.5) ? 5.0 : 1e-6 * (double)plan->lasts_us;
    for (uint32_t i = 0; i < count; i++) {
        const bench_hostile_t kind = draw_kind(&stream, spares_drive);
        draw_content(&stream, add_event(plan, kind, from_s + draw(&stream, 0.0, for_s)));
    }
}
/* The whole. */

/* Before the next event of the same time comes the one drawn before. */
static int compare(const void *a, const void *b)
{
    const bench_event_t *const one = a;
    const bench_event_t *const other = b;
    if (one->moment.at_us != other->moment.at_us) {
        return (one->moment.at_us < other->moment.at_us) ? -1 : 1;
    }
    return (one->number < other->number) ? -1 : 1;
}

const char *bench_plan_draw(bench_plan_t *plan, uint64_t seed)
{
    memset(plan, 0, sizeof *plan);
    plan->seed = seed;
    draw_world(plan);
    draw_course(plan);
    draw_faults(plan);
    draw_cuts(plan);
    draw_scene(plan);
    draw_frames(plan);
    qsort(plan->events, plan->count, sizeof plan->events[0], compare);
    const char *const wrong = bench_config_complete(&plan->config);
    return (wrong != NULL) ? wrong : bench_config_refused(&plan->config);
}
