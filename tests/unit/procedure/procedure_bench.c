#include "procedure_bench.h"

bench_t bench;

/* The fake stand's side of the interface. */

static bench_t *bench_of(void *self)
{
    return self;
}

static const fake_stand_t *stand_of(const void *self)
{
    return &((const bench_t *)self)->stand;
}

static tumble_status_t bench_home(void *self)
{
    bench_t *b = bench_of(self);
    if (b->stand.refuses_homing) {
        return TUMBLE_E_STAND_STATE;
    }
    b->stand.homes++;
    b->stand.state = TUMBLE_STAND_HOMING;
    b->stand.target_deg = 0.0;
    b->stand.arrives_us = b->now_us + MOVE_US;
    return TUMBLE_OK;
}

static tumble_status_t bench_move(void *self, double angle_deg)
{
    bench_t *b = bench_of(self);
    if (b->stand.refuses_moves) {
        return TUMBLE_E_STAND_STATE;
    }
    TEST_ASSERT_TRUE_MESSAGE(b->stand.moves < MAX_MOVES, "too many moves");
    b->stand.moves_deg[b->stand.moves++] = angle_deg;
    b->stand.state = TUMBLE_STAND_MOVING;
    b->stand.target_deg = angle_deg;
    b->stand.arrives_us = b->now_us + MOVE_US;
    return TUMBLE_OK;
}

static void bench_stop(void *self)
{
    bench_t *b = bench_of(self);
    b->stand.stops++;
    if ((b->stand.state != TUMBLE_STAND_FAULT) && (b->stand.state != TUMBLE_STAND_OFFLINE)) {
        b->stand.state = TUMBLE_STAND_STOPPED;
    }
}

static tumble_status_t bench_clear(void *self)
{
    bench_t *b = bench_of(self);
    b->stand.clears++;
    if (b->stand.refuses_clears > 0U) {
        b->stand.refuses_clears--;
        return TUMBLE_E_STAND_STATE;
    }
    if (!b->stand.stays_faulty) {
        b->stand.fault = TUMBLE_STAND_FAULT_NONE;
        b->stand.state = b->stand.loses_home ? TUMBLE_STAND_READY : TUMBLE_STAND_STOPPED;
    }
    return TUMBLE_OK;
}

static tumble_stand_state_t bench_state(const void *self)
{
    return stand_of(self)->state;
}

static tumble_stand_fault_t bench_fault(const void *self)
{
    return stand_of(self)->fault;
}

static double bench_angle(const void *self)
{
    return stand_of(self)->angle_deg + stand_of(self)->error_deg;
}

static const tumble_stand_kind_t bench_kind = {
    .report_at = (uint16_t)offsetof(bench_t, stand.report),
    .home = bench_home,
    .move = bench_move,
    .stop = bench_stop,
    .clear_fault = bench_clear,
    .state = bench_state,
    .fault = bench_fault,
    .angle_deg = bench_angle,
};

void bench_break_stand(bench_t *b, tumble_stand_fault_t fault, uint16_t code)
{
    b->stand.state = TUMBLE_STAND_FAULT;
    b->stand.fault = fault;
    b->stand.report.fault_code = code;
}

/* The block. */

/* Sine by the series, after taking whole turns and quarters off: good to the last few bits. */
static double bench_sine(double deg)
{
    while (deg > 180.0) {
        deg -= 360.0;
    }
    while (deg < -180.0) {
        deg += 360.0;
    }
    deg = (deg > 90.0) ? (180.0 - deg) : (deg < -90.0) ? (-180.0 - deg) : deg;
    const double x = deg * (3.14159265358979323846 / 180.0);
    double term = x;
    double sum = x;
    for (int k = 3; k < 30; k += 2) {
        term *= -x * x / (double)(k * (k - 1));
        sum += term;
    }
    return sum;
}

static void bench_outputs(bench_t *b, double u_v[3])
{
    const tumble_mounting_t *mountings = (b->block.truth != NULL) ? b->block.truth : b->config.schedule->mountings;
    const tumble_mounting_t *mounting = &mountings[b->mounted];
    const double deg = b->stand.angle_deg + b->block.slip_deg;
    const double t = mounting->tilt.cosine;
    const double f[3] = {t * bench_sine(deg), mounting->tilt.sine, t * bench_sine(deg + 90.0)};
    for (int i = 0; i < 3; i++) {
        u_v[i] = b->block.u0_v[i] + b->block.drift_v;
        for (int j = 0; j < 3; j++) {
            const double *m = mounting->matrix[j];
            u_v[i] += b->block.k_v_per_g[i][j] * ((m[0] * f[0]) + (m[1] * f[1]) + (m[2] * f[2]));
        }
    }
}

