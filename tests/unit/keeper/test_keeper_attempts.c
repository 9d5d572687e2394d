/* Runs that must not reach the active set, in the simulation: drifted, noisy, wrongly mounted, truncated, replayed and
 * others, each with several seeds. Prints what became of them; the bytes of factory set and slots must not change. A good
 * run, as the counter-check, does change them.
 */
#include "keeper_world.h"

#define SEEDS 10U
#define SLOT_BYTES (MEMORY_SECTOR * 3U) /* factory set, both slots */
#define UTC_S 1800000000U
#define MONTH_S 2629746U

static const char USUAL[] =
    "stand.axis_tilt_rad = 2e-5\nstand.level_rad = 2e-5\nstand.remount_rad = 1e-4\n"
    "stand.angle_rad = 4e-5\nstand.limits = sigma1\noperator.mend_s = -1\n"
    "block.scale_v_per_g = 2\n";
static const char *const BLOCK[] = {"block.k = 2.01 0.02 0.01 0.03 1.99 -0.02 0.01 0.04 2.00\n",
                                    "block.u0 = 0.03 0.01 -0.02\n", "block.noise_v = 1.5e-4 1.5e-4 1.5e-4\n"};

static nv_memory_t good; /* with an active set of a first, good run */

typedef struct attempt {
    const char *name;
    const char *lines;              /* of the scenario, behind the usual ones */
    void (*prepare)(uint64_t seed); /* before power-on; may be null */
    tumble_state_t state;           /* how the run ends */
    tumble_reason_t reason;
    tumble_verdict_t verdict;
    uint16_t objections; /* at least these */
    uint64_t utc_s;
    uint64_t seed; /* 0: another one each time */
} attempt_t;

/* The usual lines, but of the block only those that `lines` do not give. */
static void read_scenario(const char *lines)
{
    static char text[2048];
    int end = snprintf(text, sizeof text, "%s%s", USUAL, lines);
    for (size_t i = 0; i < COUNT_OF(BLOCK); i++) {
        const size_t key = strcspn(BLOCK[i], "=");
        if (strncmp(lines, BLOCK[i], key) != 0) {
            end += snprintf(&text[end], sizeof text - (size_t)end, "%s", BLOCK[i]);
        }
    }
    kept_world_prepare(text);
}

static tumble_sets_state_t run(const char *lines, uint64_t seed, uint64_t utc_s, void (*prepare)(uint64_t seed))
{
    read_scenario((lines != NULL) ? lines : "");
    if (prepare != NULL) {
        prepare(seed);
    }
    return kept_world_run(seed, utc_s);
}

static void copy_memory(nv_memory_t *to, const nv_memory_t *from)
{
    memcpy(to->bytes, from->bytes, sizeof to->bytes);
}

static void set_up(void)
{
    memory_init(&memory);
    memory_init(&good);
    (void)run(NULL, 1, UTC_S, NULL);
    copy_memory(&good, &memory);
}

/* What makes an attempt more than lines of a scenario. */

static void other_block(uint64_t seed)
{
    (void)seed;
    keeper_config.sets.serial = "TB-0002";
}

static void undeclared(uint64_t seed)
{
    (void)seed;
    keeper_config.uncertainty = NULL;
}

static void ask_of_the_whole(uint64_t seed)
{
    static tumble_whole_work_t whole_work;
    (void)seed;
    keeper_config.sets.whole_step = tumble_whole_step;
    keeper_config.sets.whole_work = &whole_work;
}

static void by_hand(uint64_t seed)
{
    (void)seed;
    settings.limits.flags = 0;
}

/* The stand is worse than it is said to be: the firmware believes what the lines say. */
static void worse_stand(uint64_t seed)
{
    config.scenario.stand.axis_tilt_rad = 5e-3;
    config.scenario.stand.angle_rad = 3e-3;
    (void)seed;
}

