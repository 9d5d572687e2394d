/* The objection "does not fit": how often an honest run earns it, and what steps of the outputs get past it, in the simulation.
 *
 * KEEPER_FIT_RUNS sets how many runs there are of each kind (docs/method.md has the figures of thousands).
 */
#include "keeper_world.h"

#include <stdlib.h>

#define USUAL_RUNS 60U
#define UTC_S 1800000000U
#define FAR_OFF 6.0 /* standard uncertainties */
#define MISFIT TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_DOES_NOT_FIT)
#define BEYOND TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_WHOLE_MODEL)

typedef struct {
    const char *name;
    const char *lines;
} stand_t;

/* Standard deviations, as in docs/method.md. */
static const stand_t stands[] = {
    {"paper",
     "stand.axis_tilt_rad = 2e-5\nstand.level_rad = 2e-5\nstand.remount_rad = 4e-4\nstand.angle_rad = 4e-5\n"
     "block.noise_v = 3e-4 3e-4 3e-4\n"},
    {"angle",
     "stand.axis_tilt_rad = 2e-5\nstand.level_rad = 2e-5\nstand.remount_rad = 4e-4\nstand.angle_rad = 2e-4\n"
     "block.noise_v = 3e-5 3e-5 3e-5\nprocedure.gravity_limit_g = 1e-3\n"},
    {"lab",
     "stand.axis_tilt_rad = 2e-4\nstand.level_rad = 5e-4\nstand.remount_rad = 2e-3\nstand.angle_rad = 2e-4\n"
     "block.noise_v = 1e-4 1e-4 1e-4\nprocedure.gravity_limit_g = 1e-3\n"},
};

/* What an inclined stand declares besides, and what it does not: its inclinations, off by 10 mrad, and the level, by 50. */
static const char inclined_lines[] =
    "stand.axis_tilt_rad = 5e-2\nstand.level_rad = 1e-2\nstand.remount_rad = 1e-3\n"
    "stand.seat_rad = 1e-3\nstand.inclination_rad = 1e-2\n"
    "procedure.estimator = inclined\nprocedure.gravity_limit_g = 1e-3\n";

static const stand_t inclined_stands[] = {
    {"inclined", "stand.angle_rad = 4e-5\nblock.noise_v = 3e-4 3e-4 3e-4\n"},
    {"inclined, angle", "stand.angle_rad = 2e-4\nblock.noise_v = 3e-5 3e-5 3e-5\n"},
};

static tumble_whole_work_t whole_work;
static bool asks_whole; /* for the test of the whole model, too */

static void set_up(void)
{
    asks_whole = false;
}

typedef struct {
    uint32_t done;
    uint32_t beyond;     /* with the objection of the whole model, where that is asked */
    uint32_t misfits;    /* with the objection */
    uint32_t committed;  /* without any */
    uint32_t far;        /* committed, and some coefficient far off */
    uint32_t far_before; /* the same if nobody asked whether the run fits */
    double farthest;
    double farthest_before;
} tally_t;

static uint32_t runs(void)
{
    const char *const wanted = getenv("KEEPER_FIT_RUNS");
    return (wanted != NULL) ? (uint32_t)strtoul(wanted, NULL, 10) : USUAL_RUNS;
}

/* The largest error of a coefficient in terms of its standard uncertainty. */
static double farthest_off(void)
{
    const tumble_coefficients_t *const truth = &world.truth.block;
    double farthest = 0.0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const double off = fabs(keeper.set.coefficients.k_v_per_g[i][j] - truth->k_v_per_g[i][j]);
            farthest = fmax(farthest, off / keeper.set.uncertainty.k_v_per_g[i][j]);
        }
        const double off = fabs(keeper.set.coefficients.u0_v[i] - truth->u0_v[i]);
        farthest = fmax(farthest, off / keeper.set.uncertainty.u0_v[i]);
    }
    return farthest;
}

static void count_run(tally_t *tally)
{
    tumble_sets_state_t state;
    tumble_keeper_state(&keeper, &state);
    if (state.verdict == TUMBLE_VERDICT_NONE) {
        return; /* another gate has ended the run */
    }
    const double farthest = farthest_off();
    tally->done++;
    tally->misfits += ((state.objections & MISFIT) != 0U) ? 1U : 0U;
    tally->beyond += ((state.objections & BEYOND) != 0U) ? 1U : 0U;
    if ((state.objections & ~MISFIT) == 0U) {
        tally->far_before += (farthest > FAR_OFF) ? 1U : 0U;
        tally->farthest_before = fmax(tally->farthest_before, farthest);
    }
    if (state.objections == 0U) {
        TEST_ASSERT_EQUAL_UINT8(TUMBLE_VERDICT_COMMITTED, state.verdict);
        tally->committed++;
        tally->far += (farthest > FAR_OFF) ? 1U : 0U;
        tally->farthest = fmax(tally->farthest, farthest);
    }
}

static void run(const stand_t *stand, const char *more, uint64_t seed, tally_t *tally)
{
    static char text[4096];
    (void)snprintf(text, sizeof text, "stand.limits = sigma1\noperator.mend_s = -1\nblock.scale_v_per_g = 2\n%s%s",
                   stand->lines, more);
    memory_init(&memory);
    kept_world_prepare(text);
    keeper_config.sets.whole_step = asks_whole ? tumble_whole_step : NULL;
    keeper_config.sets.whole_work = asks_whole ? &whole_work : NULL;
    (void)kept_world_run(seed, UTC_S);
    count_run(tally);
}