static int32_t bench_counts(double v)
{
    return (int32_t)((v < 0.0) ? ((v / V_PER_COUNT) - 0.5) : ((v / V_PER_COUNT) + 0.5));
}

tumble_block_sample_t bench_make_sample(bench_t *b)
{
    fake_block_t *block = &b->block;
    double u_v[3];
    bench_outputs(b, u_v);
    tumble_block_sample_t sample = {.timestamp_ms = block->timestamp_ms, .raw = {.status = block->status}};
    for (int i = 0; i < 3; i++) {
        const int32_t noise =
            (block->noise_counts > 0) ? dice_between(&block->dice, -block->noise_counts, block->noise_counts) : 0;
        const double v = block->sign[i] * u_v[block->channel[i]];
        sample.raw.counts[i] = block->dead[i] ? 0 : (bench_counts(v) + noise);
    }
    sample.raw.counts[0] += ((block->counter % 2U) == 0U) ? block->add_counts : 0;
    sample.raw.counter = block->counter;
    sample.temperature_half_c = block->temperature_half_c;
    return sample;
}

static void bench_sample(bench_t *b)
{
    fake_block_t *block = &b->block;
    const tumble_block_sample_t sample = bench_make_sample(b);
    const uint16_t lose = block->lose_every;
    const uint16_t corrupt = block->corrupt_every;
    const bool lost = (lose != 0U) && ((block->counter % lose) == 0U);
    const bool corrupted = (corrupt != 0U) && ((block->counter % corrupt) == 0U);
    if (!block->silent && corrupted) {
        tumble_procedure_sample_faults(&b->procedure, 1, 0);
    } else if (!block->silent && !lost) {
        tumble_taken_t taken;
        if (tumble_procedure_sample(&b->procedure, &sample, &taken)) {
            b->last_index = taken.index;
            b->highest_ordinal = taken.ordinal;
        }
    }
    block->counter = (uint16_t)(block->counter + (block->frozen_counter ? 0U : 1U));
    const unsigned next_ms = block->timestamp_ms + (block->frozen_time ? 0U : 10U);
    block->timestamp_ms = (uint16_t)(next_ms % TUMBLE_TIMESTAMP_PERIOD_MS);
    block->temperature_half_c = (int8_t)(block->temperature_half_c + block->warming_half_c);
}

tumble_progress_t bench_progress(const bench_t *b)
{
    tumble_progress_t progress;
    tumble_procedure_progress(&b->procedure, &progress);
    return progress;
}

/* The operator: mounts what is asked for, and says so. */
static void bench_operate(bench_t *b)
{
    const tumble_progress_t progress = bench_progress(b);
    if ((progress.state != TUMBLE_STATE_WAIT_MOUNTING) || b->operator_is_away) {
        return;
    }
    uint8_t m = 0;
    while (b->config.schedule->mountings[m].number != progress.mounting) {
        m++;
    }
    b->mounted = (b->operator_mounts != UINT8_MAX) ? b->operator_mounts : m;
    b->confirmations++;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_confirm_mounting(&b->procedure, progress.mounting));
}

tumble_state_t bench_state_of(const bench_t *b)
{
    return bench_progress(b).state;
}

void bench_tick(bench_t *b)
{
    b->now_us += SAMPLE_US;
    fake_stand_t *stand = &b->stand;
    const bool under_way = (stand->state == TUMBLE_STAND_MOVING) || (stand->state == TUMBLE_STAND_HOMING);
    if (under_way && (b->now_us >= stand->arrives_us) && !stand->never_arrives) {
        stand->angle_deg = stand->target_deg;
        stand->state = TUMBLE_STAND_IN_POSITION;
    }
    const uint64_t computing_us = (bench_state_of(b) == TUMBLE_STATE_SOLVE) ? SAMPLE_US / 8U : 0U;
    const uint64_t step_us = (b->step_us != 0U) ? b->step_us : computing_us;
    for (uint64_t at_us = 0; (step_us != 0U) && (at_us < SAMPLE_US); at_us += step_us) {
        tumble_procedure_step(&b->procedure, b->now_us + at_us);
        b->visited |= (uint32_t)1U << (unsigned)b->procedure.state;
    }
    bench_sample(b);
    b->visited |= (uint32_t)1U << (unsigned)b->procedure.state;
    bench_operate(b);
}

void bench_ticks(bench_t *b, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        bench_tick(b);
    }
}

unsigned bench_ticks_in(bench_t *b, tumble_state_t state)
{
    unsigned ticks = 0;
    for (; bench_state_of(b) == state; ticks++) {
        bench_tick(b);
    }
    return ticks;
}

