/* The bounds of a motion, at a stand that reports whatever a test wants. */
#include "stand/bounds.h"
#include "support.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define MARGIN_MS 2000U
#define SPEED 90.0
#define RAMP 180.0

typedef struct {
    tumble_stand_report_t report;
    double angle_deg;
    tumble_stand_state_t state;
    tumble_stand_fault_t fault;
    unsigned stops;
    bool brakes; /* a stop takes its time */
} table_t;

static table_t table;
static uint64_t now_us;

static tumble_status_t table_init(void *self, const tumble_stand_setup_t *setup)
{
    (void)self;
    (void)setup;
    return TUMBLE_OK;
}

static void table_step(void *self, uint64_t at_us)
{
    (void)self;
    (void)at_us;
}

static uint64_t table_next_us(const void *self)
{
    (void)self;
    return UINT64_MAX;
}

static tumble_status_t table_home(void *self)
{
    (void)self;
    table.state = TUMBLE_STAND_HOMING;
    return TUMBLE_OK;
}

static tumble_status_t table_move(void *self, double angle_deg)
{
    (void)self;
    (void)angle_deg;
    table.state = TUMBLE_STAND_MOVING;
    return TUMBLE_OK;
}

static void table_stop(void *self)
{
    (void)self;
    table.stops++;
    table.state = table.brakes ? TUMBLE_STAND_MOVING : TUMBLE_STAND_STOPPED;
}

static tumble_status_t table_clear_fault(void *self)
{
    (void)self;
    table.state = TUMBLE_STAND_READY;
    table.fault = TUMBLE_STAND_FAULT_NONE;
    return TUMBLE_OK;
}

static tumble_stand_state_t table_state(const void *self)
{
    (void)self;
    return table.state;
}

static tumble_stand_fault_t table_fault(const void *self)
{
    (void)self;
    return table.fault;
}

static double table_angle_deg(const void *self)
{
    (void)self;
    return table.angle_deg;
}

static const tumble_stand_kind_t table_kind = {
    .bytes = sizeof(table_t), .report_at = offsetof(table_t, report), TUMBLE_STAND_FUNCTIONS(table)};
static const tumble_stand_t stand = {&table_kind, &table};

static void tell(double speed_deg_s, double slow_deg_s, double ramp_deg_s2, double to_deg)
{
    table.report.motion = (tumble_stand_motion_t){
        .speed_mdeg_s = (uint32_t)(1000.0 * speed_deg_s),
        .slow_mdeg_s = (uint32_t)(1000.0 * slow_deg_s),
        .ramp_ms = (uint16_t)(1000.0 * speed_deg_s / ramp_deg_s2),
        .count_mdeg = 1,
        .to_mdeg = (int32_t)(1000.0 * to_deg),
    };
}

static void begin_at(double angle_deg)
{
    memset(&table, 0, sizeof table);
    table.state = TUMBLE_STAND_STOPPED;
    table.angle_deg = angle_deg;
    now_us = UINT64_C(4398046000000); /* the count of the bounds' own clock overflows within a few seconds */
}

static void begin_move(double from_deg, double to_deg)
{
    begin_at(from_deg);
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_move(&stand, to_deg));
    tell(SPEED, 0.0, RAMP, to_deg);
}

static void begin_homing(double travel_deg)
{
    begin_at(0.0);
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_home(&stand));
    tell(45.0, 4.5, RAMP, travel_deg);
}

static void pass(unsigned ms)
{
    now_us += (uint64_t)ms * 1000U;
    tumble_stand_step(&stand, now_us, MARGIN_MS);
}

/* Where a trapezoid from 0 is after t seconds. */
static double trapezoid(double way, double speed, double ramp, double t)
{
    const double peak = fmin(speed, sqrt(way * ramp));
    const double cruise_s = (way - (peak * peak / ramp)) / peak;
    const double ramp_s = peak / ramp;
    const double end_s = (2.0 * ramp_s) + cruise_s;
    if (t <= ramp_s) {
        return 0.5 * ramp * t * t;
    }
    if (t <= (ramp_s + cruise_s)) {
        return (0.5 * peak * ramp_s) + (peak * (t - ramp_s));
    }
    return (t < end_s) ? (way - (0.5 * ramp * (end_s - t) * (end_s - t))) : way;
}

