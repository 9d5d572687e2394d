/* Frames that a stranger, or a node gone mad, puts on the bus. */
#include "world/hostile.h"

#include "core/bytes.h"

#define BURST_FRAMES 150U

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint32_t value;
} write_t;

#define COUNT(list) (sizeof(list) / sizeof((list)[0]))

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

void bench_draw_stop_write(sim_random_t *stream, tumble_can_frame_t *frame)
{
    write_of(frame, 1, &STOP_WRITES[bench_pick(stream, COUNT(STOP_WRITES))]);
}

void bench_draw_read_back_write(sim_random_t *stream, tumble_can_frame_t *frame)
{
    write_of(frame, 2, &READ_BACK[bench_pick(stream, COUNT(READ_BACK))]);
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
        bench_draw_stop_write(stream, frame);
    } else if (bench_chance(stream, 0.7)) {
        write_of(frame, 1, &OTHER_WRITES[bench_pick(stream, COUNT(OTHER_WRITES))]);
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
        bench_draw_read_back_write(stream, frame);
    } else if (bench_chance(stream, 0.7)) {
        write_of(frame, 2, &DRIVE_COMMANDS[bench_pick(stream, COUNT(DRIVE_COMMANDS))]);
    } else {
        write_of(frame, 2, &DRIVE_SETTINGS[bench_pick(stream, COUNT(DRIVE_SETTINGS))]);
    }
}

static void draw_answer(sim_random_t *stream, tumble_can_frame_t *frame)
{
    static const uint8_t COMMANDS[] = {0x60, 0x43, 0x4B, 0x4F, 0x80, 0x20, 0x00};
    static const uint16_t INDICES[] = {0x607A, 0x6040, 0x1016, 0x1017, 0x1400, 0x1600, 0x6081, 0x6060};
    fill(stream, frame, bench_chance(stream, 0.9) ? 0x582 : 0x583, 8);
    frame->data[0] = COMMANDS[bench_pick(stream, COUNT(COMMANDS))];
    tumble_put_u16(&frame->data[1], INDICES[bench_pick(stream, COUNT(INDICES))]);
    frame->data[3] = (uint8_t)bench_pick(stream, 3);
}

static void draw_nmt(sim_random_t *stream, tumble_can_frame_t *frame)
{
    static const uint8_t COMMANDS[] = {0x01, 0x02, 0x80, 0x81, 0x82, 0x55};
    *frame = (tumble_can_frame_t){.id = 0, .length = 2};
    frame->data[0] = COMMANDS[bench_pick(stream, COUNT(COMMANDS))];
    frame->data[1] = (uint8_t)bench_pick(stream, 5);
}

static void draw_heartbeat(sim_random_t *stream, tumble_can_frame_t *frame)
{
    static const uint8_t STATES[] = {0x00, 0x04, 0x05, 0x7F, 0x85, 0x33};
    *frame = (tumble_can_frame_t){.id = (uint16_t)(0x701U + bench_pick(stream, 4)), .length = 1};
    frame->data[0] = STATES[bench_pick(stream, COUNT(STATES))];
}

/* Some within the window in which the drive is at its target. */
void bench_draw_set_point(sim_random_t *stream, bench_event_t *event)
{
    event->relative = bench_chance(stream, 0.3);
    event->angle_deg = event->relative ? bench_draw(stream, -0.2, 0.2) : bench_draw(stream, -1500.0, 1500.0);
}

/* Eight of 45 deg are a turn. */
void bench_draw_near_positions(sim_random_t *stream, bench_event_t *event)
{
    const double sign = bench_chance(stream, 0.5) ? 1.0 : -1.0;
    event->count = 7U + bench_pick(stream, 4);
    event->angle_deg = sign * (bench_chance(stream, 0.5) ? 360.0 / event->count : bench_draw(stream, 30.0, 45.0));
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
        bench_draw_set_point(stream, event);
        break;
    case BENCH_HOSTILE_NEAR_POSITION:
        bench_draw_near_positions(stream, event);
        break;
    case BENCH_HOSTILE_POSITION:
        event->angle_deg = bench_draw(stream, -360.0, 360.0);
        event->count = 1U + bench_pick(stream, 4);
        break;
    case BENCH_HOSTILE_SAMPLE:
    case BENCH_HOSTILE_SPOILT_SAMPLE:
        event->counts = (int32_t)bench_draw(stream, -2e6, 2e6);
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
    const double kind = bench_draw(stream, 0.0, 1.0);
    return (kind < 0.4) ? 0U : (kind < 0.95) ? 1U + bench_pick(stream, 16) : BURST_FRAMES;
}

void bench_plan_frames(bench_plan_t *plan)
{
    sim_random_t stream;
    sim_random_open(&stream, plan->seed, SIM_CAUSE_LIFE, BENCH_STREAM_FRAMES);
    const uint32_t count = draw_count(&stream);
    const bool spares_drive = bench_chance(&stream, 0.85);
    const double from_s = bench_draw(&stream, 0.0, 0.8e-6 * (double)plan->lasts_us);
    const double for_s = bench_chance(&stream, 0.5) ? 5.0 : 1e-6 * (double)plan->lasts_us;
    for (uint32_t i = 0; i < count; i++) {
        const bench_hostile_t kind = draw_kind(&stream, spares_drive);
        draw_content(&stream, bench_plan_add(plan, kind, from_s + bench_draw(&stream, 0.0, for_s)));
    }
}
