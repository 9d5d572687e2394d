/* Fuzzing the navigation computer: any frames, commands, moods of the port and jumps of the clock, in any order, with a
 * drive and a block that behave in between, so that every state of a run is reached.
 *
 * The first byte of the input chooses where in a run it begins; then come records of an opcode byte and its operands.
 * The harness makes the checksum of most block frames right, and can give both frames of a sample that comes next in
 * order: behind an unrepaired checksum, and without the counters' order, hardly a byte of the input would be looked at.
 * What is checked beside the sanitizers: the invariants in `check`.
 */
#include "fake_port.h"
#include "fuzz_input.h"
#include "scripted_config.h"
#include "tumble/navcomp.h"

const size_t fuzz_header_bytes = 1;
const size_t fuzz_record_bytes = 13; /* an opcode, and a frame of any identifier and length with what kind it is */

#define MAX_RECORDS 24U /* longer inputs are slow, and reach nothing that shorter ones do not */

typedef struct {
    fake_port_t fake;
    scripted_drive_t drive;
    scripted_block_t block;
    tumble_navcomp_t navcomp;
    tumble_drive402_t axis; /* what navcomp knows of the drive */
    tumble_second_client_t second_client;
    tumble_navcomp_counters_t before;
    uint32_t averaged;
} world_t;

static world_t world;

static void on_sample_averaged(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    world_t *at = context;
    if ((taken.index >= tumble_schedule_paper.position_count) || (taken.ordinal < 1U) || (taken.ordinal > 0x100000U) ||
        (sample == NULL)) {
        abort();
    }
    at->averaged++;
}

static const tumble_navcomp_hooks_t hooks = {.context = &world, .on_sample_averaged = on_sample_averaged};

static tumble_averaging_config_t averaging;
static tumble_procedure_config_t procedure;
static tumble_navcomp_config_t config;

static void configure(void)
{
    averaging = scripted_averaging;
    averaging.stuck_run = 4; /* no more than the samples of a position */
    procedure = scripted_procedure;
    procedure.averaging = &averaging;
    procedure.estimate = TUMBLE_ESTIMATE_LEAST_SQUARES;
    procedure.samples = 4;
    procedure.settle_ms = 20;
    procedure.retries = 3;
    config = scripted_navcomp;
    config.port = &world.fake.port;
    config.procedure = &procedure;
    config.hooks = &hooks;
    config.stand_memory = &world.axis;
    config.stand_bytes = sizeof world.axis;
    config.second_client = &world.second_client;
}

/* Every number of the counters, which are all 32 bits wide, only grows. */
static void check_counters(void)
{
    tumble_navcomp_counters_t now;
    tumble_navcomp_counters(&world.navcomp, &now);
    const uint32_t *after = (const uint32_t *)&now;
    const uint32_t *before = (const uint32_t *)&world.before;
    for (size_t i = 0; i < (sizeof now / sizeof *after); i++) {
        const bool of_a_run = (&after[i] >= (const uint32_t *)&now.averaging); /* these two begin anew with a run */
        require(of_a_run || (after[i] >= before[i]), "counters only grow");
    }
    world.before = now;
}

static void check(void)
{
    tumble_navcomp_progress_t progress;
    tumble_result_t result;
    tumble_navcomp_progress(&world.navcomp, &progress);
    require((unsigned)progress.run.state < (unsigned)TUMBLE_STATE_COUNT, "the state is in the list");
    require((unsigned)progress.run.reason < (unsigned)TUMBLE_REASON_COUNT, "the reason is in the list");
    require(progress.run.index < tumble_schedule_paper.position_count, "the position is in the schedule");
    require(progress.run.finished <= tumble_schedule_paper.position_count, "no more positions than there are");
    require((progress.run.state != TUMBLE_STATE_FAULT) || (progress.run.reason != TUMBLE_REASON_NONE),
            "a fault has a reason");
    if (tumble_navcomp_result(&world.navcomp, &result) == TUMBLE_OK) {
        require(progress.run.finished == tumble_schedule_paper.position_count, "a result rests on every position");
    }
    check_counters();
}

static void deliver(void)
{
    tumble_can_frame_t frame;
    while (fake_port_take(&world.fake, &frame)) {
        require((frame.id <= TUMBLE_CAN_MAX_ID) && (frame.length <= TUMBLE_CAN_MAX_BYTES), "a frame is well formed");
        scripted_drive_hear(&world.drive, &world.fake, &frame);
        scripted_block_hear(&world.block, &world.fake, &frame);
    }
}