static bool is_given_up(void)
{
    return tumble_stand_state(&stand) == TUMBLE_STAND_FAULT;
}

static void assert_given_up(tumble_stand_fault_t fault)
{
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT, tumble_stand_state(&stand));
    TEST_ASSERT_EQUAL_INT(fault, tumble_stand_fault(&stand));
    TEST_ASSERT_EQUAL_UINT(1, table.stops);
}

/* The way. */

static void test_past_the_goal_and_the_other_way(void)
{
    static const struct {
        double from, to, last_good, first_bad;
    } cases[] = {{0.0, 90.0, 92.0, 92.001},
                 {0.0, 90.0, -2.0, -2.001},
                 {360.0, -5.0, -7.0, -7.001},
                 {360.0, -5.0, 362.0, 362.001}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        begin_move(cases[i].from, cases[i].to);
        table.angle_deg = cases[i].last_good;
        pass(10);
        TEST_ASSERT_FALSE(is_given_up());
        table.angle_deg = cases[i].first_bad;
        pass(10);
        assert_given_up(TUMBLE_STAND_FAULT_RUNAWAY);
    }
}

static void test_an_angle_that_is_no_number_is_past_the_goal(void)
{
    begin_move(0.0, 90.0);
    table.angle_deg = NAN;
    pass(10);
    assert_given_up(TUMBLE_STAND_FAULT_RUNAWAY);
}

/* Also of a kind that tells nothing of its motions. */
static void test_the_way_is_bounded_before_the_axis_sets_out(void)
{
    begin_move(0.0, 90.0);
    memset(&table.report.motion, 0, sizeof table.report.motion);
    table.angle_deg = 95.0;
    pass(10);
    assert_given_up(TUMBLE_STAND_FAULT_RUNAWAY);
}

static void test_in_position_counts_at_the_goal_alone(void)
{
    begin_move(0.0, 90.0);
    pass(10);
    table.angle_deg = 88.5;
    table.state = TUMBLE_STAND_IN_POSITION;
    pass(10);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_IN_POSITION, tumble_stand_state(&stand));
    begin_move(0.0, 90.0);
    pass(10);
    table.angle_deg = 0.0;
    table.state = TUMBLE_STAND_IN_POSITION;
    pass(10);
    assert_given_up(TUMBLE_STAND_FAULT_STALL);
}

/* The time: way / speed + ramp + margin, to a look each 10 ms. */
static void assert_ends_after(double expected_s, tumble_stand_fault_t fault)
{
    const uint64_t begun_us = now_us;
    while (!is_given_up()) { /* it creeps on, in no steady way */
        const bool rests = ((now_us / 100000U) % 2U) == 0U;
        table.angle_deg =
            fmin(table.angle_deg + (rests ? 0.0 : 0.1), (fault == TUMBLE_STAND_FAULT_HOMING) ? 700.0 : 89.0);
        pass(10);
        TEST_ASSERT_TRUE((now_us - begun_us) < 60000000U);
    }
    assert_given_up(fault);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, expected_s, (double)(now_us - begun_us) * 1e-6);
}

static void test_a_move_that_never_arrives(void)
{
    begin_move(0.0, 90.0);
    assert_ends_after(1.0 + 0.5 + 2.0, TUMBLE_STAND_FAULT_TIMEOUT);
}

static void test_a_homing_that_never_ends(void)
{
    begin_homing(790.0);
    assert_ends_after((790.0 / 45.0) + 0.25 + 2.0, TUMBLE_STAND_FAULT_HOMING);
}

