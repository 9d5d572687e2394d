/* The other ends of the seams: samples from a board's own converter; and as the stand a person at a dividing head, a motor
 * controller with registers, a kind of one's own. */
#include "navcomp_bench.h"
#include "played_positioner.h"
#include "stand/operator/operator.h"

/* A converter: what the block would have sent over the bus, without the bus. */
static struct {
    tumble_block_sample_t queue[64];
    size_t first;
    size_t count;
    tumble_status_t failing; /* returned once instead of a sample */
    uint64_t next_us;
    uint16_t counter;
} converter;

/* A kind of stand of one's own: a table that is wherever it is told to be. */
typedef struct {
    tumble_stand_report_t report;
    double angle_deg;
    uint8_t state; /* tumble_stand_state_t */
} instant_table_t;

static tumble_status_t table_init(void *self, const tumble_stand_setup_t *setup)
{
    (void)setup;
    ((instant_table_t *)self)->state = (uint8_t)TUMBLE_STAND_READY;
    return TUMBLE_OK;
}

static void table_step(void *self, uint64_t now_us)
{
    (void)self;
    (void)now_us;
}

static uint64_t table_next_us(const void *self)
{
    (void)self;
    return UINT64_MAX;
}

static tumble_status_t table_move(void *self, double angle_deg)
{
    instant_table_t *table = self;
    table->angle_deg = angle_deg;
    table->state = (uint8_t)TUMBLE_STAND_IN_POSITION;
    return TUMBLE_OK;
}

static tumble_status_t table_home(void *self)
{
    return table_move(self, 0.0);
}

static void table_stop(void *self)
{
    (void)self;
}

static tumble_status_t table_clear_fault(void *self)
{
    (void)self;
    return TUMBLE_E_STAND_STATE;
}

static tumble_stand_state_t table_state(const void *self)
{
    return (tumble_stand_state_t)((const instant_table_t *)self)->state;
}

static tumble_stand_fault_t table_fault(const void *self)
{
    (void)self;
    return TUMBLE_STAND_FAULT_NONE;
}

static double table_angle_deg(const void *self)
{
    return ((const instant_table_t *)self)->angle_deg;
}

static const tumble_stand_kind_t instant_table_kind = {
    .bytes = (uint16_t)sizeof(instant_table_t),
    .report_at = (uint16_t)offsetof(instant_table_t, report),
    TUMBLE_STAND_FUNCTIONS(table),
};

static double head_deg;

static tumble_status_t take(void *context, tumble_block_sample_t *sample)
{
    TEST_ASSERT_EQUAL_PTR(&converter, context);
    if (converter.failing != TUMBLE_OK) {
        const tumble_status_t failing = converter.failing;
        converter.failing = TUMBLE_OK;
        return failing;
    }
    if (converter.count == 0U) {
        return TUMBLE_E_PORT_EMPTY;
    }
    *sample = converter.queue[converter.first];
    converter.first = (converter.first + 1U) % 64U;
    converter.count--;
    return TUMBLE_OK;
}

static const tumble_sample_source_t source = {.context = &converter, .take = take};
static tumble_operator_t head;
static instant_table_t table;
static played_positioner_t controller;
static tumble_positioner_profile_t registers;
static tumble_positioner_t axis;
static const tumble_operator_config_t operator = {.tolerance_deg = 0.5, .timeout_ms = 60000};

static void set_up(void)
{
    memset(&converter, 0, sizeof converter);
    head_deg = 0.0;
    bench_init(&bench);
    played_positioner_init(&controller);
    registers = played_positioner_profile(&controller);
}

static void tear_down(void)
{
    TEST_ASSERT_NULL_MESSAGE(controller.wrong, controller.wrong);
}

static void convert(double angle_deg)
{
    double u_v[3];
    tumble_block_sample_t sample = {
        .raw = {.counter = converter.counter},
        .timestamp_ms = (uint16_t)((bench.fake.now_us / 1000U) % TUMBLE_TIMESTAMP_PERIOD_MS),
    };
    scripted_block_outputs(&bench.block, angle_deg, u_v);
    for (int i = 0; i < 3; i++) {
        sample.raw.counts[i] = (int32_t)lround(u_v[i] / 1e-6) + ((int32_t)(converter.counter % 3U) - 1);
    }
    converter.queue[(converter.first + converter.count) % 64U] = sample;
    converter.count++;
    converter.counter++;
}