/* Step for as long as something is due at once, which must come to an end. */
static void step(void)
{
    int steps = 0;
    do {
        tumble_navcomp_step(&world.navcomp);
        deliver();
        require(++steps < 1000, "a step comes to an end");
    } while (tumble_navcomp_next_deadline_us(&world.navcomp) <= world.fake.now_us);
}

static uint64_t earliest(uint64_t a_us, uint64_t b_us)
{
    return (a_us < b_us) ? a_us : b_us;
}

/* Let the well-behaved world go on for a while. */
static void pass(uint64_t us)
{
    const uint64_t end_us = world.fake.now_us + us;
    while (world.fake.now_us < end_us) {
        scripted_drive_step(&world.drive, &world.fake);
        scripted_block_step(&world.block, &world.fake, scripted_drive_angle_deg(&world.drive));
        step();
        uint64_t next_us = tumble_navcomp_next_deadline_us(&world.navcomp);
        next_us = earliest(next_us, scripted_drive_next_us(&world.drive));
        next_us = earliest(next_us, scripted_block_next_us(&world.block));
        world.fake.now_us = (next_us > world.fake.now_us) ? earliest(next_us, end_us) : (world.fake.now_us + 1U);
    }
}

/* Mostly identifiers that somebody listens to. */
static void give_frame(input_t *input)
{
    static const uint16_t ids[] = {0x000, 0x082, 0x083, 0x182, 0x282, 0x582, 0x601, 0x401, 0x683, 0x693, 0x702, 0x703};
    const uint8_t choice = take(input);
    tumble_can_frame_t frame = {.id = ids[choice % (sizeof ids / sizeof ids[0])], .length = 8};
    if (choice >= 240U) {
        frame.id = (uint16_t)(take(input) << 8U);
        frame.id = (uint16_t)(frame.id | take(input));
        frame.length = take(input);
    } else if (choice >= 200U) {
        frame.length = take(input) % 9U;
    } else if (frame.id >= 0x700U) {
        frame.length = 1;
    } else if (frame.id == 0U) {
        frame.length = 2;
    } else {
        /* eight bytes */
    }
    for (unsigned i = 0; (i < frame.length) && (i < TUMBLE_CAN_MAX_BYTES); i++) {
        frame.data[i] = take(input);
    }
    if (((frame.id & 0x7EFU) == (TUMBLE_BLOCK_ID_XY & 0x7EFU)) && ((choice % 4U) != 0U)) {
        frame.data[7] = tumble_block_frame_crc(&frame);
    }
    fake_port_give(&world.fake, &frame);
}

static int32_t take_int24(input_t *input)
{
    uint32_t bits = take(input);
    bits |= (uint32_t)take(input) << 8U;
    bits |= (uint32_t)take(input) << 16U;
    return (int32_t)(bits ^ 0x800000U) - 0x800000;
}

/* Any values as the block's next sample but for a few that are missing, whole or in part. */
static void give_sample(input_t *input)
{
    enum { OFFSET = 0x80, NO_FIRST = 0x40, NO_SECOND = 0x20, SICK = 0x10, MISSING = 0x03 };
    enum { INT24_MAX = 8388607, INT24_MIN = -8388608 };
    const uint8_t how = take(input);
    sim_block_frames_t frames;
    tumble_block_sample_t sample = {.timestamp_ms = (uint16_t)((world.fake.now_us / 1000U) % 4096U),
                                    .temperature_half_c = (int8_t)take(input)};
    const uint8_t status = take(input);
    sample.raw.status = ((how & SICK) != 0U) ? (status & 0x0FU) : 0U;
    const tumble_procedure_t *procedure_now = tumble_navcomp_procedure(&world.navcomp);
    const tumble_open_position_t *open = &tumble_procedure_averages(procedure_now)->open;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const int32_t last = ((how & OFFSET) != 0U) ? open->last[i] : 0;
        const int32_t counts = last + (take_int24(input) >> ((last != 0) ? 8 : 0));
        sample.raw.counts[i] = (counts > INT24_MAX) ? INT24_MAX : (counts < INT24_MIN) ? INT24_MIN : counts;
    }
    world.block.counter = (uint16_t)(world.block.counter + (how & MISSING));
    sample.raw.counter = world.block.counter++;
    sim_block_encode(&sample, &frames);
    if ((how & NO_FIRST) == 0U) {
        fake_port_give(&world.fake, &frames.xy);
    }
    if ((how & NO_SECOND) == 0U) {
        fake_port_give(&world.fake, &frames.z);
    }
}