static void test_time_counts_from_where_the_axis_sets_out(void)
{
    begin_move(0.0, 90.0);
    memset(&table.report.motion, 0, sizeof table.report.motion);
    for (int i = 0; i < 1000; i++) {
        pass(10);
    }
    TEST_ASSERT_FALSE(is_given_up());
    tell(SPEED, 0.0, RAMP, 90.0);
    assert_ends_after(1.0 + 0.5 + 2.0, TUMBLE_STAND_FAULT_TIMEOUT);
}

/* Progress. */

static void assert_stalls(double flicker_deg, uint16_t count_mdeg, double after_s)
{
    table.report.motion.count_mdeg = count_mdeg;
    const double at_deg = table.angle_deg;
    const uint64_t begun_us = now_us;
    for (int i = 0; !is_given_up(); i++) {
        table.angle_deg = at_deg + (((i % 3) == 0) ? flicker_deg : 0.0);
        pass(10);
        TEST_ASSERT_TRUE((now_us - begun_us) < 10000000U);
    }
    assert_given_up(TUMBLE_STAND_FAULT_STALL);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, after_s, (double)(now_us - begun_us) * 1e-6);
}

static void test_reports_that_stand_still_or_flicker(void)
{
    static const double flickers_deg[] = {0.0, 0.001, -0.02, 0.1};
    for (size_t i = 0; i < COUNT_OF(flickers_deg); i++) {
        begin_move(0.0, 90.0);
        assert_stalls(flickers_deg[i], 100, 1.0);
        begin_homing(790.0);
        assert_stalls(flickers_deg[i], 100, 2.1);
    }
}

/* Between two looks at its speed, and after them: whenever it is. */
static void test_reports_that_freeze_on_the_way(void)
{
    for (unsigned at_ms = 300; at_ms < 3000U; at_ms += 7U) {
        begin_move(0.0, 360.0);
        for (unsigned ms = 0; !is_given_up(); ms += 10U) {
            table.angle_deg = trapezoid(360.0, SPEED, RAMP, 1e-3 * fmin(ms, at_ms));
            pass(10);
            TEST_ASSERT_TRUE(ms < (at_ms + 1100U));
        }
        assert_given_up(TUMBLE_STAND_FAULT_STALL);
    }
}

/* A drive that brakes more gently than it starts, or that limits its own acceleration, as its ramp is told or not. */
static void test_gentle_ramps_are_no_other_speed(void)
{
    static const struct {
        double ramp, told;
    } cases[] = {{20.0, 20.0}, {45.0, 45.0}, {60.0, 60.0}, {60.0, 180.0}, {90.0, 180.0}, {8.0, 1e9}, {20.0, 1e9}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        begin_move(0.0, 360.0);
        tell(SPEED, 0.0, cases[i].told, 360.0);
        const double end_s = (360.0 / SPEED) + (SPEED / cases[i].ramp);
        for (double t = 0.0; t < fmin(end_s, 5.9); t += 0.01) {
            table.angle_deg = trapezoid(360.0, SPEED, cases[i].ramp, t);
            pass(10);
            TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, tumble_stand_fault(&stand));
        }
    }
}

static void test_a_slow_turn_over_the_same_angle_is_progress(void)
{
    begin_homing(790.0);
    tell(16.0, 1.6, 1.0, 790.0); /* looks are four seconds apart */
    for (unsigned ms = 0; ms < 20000U; ms += 10U) {
        const double t = ms * 1e-3;
        table.angle_deg = (ms < 10000U) ? t : (20.0 - t); /* and back */
        pass(10);
        TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, tumble_stand_fault(&stand));
    }
}

/* A speed that is not known bounds no time, but the axis must go on. */
static void test_without_a_speed_progress_is_watched(void)
{
    begin_homing(790.0);
    tell(0.0, 0.0, RAMP, 790.0);
    for (unsigned ms = 0; ms < 60000U; ms += 10U) {
        table.angle_deg = -9.0e-3 * ms;
        pass(10);
        TEST_ASSERT_FALSE(is_given_up());
    }
    assert_stalls(0.0, 1, 2.0);
}