static void use_converter(void)
{
    bench.config.source = &source;
    bench.block.dead = true;
    fake_port_init(&bench.fake);
    scripted_drive_init(&bench.drive, &bench.fake);
}

static void use_stand(const tumble_stand_kind_t *kind, const void *profile, void *memory, uint32_t bytes)
{
    bench.config.stand = kind;
    bench.config.stand_profile = profile;
    bench.config.stand_memory = memory;
    bench.config.stand_bytes = bytes;
    bench.config.stand_node = 0;
    bench.drive.dead = true;
    fake_port_init(&bench.fake);
    scripted_block_init(&bench.block, &bench.fake, &tumble_schedule_paper.mountings[0]);
}

static void use_operator(void)
{
    use_stand(&tumble_operator_kind, &operator, &head, sizeof head);
}

/* The head is turned exactly where it is asked to be. */
static void turn_head(void)
{
    double asked_deg = 0.0;
    if (tumble_navcomp_request(&bench.navcomp, &asked_deg)) {
        head_deg = asked_deg;
        TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, TUMBLE_COMMAND_CONFIRM_ANGLE, 0));
    }
}

static double angle_deg(void)
{
    const tumble_stand_kind_t *const kind = bench.config.stand;
    return (kind == &instant_table_kind)       ? table.angle_deg
           : (kind == &tumble_operator_kind)   ? head_deg
           : (kind == &tumble_positioner_kind) ? played_positioner_angle_deg(&controller)
                                               : scripted_drive_angle_deg(&bench.drive);
}

static void one_millisecond(void)
{
    tumble_can_frame_t frame;
    tumble_navcomp_step(&bench.navcomp);
    while (fake_port_take(&bench.fake, &frame)) {
        bench_hear(&bench, &frame);
    }
    scripted_drive_step(&bench.drive, &bench.fake);
    scripted_block_step(&bench.block, &bench.fake, angle_deg());
    if ((bench.config.source != NULL) && ((bench.fake.now_us % 10000U) == 0U)) {
        convert(angle_deg());
    }
    bench_operate(&bench);
    bench.fake.now_us += 1000U;
    played_positioner_step(&controller);
}

static void milliseconds(int ms)
{
    for (; ms > 0; ms--) {
        one_millisecond();
    }
}

static void order(tumble_command_t command)
{
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_command(&bench.navcomp, command, 0));
}

static void assert_ends(tumble_state_t state, int most_ms)
{
    for (int ms = 0; (ms < most_ms) && (bench_progress(&bench).run.state != state); ms++) {
        one_millisecond();
    }
    TEST_ASSERT_EQUAL(state, bench_progress(&bench).run.state);
}

static void assert_reason(const char *reason)
{
    TEST_ASSERT_EQUAL_STRING(reason, tumble_reason_name(bench_progress(&bench).run.reason));
}

static void assert_calibrates(void)
{
    order(TUMBLE_COMMAND_START);
    tumble_navcomp_progress_t progress = bench_progress(&bench);
    for (int ms = 0; (ms < 600000) && (progress.run.state != TUMBLE_STATE_DONE); ms++) {
        one_millisecond();
        turn_head();
        progress = bench_progress(&bench);
        TEST_ASSERT_TRUE_MESSAGE(progress.run.state != TUMBLE_STATE_FAULT, tumble_reason_name(progress.run.reason));
    }
    assert_right_coefficients();
}

static void test_a_boards_own_converter(void)
{
    use_converter();
    bench_power_on(&bench);
    assert_calibrates();
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).block.samples);
    TEST_ASSERT_EQUAL_UINT32(18U * BENCH_SAMPLES, bench_counters(&bench).procedure.averaged);
}