static void change_the_world(input_t *input)
{
    const uint8_t what = take(input);
    world.drive.jammed = (what & 1U) != 0U;
    world.drive.dead = (what & 2U) != 0U;
    world.block.dead = (what & 4U) != 0U;
    world.block.status = (what >> 3U) & 3U;
    world.block.mounting = &tumble_schedule_paper.mountings[(what >> 5U) & 1U];
    if ((what & 0x40U) != 0U) {
        scripted_drive_boot(&world.drive, &world.fake);
    }
    if ((what & 0x80U) != 0U) {
        scripted_block_boot(&world.block, &world.fake);
    }
}

static void change_the_port(input_t *input)
{
    static const tumble_status_t sending[] = {TUMBLE_OK, TUMBLE_OK, TUMBLE_E_PORT_BUSY, TUMBLE_E_PORT_DOWN,
                                              TUMBLE_E_RANK};
    static const tumble_status_t receiving[] = {TUMBLE_OK, TUMBLE_OK, TUMBLE_OK, TUMBLE_E_PORT_DOWN, TUMBLE_E_RANK};
    const uint8_t what = take(input);
    world.fake.send_status = sending[what % 5U];
    world.fake.receive_status = receiving[(what / 5U) % 5U];
    world.fake.send_room = ((what & 0x80U) != 0U) ? (what & 3U) : SIZE_MAX;
}

/* The operator who does what is asked. */
static void confirm(void)
{
    tumble_navcomp_progress_t progress;
    tumble_navcomp_progress(&world.navcomp, &progress);
    if (progress.run.state == TUMBLE_STATE_WAIT_MOUNTING) {
        world.block.mounting = &tumble_schedule_paper.mountings[progress.run.mounting - 1U];
        (void)tumble_navcomp_command(&world.navcomp, TUMBLE_COMMAND_CONFIRM_MOUNTING, progress.run.mounting);
    }
}

static void command(input_t *input)
{
    const tumble_command_t given = (tumble_command_t)(take(input) % 12U);
    (void)tumble_navcomp_command(&world.navcomp, given, take(input) % 20U);
}

static void act(input_t *input)
{
    switch (take(input) % 14U) {
    case 0:
    case 1:
    case 2:
        give_frame(input);
        break;
    case 3:
        step();
        break;
    case 10:
    case 11:
    case 12:
        give_sample(input);
        step();
        break;
    case 4:
        pass(UINT64_C(1000) << (take(input) % 8U));
        break;
    case 5:
        command(input);
        break;
    case 6:
        confirm();
        break;
    case 7:
        change_the_world(input);
        break;
    case 8:
        change_the_port(input);
        break;
    default: { /* the clock jumps, for the drive too: it would live through days, millisecond by millisecond */
        const unsigned exponent = take(input) % 40U;
        world.fake.now_us += UINT64_C(1) << exponent;
        world.drive.clock_ms = world.fake.now_us / 1000U;
        break;
    }
    }
}

/* Where an input may begin: power-on, a run just started, waiting for the first mounting, in the first mean, waiting
 * for the second mounting, and done. Prepared once, because the way there is long. */
#define BEGINNINGS 6
static world_t beginnings[BEGINNINGS];

static void run_to(tumble_state_t state)
{
    tumble_navcomp_progress_t progress;
    do {
        pass(1000); /* so finely that an open mean holds nothing yet */
        tumble_navcomp_progress(&world.navcomp, &progress);
        require(progress.run.state != TUMBLE_STATE_FAULT, "the way to a beginning is free");
    } while (progress.run.state != state);
}

static void prepare(void)
{
    configure();
    fake_port_init(&world.fake);
    scripted_drive_init(&world.drive, &world.fake);
    scripted_block_init(&world.block, &world.fake, &tumble_schedule_paper.mountings[0]);
    require(tumble_navcomp_init(&world.navcomp, &config) == TUMBLE_OK, "the configuration is good");
    beginnings[0] = world;
    (void)tumble_navcomp_command(&world.navcomp, TUMBLE_COMMAND_START, 0);
    beginnings[1] = world;
    run_to(TUMBLE_STATE_WAIT_MOUNTING);
    beginnings[2] = world;
    confirm();
    run_to(TUMBLE_STATE_AVERAGE);
    beginnings[3] = world;
    run_to(TUMBLE_STATE_WAIT_MOUNTING);
    beginnings[4] = world;
    confirm();
    run_to(TUMBLE_STATE_DONE);
    beginnings[5] = world;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const size_t longest = fuzz_header_bytes + (MAX_RECORDS * fuzz_record_bytes);
    input_t input = {data, (size < longest) ? size : longest};
    if (beginnings[0].navcomp.config == NULL) {
        prepare();
    }
    world = beginnings[take(&input) % BEGINNINGS];
    while (input.left > 0U) {
        input_t record = cut(&input, fuzz_record_bytes);
        act(&record);
        check();
    }
    return 0;
}
