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

typedef struct {
    uint32_t done;
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
            const double off = fabs(keeper.sets.set.coefficients.k_v_per_g[i][j] - truth->k_v_per_g[i][j]);
            farthest = fmax(farthest, off / keeper.sets.set.uncertainty.k_v_per_g[i][j]);
        }
        const double off = fabs(keeper.sets.set.coefficients.u0_v[i] - truth->u0_v[i]);
        farthest = fmax(farthest, off / keeper.sets.set.uncertainty.u0_v[i]);
    }
    return farthest;
}

static void count_run(tally_t *tally)
{
    tumble_sets_state_t state;
    tumble_sets_state(&keeper.sets, &state);
    if (state.verdict == TUMBLE_VERDICT_NONE) {
        return; /* another gate has ended the run */
    }
    const double farthest = farthest_off();
    tally->done++;
    tally->misfits += ((state.objections & MISFIT) != 0U) ? 1U : 0U;
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
    static char text[2048];
    (void)snprintf(text, sizeof text, "stand.limits = sigma1\noperator.mend_s = -1\nblock.scale_v_per_g = 2\n%s%s",
                   stand->lines, more);
    const char *const wrong = read_lines(text);
    TEST_ASSERT_NULL_MESSAGE(wrong, wrong);
    memory_init(&memory);
    settings = usual_settings();
    keeper_config = (tumble_keeper_config_t){.sets = {.serial = "TB-0001", .settings = &settings},
                                             .uncertainty = tumble_navcomp_uncertainty};
    kept_world_power_on(seed, UTC_S);
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_command(&world.navcomp, TUMBLE_COMMAND_START, 0));
    bench_world_run(&world);
    world_settle();
    count_run(tally);
}

static void tell(const char *what, const stand_t *stand, const tally_t *tally)
{
    char text[240];
    (void)snprintf(
        text, sizeof text,
        "%s, %s: %u judged, %u do not fit, %u committed, %u beyond 6 u (at most %.1f); without the objection "
        "%u (%.1f)",
        what, stand->name, (unsigned)tally->done, (unsigned)tally->misfits, (unsigned)tally->committed,
        (unsigned)tally->far, tally->farthest, (unsigned)tally->far_before, tally->farthest_before);
    TEST_MESSAGE(text);
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