static void tell(const char *what, const stand_t *stand, const tally_t *tally)
{
    char text[240];
    (void)snprintf(
        text, sizeof text,
        "%s, %s: %u judged, %u do not fit, %u beyond the whole model, %u committed, %u beyond 6 u (at most %.1f); without the objection "
        "%u (%.1f)",
        what, stand->name, (unsigned)tally->done, (unsigned)tally->misfits, (unsigned)tally->beyond,
        (unsigned)tally->committed, (unsigned)tally->far, tally->farthest, (unsigned)tally->far_before,
        tally->farthest_before);
    TEST_MESSAGE(text);
}

/* The lines of a scenario that say a schedule whose block is bolted on once, and `more`. */
static const char *inclined_by(const tumble_schedule_t *schedule, const char *more)
{
    static char text[3072];
    int length = snprintf(text, sizeof text, "%s%s", inclined_lines, more);
    for (uint8_t m = 0; m < schedule->mounting_count; m++) {
        const tumble_mounting_t *const one = &schedule->mountings[m];
        length += snprintf(&text[length], sizeof text - (size_t)length,
                           "mounting = %u %.17g %.17g %.17g 1 0 0 0 1 0 0 0 1 %u\n", one->number, one->tilt.deg,
                           one->tilt.sine, one->tilt.cosine, one->bolting);
    }
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        const tumble_position_t *const one = &schedule->positions[p];
        length += snprintf(&text[length], sizeof text - (size_t)length, "position = %u %u %s %.17g %.17g %.17g\n",
                           one->mounting, one->number, (one->use == TUMBLE_USE_FIT) ? "fit" : "check", one->angle.deg,
                           one->angle.sine, one->angle.cosine);
    }
    return text;
}

/* By both tests, though no stand declares its inclinations: one of a thousand is allowed to each. A bias that moves in
 * one position by four standard deviations of a sample, and comes back: all are held. */
static void test_inclined_runs_are_judged_as_others_are(void)
{
    asks_whole = true;
    for (size_t s = 0; s < COUNT_OF(inclined_stands); s++) {
        tally_t honest = {0};
        tally_t stepped = {0};
        for (uint32_t i = 0; i < runs(); i++) {
            run(&inclined_stands[s], inclined_by(&tumble_schedule_inclined, ""), 1000U + i, &honest);
            TEST_ASSERT_TRUE(whole_work.known);
            TEST_ASSERT_EQUAL_UINT8(72U - 12U - 5U, whole_work.freedom);
        }
        for (uint32_t i = 0; i < (runs() / 10U); i++) {
            run(&inclined_stands[s],
                inclined_by(&tumble_schedule_inclined,
                            "fault = step at=2.4 phase=average channels=y value=3e-3 duration=0.7\n"),
                2000U + i, &stepped);
        }
        tell("honest", &inclined_stands[s], &honest);
        tell("steps", &inclined_stands[s], &stepped);
        TEST_ASSERT_EQUAL_UINT32(runs(), honest.done);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32((runs() / 1000U) + 1U, honest.misfits);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32((runs() / 500U) + 1U, honest.beyond);
        TEST_ASSERT_EQUAL_UINT32(stepped.done, stepped.misfits);
        TEST_ASSERT_EQUAL_UINT32(stepped.done, stepped.beyond);
        TEST_ASSERT_EQUAL_UINT32(runs() / 10U, stepped.done);
    }
}

/* One of a thousand is allowed. */
static void test_honest_runs_fit(void)
{
    for (size_t s = 0; s < COUNT_OF(stands); s++) {
        tally_t tally = {0};
        for (uint32_t i = 0; i < runs(); i++) {
            run(&stands[s], "", 1000U + i, &tally);
        }
        tell("honest", &stands[s], &tally);
        TEST_ASSERT_EQUAL_UINT32(runs(), tally.done);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32((runs() / 1000U) + 1U, tally.misfits);
        TEST_ASSERT_EQUAL_UINT32(0, tally.far);
    }
}

static double between(sim_random_t *random, double low, double high)
{
    return low * pow(high / low, sim_random_unit(random));
}

/* Steps of 0.1 mV to 0.1 V that last 0.01 to 8 s, of any channels, anywhere in the run. Without the objection some would be
 * committed far off. */
static void test_steps_do_not(void)
{
    for (size_t s = 0; s < COUNT_OF(stands); s++) {
        tally_t tally = {0};
        for (uint32_t i = 0; i < runs(); i++) {
            static const char *const channels[] = {"x", "y", "z", "xy", "xz", "yz", "xyz"};
            static const char *const phases[] = {"move", "settle", "average"};
            char fault[160];
            sim_random_t random;
            sim_random_open(&random, 7000U + i, SIM_CAUSE_FAULT_NOISE, 0);
            const double value = between(&random, 1e-4, 0.1);
            const double duration = between(&random, 0.01, 8.0);
            const unsigned place = (unsigned)(sim_random_unit(&random) * 18.0);
            const unsigned which = (unsigned)(sim_random_unit(&random) * 7.0);
            const unsigned phase = (unsigned)(sim_random_unit(&random) * 3.0);
            (void)snprintf(fault, sizeof fault, "fault = step at=%u.%u phase=%s channels=%s value=%.6g duration=%.6g\n",
                           1U + (place / 9U), 1U + (place % 9U), phases[phase], channels[which], value, duration);
            run(&stands[s], fault, 1000U + i, &tally);
        }
        tell("steps", &stands[s], &tally);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(runs() / 500U, tally.far);
        TEST_ASSERT_GREATER_THAN_UINT32(runs() / 50U, tally.far_before);
    }
}