#define HELD(objection) TUMBLE_STATE_DONE, TUMBLE_REASON_NONE, TUMBLE_VERDICT_HELD, TUMBLE_OBJECTION_BIT(objection)
#define FAULT(reason) TUMBLE_STATE_FAULT, (reason), TUMBLE_VERDICT_NONE, 0
#define NEXT_MONTH (UTC_S + MONTH_S)

/* clang-format off */
static const attempt_t attempts[] = {
    {"drifted: biases by 1 mg", "block.u0 = 0.032 0.012 -0.018\n", NULL, HELD(TUMBLE_OBJECTION_CHANGE), NEXT_MONTH, 0},
    {"drifted: one scale factor by 0.1 %", "block.k = 2.01201 0.02 0.01 0.03 1.99 -0.02 0.01 0.04 2.00\n", NULL,
     HELD(TUMBLE_OBJECTION_CHANGE), NEXT_MONTH, 0},
    {"drifting all the while, 50 mV an hour", "block.drift_v_per_h = 0.05 0.05 0.05\n", NULL,
     HELD(TUMBLE_OBJECTION_CHANGE), NEXT_MONTH, 0},
    {"noisy: ten times what is declared", "fault = noisy time=0 channels=xyz value=1.5e-3\n", NULL,
     FAULT(TUMBLE_REASON_NOT_STILL), NEXT_MONTH, 0},
    {"noisy: and declared so", "block.noise_v = 0.1 0.1 0.1\nprocedure.gravity_limit_g = 0.1\n", NULL,
     HELD(TUMBLE_OBJECTION_UNCERTAIN), NEXT_MONTH, 0},
    {"wrongly mounted", "operator.wrong_mounting = 2\noperator.mounted_instead = 1\n", NULL,
     FAULT(TUMBLE_REASON_WRONG_MOUNTING), NEXT_MONTH, 0},
    /* K times a rotation by 5e-3 rad about x: every check within the run is blind to it. */
    {"all axes turned together, 0.3 degrees",
     "block.k = 2.01 0.02004975 0.0098998754 0.03 1.9898751 -0.029949709 0.01 0.049999458 1.999775\n",
     NULL, HELD(TUMBLE_OBJECTION_CHANGE), NEXT_MONTH, 0},
    {"channels swapped", "fault = swapped time=0 channels=xy\n", NULL, FAULT(TUMBLE_REASON_SWAPPED_CHANNELS),
     NEXT_MONTH, 0},
    {"a channel inverted", "fault = inverted time=0 channels=z\n", NULL, FAULT(TUMBLE_REASON_SWAPPED_CHANNELS),
     NEXT_MONTH, 0},
    {"truncated: no more samples", "fault = no_samples at=2.3\n", NULL, FAULT(TUMBLE_REASON_NO_SAMPLES),
     NEXT_MONTH, 0},
    {"truncated: the block is gone", "fault = block_silent at=2.3 phase=move\n", NULL, FAULT(TUMBLE_REASON_BLOCK_HEARTBEAT),
     NEXT_MONTH, 0},
    {"truncated: too many samples lost", "fault = lost_samples at=1.7 delay=0.2 count=20 times=9 duration=0.4\n", NULL,
     FAULT(TUMBLE_REASON_SAMPLES_LOST), NEXT_MONTH, 0},
    {"the table slips unseen", "fault = slip at=1.4 phase=settle value=0.5\n", NULL, FAULT(TUMBLE_REASON_SLIP), NEXT_MONTH,
     0},
    {"a step of the outputs, 20 mV", "fault = step at=2.5 phase=settle channels=xyz value=0.02\n", NULL,
     FAULT(TUMBLE_REASON_SLIP), NEXT_MONTH, 0},
    {"a stand worse than declared", "procedure.closure_limit_g = 1\n", worse_stand, TUMBLE_STATE_DONE,
     TUMBLE_REASON_GRAVITY_CHECK, TUMBLE_VERDICT_HELD, TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_GRAVITY_CHECK),
     NEXT_MONTH, 0},
    {"another block", NULL, other_block, HELD(TUMBLE_OBJECTION_OTHER_BLOCK), NEXT_MONTH, 0},
    {"a stand not declared", NULL, undeclared, HELD(TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN), NEXT_MONTH, 0},
    {"a step of the outputs, 0.5 mV", "fault = step at=2.5 phase=settle channels=xyz value=5e-4 duration=4\n", NULL,
     HELD(TUMBLE_OBJECTION_DOES_NOT_FIT), NEXT_MONTH, 0},
    {"a block of second order, 200 ug/g2", "block.k2_per_g = 2e-4 2e-4 2e-4\n", ask_of_the_whole,
     HELD(TUMBLE_OBJECTION_WHOLE_MODEL), NEXT_MONTH, 0},
    {"a channel stuck for 8 s, 18 samples a position", "procedure.samples = 18\nfault = stuck at=1.2 channels=z duration=8\n",
     NULL, FAULT(TUMBLE_REASON_STUCK), NEXT_MONTH, 0},
    {"every sample begun twice", "fault = frame_duplicate time=0 id=0x683 mask=0x7FF probability=1 count=1000000\n", NULL,
     HELD(TUMBLE_OBJECTION_DISTURBED), NEXT_MONTH, 0},
    {"an operator is to decide", NULL, by_hand, HELD(TUMBLE_OBJECTION_BY_HAND), NEXT_MONTH, 0},
    {"replayed: every frame of the first run", NULL, NULL, TUMBLE_STATE_DONE, TUMBLE_REASON_NONE,
     TUMBLE_VERDICT_REPEATED, TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_REPLAYED), NEXT_MONTH, 1},
};
/* clang-format on */