/* Frames of a block that is not wanted are frames like any other. */
static void test_with_a_converter_the_frames_of_a_block_are_ignored(void)
{
    use_converter();
    bench_power_on(&bench);
    const tumble_block_sample_t sample = {.raw = {.counts = {1, 2, 3}}};
    sim_block_frames_t frames;
    sim_block_encode(&sample, &frames);
    fake_port_give(&bench.fake, &frames.xy);
    fake_port_give(&bench.fake, &frames.z);
    tumble_navcomp_step(&bench.navcomp);
    TEST_ASSERT_EQUAL_UINT32(2, bench_counters(&bench).events.frames_ignored);
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).block.samples);
}

static void test_a_spoilt_conversion_is_corrupted_and_a_lie_is_a_fault_of_the_source(void)
{
    use_converter();
    bench_power_on(&bench);
    converter.failing = TUMBLE_E_CRC;
    tumble_navcomp_step(&bench.navcomp);
    converter.failing = TUMBLE_E_FRAME;
    tumble_navcomp_step(&bench.navcomp);
    TEST_ASSERT_EQUAL_UINT32(2, bench_counters(&bench).events.source_corrupted);
    TEST_ASSERT_EQUAL_UINT32(2, bench_counters(&bench).procedure.corrupted);
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).events.source_faults);
    converter.failing = TUMBLE_E_RANK;
    tumble_navcomp_step(&bench.navcomp);
    TEST_ASSERT_EQUAL_UINT32(1, bench_counters(&bench).events.source_faults);
}

static tumble_status_t take_forever(void *context, tumble_block_sample_t *sample)
{
    uint32_t *taken = context;
    *sample = (tumble_block_sample_t){.raw = {.counter = (uint16_t)*taken}};
    (*taken)++;
    return TUMBLE_OK;
}

static void test_an_endless_source_does_not_hold_a_step(void)
{
    uint32_t taken = 0;
    const tumble_sample_source_t endless = {.context = &taken, .take = take_forever};
    use_converter();
    bench.config.source = &endless;
    bench_power_on(&bench);
    tumble_navcomp_step(&bench.navcomp);
    TEST_ASSERT_EQUAL_UINT32(TUMBLE_NAVCOMP_MAX_FRAMES_PER_STEP, taken);
    TEST_ASSERT_TRUE(tumble_navcomp_next_deadline_us(&bench.navcomp) <= bench.fake.now_us);
}

static void test_a_person_at_a_dividing_head(void)
{
    use_operator();
    bench_power_on(&bench);
    assert_calibrates();
}

static void test_a_person_and_a_converter(void)
{
    use_converter();
    use_operator();
    bench.block.dead = true;
    bench_power_on(&bench);
    assert_calibrates();
}

static void test_an_angle_far_from_the_one_asked_for_is_not_taken(void)
{
    double asked_deg = 0.0;
    use_operator();
    bench_power_on(&bench);
    order(TUMBLE_COMMAND_START);
    for (int ms = 0; (ms < 5000) && !tumble_navcomp_request(&bench.navcomp, &asked_deg); ms++) {
        one_millisecond();
    }
    TEST_ASSERT_TRUE(tumble_navcomp_request(&bench.navcomp, &asked_deg));
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, tumble_navcomp_confirm_angle(&bench.navcomp, asked_deg + 1.0));
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_confirm_angle(&bench.navcomp, asked_deg + 0.25));
    TEST_ASSERT_TRUE(bench_progress(&bench).angle_deg == (asked_deg + 0.25));
    TEST_ASSERT_EQUAL(0, tumble_navcomp_drive_refusal(&bench.navcomp).index);
}

static void test_a_person_who_does_not_answer_ends_the_run(void)
{
    use_operator();
    bench_power_on(&bench);
    order(TUMBLE_COMMAND_START);
    assert_ends(TUMBLE_STATE_FAULT, 200000);
    assert_reason("TUMBLE_REASON_HOMING");
}