tumble_reason_t bench_reason_of(const bench_t *b)
{
    return bench_progress(b).reason;
}

bool bench_has_ended(const bench_t *b)
{
    const tumble_state_t state = bench_state_of(b);
    return (state == TUMBLE_STATE_DONE) || (state == TUMBLE_STATE_FAULT) || (state == TUMBLE_STATE_ABORT);
}

void bench_run_to(bench_t *b, tumble_state_t state)
{
    for (int i = 0; i < 60000; i++) {
        if (bench_has_ended(b) || (bench_state_of(b) == state)) {
            return;
        }
        bench_tick(b);
    }
    TEST_FAIL_MESSAGE("the procedure does not end");
}

void bench_run(bench_t *b)
{
    bench_run_to(b, TUMBLE_STATE_COUNT);
}

void bench_run_to_position(bench_t *b, uint8_t index, tumble_state_t state)
{
    for (int i = 0; i < 60000; i++) {
        const tumble_progress_t progress = bench_progress(b);
        if ((progress.state == state) && (progress.index == index)) {
            return;
        }
        TEST_ASSERT_FALSE_MESSAGE(bench_has_ended(b), tumble_reason_name(progress.reason));
        bench_tick(b);
    }
    TEST_FAIL_MESSAGE("the position is never reached");
}

void bench_init(bench_t *b)
{
    static const double k[3][3] = {{-2.0, 0.03, -0.02}, {0.04, -1.9, 0.02}, {-0.01, 0.02, -2.1}};
    static const double u0[3] = {0.2, -0.3, 0.1};
    memset(b, 0, sizeof *b);
    b->averaging = (tumble_averaging_config_t){
        .saturation_counts = 8000000,
        .min_samples = 10,
        .max_lost = 2,
        .stuck_run = 0,
        .noise_counts = 30.0F,
        .stillness_ratio = 2.0F,
    };
    b->config = (tumble_procedure_config_t){
        .schedule = &tumble_schedule_paper,
        .averaging = &b->averaging,
        .estimate = TUMBLE_ESTIMATE_REFINED,
        .samples = 20,
        .v_per_count = V_PER_COUNT,
        .nominal_scale_v_per_g = -2.0,
        .gravity_limit_g = 3e-4,
        .closure_limit_g = 1e-3,
        .position_tolerance_deg = 0.05,
        .approach_deg = 5.0,
        .cable_min_deg = -30.0,
        .cable_max_deg = 400.0,
        .settle_ms = 200,
        .max_corrupted = 3,
        .retries = 1,
        .warm_up_band_half_c = 2,
        .warm_up_samples = 10,
        .preflight_timeout_ms = 1000,
        .warm_up_timeout_ms = 2000,
        .mounting_timeout_ms = 3000,
        .home_timeout_ms = 1000,
        .move_timeout_ms = 1000,
        .settle_timeout_ms = 800,
        .average_timeout_ms = 1000,
        .sample_timeout_ms = 300,
    };
    b->table = (tumble_stand_t){&bench_kind, b};
    b->stand.state = TUMBLE_STAND_READY;
    memcpy(b->block.k_v_per_g, k, sizeof k);
    memcpy(b->block.u0_v, u0, sizeof u0);
    for (uint8_t i = 0; i < 3U; i++) {
        b->block.channel[i] = i;
        b->block.sign[i] = 1.0;
    }
    b->block.noise_counts = 30;
    b->block.temperature_half_c = 50;
    b->block.counter = 65500;
    b->block.dice.state = 1;
    b->step_us = SAMPLE_US;
    b->now_us = 5000000;
    b->operator_mounts = UINT8_MAX;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_init(&b->procedure, &b->config, &b->table));
}

void bench_run_to_done(bench_t *b)
{
    bench_run(b);
    ASSERT_ENDED(b, TUMBLE_STATE_DONE, TUMBLE_REASON_NONE);
}

void bench_start_to_done(bench_t *b)
{
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&b->procedure));
    bench_run_to_done(b);
}

void bench_start(bench_t *b)
{
    bench_init(b);
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_start(&b->procedure));
}

tumble_result_t bench_result(const bench_t *b)
{
    tumble_result_t result;
    ASSERT_STATUS(TUMBLE_OK, tumble_procedure_result(&b->procedure, &result));
    return result;
}

void begin(void)
{
    bench_init(&bench);
}

void begin_run(void)
{
    bench_start(&bench);
}

const tumble_procedure_counters_t *counters(void)
{
    return tumble_procedure_counters(&bench.procedure);
}