static void describe(const attempt_t *attempt, uint32_t tried, bool same)
{
    char text[240];
    int end = snprintf(text, sizeof text, "%-40s %3u attempts: ", attempt->name, (unsigned)tried);
    if (attempt->verdict == TUMBLE_VERDICT_NONE) {
        end += snprintf(&text[end], sizeof text - (size_t)end, "%s", tumble_reason_name(attempt->reason));
    } else {
        int bit = 0;
        while ((attempt->objections >> (bit + 1)) != 0) {
            bit++;
        }
        end += snprintf(&text[end], sizeof text - (size_t)end, "%s (%s)",
                        (attempt->verdict == TUMBLE_VERDICT_HELD) ? "held" : "not stored",
                        tumble_objection_name((tumble_objection_t)bit));
    }
    (void)snprintf(&text[end], sizeof text - (size_t)end, ", slots %s", same ? "unchanged" : "CHANGED");
    TEST_MESSAGE(text);
}

/* True: the bytes of the slots are what they were. */
static bool try_once(const attempt_t *attempt, uint64_t seed)
{
    tumble_navcomp_progress_t progress;
    copy_memory(&memory, &good);
    const tumble_sets_state_t state =
        run(attempt->lines, (attempt->seed != 0U) ? attempt->seed : seed, attempt->utc_s, attempt->prepare);
    tumble_navcomp_progress(&world.navcomp, &progress);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(tumble_state_name(attempt->state), tumble_state_name(progress.run.state),
                                     attempt->name);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(tumble_reason_name(attempt->reason), tumble_reason_name(progress.run.reason),
                                     attempt->name);
    TEST_ASSERT_EQUAL_UINT8_MESSAGE(attempt->verdict, state.verdict, attempt->name);
    TEST_ASSERT_EQUAL_HEX16_MESSAGE(attempt->objections, state.objections & attempt->objections, attempt->name);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(1, state.counter, attempt->name);
    return memcmp(memory.bytes, good.bytes, SLOT_BYTES) == 0;
}