/* Its file and the configuration are all that it takes. */
static void test_a_kind_of_stand_of_ones_own(void)
{
    use_stand(&instant_table_kind, NULL, &table, sizeof table);
    bench_power_on(&bench);
    const double asked_of_nobody_deg = 5.0;
    double asked_deg = asked_of_nobody_deg;
    TEST_ASSERT_FALSE(tumble_navcomp_request(&bench.navcomp, &asked_deg));
    TEST_ASSERT_TRUE(asked_deg == asked_of_nobody_deg);
    TEST_ASSERT_EQUAL(TUMBLE_E_STATE, tumble_navcomp_confirm_angle(&bench.navcomp, 0.0));
    assert_calibrates();
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).stop.implausible);
    TEST_ASSERT_EQUAL(TUMBLE_OK, tumble_navcomp_turn(&bench.navcomp, 33.0));
    TEST_ASSERT_TRUE(bench_progress(&bench).angle_deg == 33.0);
    bench.config.stand_node = 2;
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, tumble_navcomp_init(&bench.navcomp, &bench.config)); /* it is on no bus */
}

/* A motor controller with registers, from power-on to the coefficients. */

static void use_controller(void)
{
    use_stand(&tumble_positioner_kind, &registers, &axis, sizeof axis);
    bench_power_on(&bench);
}

static void run_to_a_move(void)
{
    use_controller();
    order(TUMBLE_COMMAND_START);
    for (int ms = 0; (ms < 600000) && (bench_progress(&bench).run.index != 2U); ms++) {
        one_millisecond();
    }
    assert_ends(TUMBLE_STATE_MOVE, 60000);
    for (int ms = 0; (ms < 1000) && !controller.moving; ms++) {
        one_millisecond();
    }
    TEST_ASSERT_TRUE(controller.moving);
}

static void assert_fault(const char *reason)
{
    assert_ends(TUMBLE_STATE_FAULT, 1000);
    assert_reason(reason);
    milliseconds(500);
    TEST_ASSERT_FALSE(controller.moving);
}

static void test_a_controller_calibrates(void)
{
    use_controller();
    order(TUMBLE_COMMAND_START);
    assert_ends(TUMBLE_STATE_DONE, 600000);
    assert_right_coefficients();
    TEST_ASSERT_EQUAL_UINT32(0, bench_counters(&bench).stop.implausible);
}

/* The stand cannot know, but the full circle does not close: the check above can fail. */
static void test_a_wrong_scale_of_the_angle_is_noticed(void)
{
    use_controller();
    registers.counts_per_deg = 1.01 * PLAYED_COUNTS_PER_DEG;
    order(TUMBLE_COMMAND_START);
    assert_ends(TUMBLE_STATE_FAULT, 600000);
    assert_reason("TUMBLE_REASON_SLIP");
    TEST_ASSERT_EQUAL(TUMBLE_STAND_FAULT_NONE, tumble_positioner_kind.fault(&axis));
}

static void test_a_link_that_dies_in_a_move_ends_the_run_which_goes_on_by_command(void)
{
    run_to_a_move();
    controller.dead = true;
    assert_fault("TUMBLE_REASON_STAND_HEARTBEAT");
    controller.dead = false;
    milliseconds(1000);
    order(TUMBLE_COMMAND_RESUME);
    assert_ends(TUMBLE_STATE_DONE, 600000);
    assert_right_coefficients();
}

static void test_abort_stops_the_table(void)
{
    run_to_a_move();
    order(TUMBLE_COMMAND_ABORT);
    milliseconds(100);
    TEST_ASSERT_FALSE(controller.moving);
    TEST_ASSERT_EQUAL(TUMBLE_STAND_STOPPED, tumble_positioner_kind.state(&axis));
}

static void test_a_fault_of_the_controller_tells_its_code(void)
{
    run_to_a_move();
    controller.fault = 0x77;
    controller.moving = false;
    assert_fault("TUMBLE_REASON_DRIVE_FAULT");
    TEST_ASSERT_EQUAL_UINT16(0x77, bench_progress(&bench).run.drive_code);
}

static void test_a_table_that_nothing_stops_is_told(void)
{
    run_to_a_move();
    controller.has_no_brake = true;
    order(TUMBLE_COMMAND_ABORT);
    milliseconds(3000);
    assert_reason("TUMBLE_REASON_STOP_NOT_CONFIRMED");
}