static void test_at_the_goal_an_axis_may_rest(void)
{
    begin_move(0.0, 90.0);
    for (unsigned ms = 0; ms < 2900U; ms += 10U) {
        table.angle_deg = (ms < 100U) ? 45.0 : 89.0;
        pass(10);
        TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, tumble_stand_fault(&stand));
    }
    for (unsigned ms = 0; ms < 200U; ms += 10U) {
        pass(10);
    }
    assert_given_up(TUMBLE_STAND_FAULT_TIMEOUT);
}

/* A whole move with reports each `report_ms` that are wrong by a factor. Returns where the table truly is when it is given
 * up, or NAN. */
static double play_move(double way, double speed, double ramp, unsigned report_ms, double factor)
{
    begin_at(0.0);
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_move(&stand, way));
    tell(speed, 0.0, ramp, way);
    const double peak = fmin(speed, sqrt(way * ramp / factor));
    const double end_s = (way / peak / factor) + (peak / ramp) + 0.3;
    double reported = 0.0;
    for (unsigned ms = 0; (ms * 1e-3) < end_s; ms += 5U) {
        const double truly = trapezoid(way / factor, speed, ramp, ms * 1e-3);
        reported = ((ms % report_ms) == 0U) ? (truly * factor) : reported;
        table.angle_deg = reported;
        pass(5);
        if (is_given_up()) {
            return truly;
        }
    }
    return NAN;
}

static void test_a_sound_motion_is_never_given_up(void)
{
    static const double ways[] = {5.0, 45.0, 130.0, 365.0};
    static const double speeds[] = {3.0, 30.0, 90.0, 200.0};
    static const double ramps[] = {20.0, 100.0, 180.0, 1000.0};
    static const unsigned reports_ms[] = {5, 10, 35, 100, 250};
    for (size_t w = 0; w < COUNT_OF(ways); w++) {
        for (size_t s = 0; s < COUNT_OF(speeds); s++) {
            for (size_t r = 0; r < COUNT_OF(ramps); r++) {
                for (size_t m = 0; m < COUNT_OF(reports_ms); m++) {
                    char which[80];
                    (void)snprintf(which, sizeof which, "%g deg at %g, %g, each %u ms", ways[w], speeds[s], ramps[r],
                                   reports_ms[m]);
                    const double at = play_move(ways[w], speeds[s], ramps[r], reports_ms[m], 1.0);
                    TEST_ASSERT_EQUAL_INT_MESSAGE(TUMBLE_STAND_FAULT_NONE, tumble_stand_fault(&stand), which);
                    TEST_ASSERT_TRUE_MESSAGE(isnan(at), which);
                }
            }
        }
    }
}

static void test_a_wrong_scale_is_noticed_on_a_long_way(void)
{
    static const double factors[] = {0.1, 0.25, 0.5, 2.0, 4.0, 10.0};
    for (size_t i = 0; i < COUNT_OF(factors); i++) {
        const double at = play_move(360.0, SPEED, RAMP, 10, factors[i]);
        TEST_ASSERT_TRUE(at < 80.0); /* false where it is no number */
        assert_given_up(TUMBLE_STAND_FAULT_SCALE);
    }
}

static void test_another_speed_than_told_is_noticed(void)
{
    static const double speeds[] = {30.0, 60.0, 120.0, 265.0};
    for (size_t i = 0; i < COUNT_OF(speeds); i++) {
        begin_move(0.0, 360.0);
        for (unsigned ms = 0; (ms < 1500U) && !is_given_up(); ms += 10U) {
            table.angle_deg = trapezoid(360.0, speeds[i], 1000.0, ms * 1e-3);
            pass(10);
        }
        assert_given_up(TUMBLE_STAND_FAULT_SCALE);
    }
}