static void test_none_of_them_reaches_the_active_set(void)
{
    uint32_t tried = 0;
    for (size_t a = 0; a < COUNT_OF(attempts); a++) {
        bool same = true;
        for (uint64_t seed = 2; seed < (SEEDS + 2U); seed++) {
            same = try_once(&attempts[a], seed) && same;
            tried++;
        }
        describe(&attempts[a], SEEDS, same);
        TEST_ASSERT_TRUE_MESSAGE(same, attempts[a].name);
    }
    TEST_ASSERT_EQUAL_UINT32(SEEDS * COUNT_OF(attempts), tried);
}

/* Every objection that a run can earn has an attempt above; the others cannot be earned with an active set that is good and
 * not dated after the present, with limits that init has looked at, or without a write at service level
 * (test_keeper_service.c), or without a set of a newer version in the memory (test_keeper_decay.c), or on a board that
 * does not ask for u(|a|), as here (test_keeper_uncertainty.c), or without slopes (test_keeper_thermal.c). */
static void test_no_objection_is_left_out(void)
{
    static const tumble_objection_t others[] = {TUMBLE_OBJECTION_NOT_FINITE,  TUMBLE_OBJECTION_FIRST,
                                                TUMBLE_OBJECTION_LIMITS,      TUMBLE_OBJECTION_OLDER,
                                                TUMBLE_OBJECTION_OTHER_RULES, TUMBLE_OBJECTION_NEWER_SET,
                                                TUMBLE_OBJECTION_NOT_SHOWN,   TUMBLE_OBJECTION_TEMPERATURE};
    for (int o = 0; o < TUMBLE_OBJECTION_COUNT; o++) {
        bool known = false;
        for (size_t i = 0; i < COUNT_OF(others); i++) {
            known = known || ((int)others[i] == o);
        }
        for (size_t a = 0; a < COUNT_OF(attempts); a++) {
            known = known || ((attempts[a].objections & TUMBLE_OBJECTION_BIT(o)) != 0U);
        }
        TEST_ASSERT_TRUE_MESSAGE(known, tumble_objection_name((tumble_objection_t)o));
    }
}

/* Power fails in the run, and somebody goes on with another block. */
static void test_a_run_cut_and_gone_on_with_otherwise(void)
{
    copy_memory(&memory, &good);
    read_scenario("");
    kept_world_start(3, NEXT_MONTH);
    while ((world.progress.index < 12U) && bench_world_advance(&world)) {
    }
    keeper_config.sets.serial = "TB-0002";
    kept_world_power_on(3, NEXT_MONTH);
    tumble_sets_state_t state;
    tumble_keeper_state(&keeper, &state);
    TEST_ASSERT_EQUAL_UINT8(0, state.resumable);
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_navcomp_command(&world.navcomp, TUMBLE_COMMAND_RESUME, 0));
    keeper_config.sets.serial = "TB-0001";
    kept_world_power_on(3, NEXT_MONTH);
    tumble_keeper_state(&keeper, &state);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT8(11, state.resumable);
    TEST_ASSERT_EQUAL_MEMORY(good.bytes, memory.bytes, SLOT_BYTES);
    TEST_MESSAGE("truncated by loss of power, another block:  RESUME refused, slots unchanged");
}

/* The counter-check: with the same settings a good run does get there. */
static void test_good_runs_do(void)
{
    for (uint64_t seed = 2; seed < (SEEDS + 2U); seed++) {
        copy_memory(&memory, &good);
        const tumble_sets_state_t state = run(NULL, seed, NEXT_MONTH, NULL);
        TEST_ASSERT_EQUAL_HEX16(0, state.objections);
        TEST_ASSERT_EQUAL_UINT8(TUMBLE_VERDICT_COMMITTED, state.verdict);
        TEST_ASSERT_EQUAL_UINT32(2, state.counter);
        TEST_ASSERT_TRUE(memcmp(memory.bytes, good.bytes, SLOT_BYTES) != 0);
    }
}