/* The fast way to the mark, a rest, and the slow way back to it. */
static bool homing_is_given_up(double way, double factor)
{
    begin_homing(790.0);
    const double fast_s = (way / 45.0) + 0.5;
    for (unsigned ms = 0; (ms * 1e-3) < (fast_s + 1.0); ms += 5U) {
        const double t = ms * 1e-3;
        const double fast = trapezoid(way, 45.0, RAMP, t);
        const double slow = (t > fast_s) ? trapezoid(2.0, 4.5, RAMP, t - fast_s) : 0.0;
        table.angle_deg = factor * (slow - fast);
        pass(5);
        if (is_given_up()) {
            TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_SCALE, tumble_stand_fault(&stand));
            return true;
        }
    }
    return false;
}

static void test_a_wrong_scale_is_noticed_in_the_first_homing(void)
{
    static const double factors[] = {0.1, 0.25, 0.5, 2.0, 4.0, 10.0};
    for (double way = 6.0; way < 300.0; way *= 1.3) {
        TEST_ASSERT_FALSE(homing_is_given_up(way, 1.0));
        TEST_ASSERT_FALSE(homing_is_given_up(way, -1.0));
        for (size_t i = 0; i < COUNT_OF(factors); i++) {
            char which[80];
            (void)snprintf(which, sizeof which, "%g deg, factor %g", way, factors[i]);
            TEST_ASSERT_TRUE_MESSAGE(homing_is_given_up(way, factors[i]), which);
        }
    }
}

/* After it was given up. */

static void test_then_it_must_home_before_it_moves(void)
{
    begin_move(0.0, 90.0);
    table.angle_deg = 100.0;
    pass(10);
    assert_given_up(TUMBLE_STAND_FAULT_RUNAWAY);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, tumble_stand_home(&stand));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, tumble_stand_move(&stand, 0.0));
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_clear_fault(&stand));
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_READY, tumble_stand_state(&stand));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, tumble_stand_move(&stand, 0.0));
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_home(&stand));
    table.state = TUMBLE_STAND_IN_POSITION;
    table.angle_deg = 0.0;
    pass(10);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_IN_POSITION, tumble_stand_state(&stand));
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_move(&stand, 45.0));
}

/* A homing that is given up has found nothing. */
static void test_a_position_that_is_lost_stays_lost_until_it_is_home(void)
{
    begin_at(0.0);
    tumble_stand_lose_position(&stand);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_READY, tumble_stand_state(&stand));
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_home(&stand));
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_HOMING, tumble_stand_state(&stand));
    tumble_stand_stop(&stand);
    pass(10);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_READY, tumble_stand_state(&stand));
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, tumble_stand_move(&stand, 0.0));
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_home(&stand));
    table.state = TUMBLE_STAND_IN_POSITION;
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_IN_POSITION, tumble_stand_state(&stand));
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_move(&stand, 0.0));
}

static void test_a_fault_is_not_cleared_while_the_axis_brakes(void)
{
    begin_move(0.0, 90.0);
    table.brakes = true;
    table.angle_deg = 100.0;
    pass(10);
    assert_given_up(TUMBLE_STAND_FAULT_RUNAWAY);
    ASSERT_STATUS(TUMBLE_E_STAND_STATE, tumble_stand_clear_fault(&stand));
    table.state = TUMBLE_STAND_STOPPED;
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_clear_fault(&stand));
}

static void test_a_stop_that_fails_matters_more(void)
{
    begin_move(0.0, 90.0);
    table.angle_deg = 100.0;
    pass(10);
    table.state = TUMBLE_STAND_FAULT;
    table.fault = TUMBLE_STAND_FAULT_STOP;
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_STOP, tumble_stand_fault(&stand));
    ASSERT_STATUS(TUMBLE_OK, tumble_stand_clear_fault(&stand));
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_FAULT_NONE, tumble_stand_fault(&stand));
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_READY, tumble_stand_state(&stand));
}

static void test_a_motion_that_was_stopped_has_no_bounds(void)
{
    begin_move(0.0, 90.0);
    tumble_stand_stop(&stand);
    table.angle_deg = 500.0;
    pass(10000);
    TEST_ASSERT_EQUAL_INT(TUMBLE_STAND_STOPPED, tumble_stand_state(&stand));
    TEST_ASSERT_EQUAL_UINT(1, table.stops);
}
