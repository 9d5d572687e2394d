/* The service level with a keeper: a run that is judged by other rules than the board's, a proposal that is named, and
 * what may be saved. */
#include "keeper_sdo.h"

#define OTHER_RULES TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_OTHER_RULES)
#define DOES_NOT_FIT TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_DOES_NOT_FIT)

/* One position is off by so much, in one channel. */
static tumble_verdict_t disturbed_run(uint8_t index, double by_v)
{
    bench.logged = 0;
    ASSERT_STATUS(TUMBLE_OK, tell(TUMBLE_COMMAND_START));
    for (int i = 0; i < 2000000; i++) {
        const tumble_progress_t run = bench_progress(&bench).run;
        TEST_ASSERT_NOT_EQUAL(TUMBLE_STATE_FAULT, run.state);
        if (run.state == TUMBLE_STATE_DONE) {
            break;
        }
        bench.block.u0_v[0] = ((run.index == index) && (run.state >= TUMBLE_STATE_SETTLE)) ? by_v : 0.0;
        bench_event(&bench);
    }
    settle_memory();
    return (tumble_verdict_t)state_of_keeper().verdict;
}

/* Of a coefficient of x, V/g. */
static double largest_change(const tumble_coefficients_t *a, const tumble_coefficients_t *b)
{
    double largest = 0.0;
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        const double change = a->k_v_per_g[0][j] - b->k_v_per_g[0][j];
        largest = (change > largest) ? change : (-change > largest) ? -change : largest;
    }
    return largest;
}

/* What voids the rules, each by one write at service level. */
static void void_the_rules(void)
{
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 1.0));
    for (uint8_t sub = 1; sub <= 12U; sub++) {
        TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2124, sub, 1.0F));
        TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2125, sub, 1.0F));
    }
}

static void test_nobody_voids_the_rules_at_normal_level(void)
{
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_f64(0x2050, 5, 1.0));
    for (uint8_t sub = 1; sub <= 12U; sub++) {
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_f32(0x2124, sub, 1.0F));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_f32(0x2125, sub, 1.0F));
        TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_f32(0x2126, sub, 1.0F));
    }
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_f32(0x2123, 1, 10.0F));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_byte(0x2123, 2, 3));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_byte(0x2122, 6, 1));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_and_wait(0x1010, SAVE));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, write_and_wait(0x1011, LOAD));
    TEST_ASSERT_EQUAL_MEMORY(&settings, &keeper.settings, sizeof settings);
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2122, 2, 86400)); /* when a run is due, and so on, is nobody's secret */
    TEST_ASSERT_EQUAL_HEX32(0, write_u32(0x2122, 3, 600));
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2122, 5, 20));
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2121, 2, (const uint8_t[]){0, 0}, 2));
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2150, 1, 3));
}

/* Finding: anyone on the bus could have a disturbed run commit itself. */
static void test_a_disturbed_run_under_voided_rules_is_held(void)
{
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_COMMITTED, run_and_judge());
    const tumble_set_t good = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_HEX16(0, good.flags & TUMBLE_SET_OTHER_RULES);
    void_the_rules();
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, disturbed_run(4, 0.3));
    assert_objects(OTHER_RULES | DOES_NOT_FIT); /* no limit has seen it */
    const tumble_set_t still = set_of(TUMBLE_SET_ACTIVE);
    const tumble_set_t proposal = set_of(TUMBLE_SET_PROPOSAL);
    TEST_ASSERT_EQUAL_MEMORY(&good, &still, sizeof good);
    TEST_ASSERT_EQUAL_HEX32(OTHER_RULES | DOES_NOT_FIT, proposal.reasons);
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_SET_OTHER_RULES, proposal.flags & TUMBLE_SET_OTHER_RULES);
    TEST_ASSERT_TRUE(largest_change(&proposal.coefficients, &good.coefficients) > 1e-2);
    /* By the rules of the board the same run does not pass. */
    keeper_power_cycle_for(1.0);
    TEST_ASSERT_EQUAL(TUMBLE_VERDICT_HELD, disturbed_run(4, 0.301));
    TEST_ASSERT_EQUAL_HEX16(0, state_of_keeper().objections & OTHER_RULES);
    TEST_ASSERT_NOT_EQUAL(0, state_of_keeper().objections);
}

static void assert_judged(tumble_verdict_t verdict, uint16_t objections)
{
    drift(1e-6);
    TEST_ASSERT_EQUAL(verdict, run_and_judge());
    assert_objects(objections);
}

/* Each by itself, a good run; and as it was before, no objection. */
static void test_every_rule_that_is_another_is_an_objection(void)
{
    static const uint16_t limits[] = {0x2124, 0x2125, 0x2126};
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 2e-4));
    assert_judged(TUMBLE_VERDICT_HELD, OTHER_RULES);
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 3e-4));
    assert_judged(TUMBLE_VERDICT_COMMITTED, 0);
    for (size_t i = 0; i < COUNT_OF(limits); i++) {
        const float before = read_f32(limits[i], 12);
        unlock();
        TEST_ASSERT_EQUAL_HEX32(0, write_f32(limits[i], 12, before + 1e-4F)); /* the last */
        assert_judged(TUMBLE_VERDICT_HELD, OTHER_RULES);
        unlock();
        TEST_ASSERT_EQUAL_HEX32(0, write_f32(limits[i], 12, before));
        assert_judged(TUMBLE_VERDICT_COMMITTED, 0);
    }
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2123, 1, 4.0F));
    assert_judged(TUMBLE_VERDICT_HELD, OTHER_RULES);
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2123, 1, settings.limits.coverage));
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2123, 2, TUMBLE_COMMIT_BY_ITSELF));
    assert_judged(TUMBLE_VERDICT_HELD, OTHER_RULES);
}

/* Put back before it is decided, but after the run was done. */
static void test_rules_that_come_back_in_time_excuse_nothing(void)
{
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 1.0));
    bench.logged = 0;
    run_to_done();
    assert_verdict(TUMBLE_VERDICT_WORKING);
    ASSERT_STATUS(TUMBLE_OK, tumble_service_unlock(&bench.navcomp, TUMBLE_SERVICE_KEY));
    bench.navcomp.procedure_config.gravity_limit_g = 3e-4; /* as quickly as can be */
    settle_to(TUMBLE_VERDICT_HELD);
    assert_objects(OTHER_RULES);
}

/* What is saved at service level is in force after the next power-on: the board's from then on. */
static void test_saved_rules_are_the_boards(void)
{
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 2e-4));
    TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2123, 1, 4.0F));
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1010, SAVE));
    assert_judged(TUMBLE_VERDICT_COMMITTED, 0);
    keeper_power_cycle_for(1.0);
    assert_judged(TUMBLE_VERDICT_COMMITTED, 0);
    unlock(); /* forgotten, but in force: after the next power-on they are others */
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1011, LOAD));
    assert_judged(TUMBLE_VERDICT_HELD, OTHER_RULES);
    keeper_power_cycle_for(1.0);
    assert_judged(TUMBLE_VERDICT_COMMITTED, 0);
}

/* A save that fails has saved nothing. */
static void test_rules_that_could_not_be_saved_are_others(void)
{
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 2e-4));
    nv_refuse(&memory, NV_NEVER);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_HARDWARE, write_and_wait(0x1010, SAVE));
    nv_arm(&memory, nv_no_fault);
    settle_memory();
    assert_judged(TUMBLE_VERDICT_HELD, OTHER_RULES);
}

static void test_what_was_saved_is_the_boards_after_a_reset_too(void)
{
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 2e-4));
    TEST_ASSERT_EQUAL_HEX32(0, write_and_wait(0x1010, SAVE));
    TEST_ASSERT_EQUAL_HEX32(0, write_f64(0x2050, 5, 1.0));
    reset_by_nmt(TUMBLE_NMT_RESET_NODE, 1.0);
    TEST_ASSERT_TRUE(bench.navcomp.procedure_config.gravity_limit_g == 2e-4);
    assert_judged(TUMBLE_VERDICT_COMMITTED, 0);
}

/* The board's own program sets the board's rules. */
static void test_what_the_board_sets_is_the_boards(void)
{
    tumble_sets_settings_t own = settings;
    own.limits.coverage = 5.0F;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_configure(&keeper, &own));
    assert_judged(TUMBLE_VERDICT_COMMITTED, 0);
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_f32(0x2123, 1, 6.0F));
    own = *&keeper.settings;
    own.interval_s++;
    ASSERT_STATUS(TUMBLE_OK, tumble_keeper_configure(&keeper, &own)); /* does not make others its own */
    assert_judged(TUMBLE_VERDICT_HELD, OTHER_RULES);
}

/* ACCEPT names what it means. */

static uint32_t name_proposal(uint32_t name)
{
    return write_u32(0x2002, 4, name);
}

/* Finding: a proposal was read, another run replaced it, ACCEPT took the other. */
static void test_the_proposal_that_was_read_is_accepted_or_none(void)
{
    (void)run_and_judge();
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    const uint32_t read = read_number(0x2102, 14, 4);
    TEST_ASSERT_EQUAL_HEX32(set_of(TUMBLE_SET_PROPOSAL).record_crc, read);
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    const uint32_t other = read_number(0x2102, 14, 4);
    TEST_ASSERT_NOT_EQUAL(read, other);
    TEST_ASSERT_EQUAL_UINT32(set_of(TUMBLE_SET_PROPOSAL).sequence, 2); /* its sequence would not have told */
    TEST_ASSERT_EQUAL_HEX32(0, name_proposal(read));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, command(TUMBLE_COMMAND_ACCEPT));
    TEST_ASSERT_EQUAL_UINT32(1, keeper.sequence);
    TEST_ASSERT_TRUE(state_of_keeper().has_proposal);
    TEST_ASSERT_EQUAL_HEX32(0, read_number(0x2002, 4, 4)); /* used up */
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_VALUE, command(TUMBLE_COMMAND_ACCEPT));
    TEST_ASSERT_EQUAL_HEX32(0, name_proposal(other));
    TEST_ASSERT_EQUAL_HEX32(0, command(TUMBLE_COMMAND_ACCEPT));
    settle_to(TUMBLE_VERDICT_ACCEPTED);
    const tumble_set_t active = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_HEX32(other, active.from_crc);
    TEST_ASSERT_EQUAL_HEX16(0, active.flags & TUMBLE_SET_OTHER_RULES);
    TEST_ASSERT_EQUAL_HEX32(0, name_proposal(other));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, command(TUMBLE_COMMAND_ACCEPT)); /* there is none */
}

static void test_the_board_names_it_as_well(void)
{
    hold_one();
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tell(TUMBLE_COMMAND_ACCEPT));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_accept(&bench.navcomp, 0));
    const uint32_t proposal = set_of(TUMBLE_SET_PROPOSAL).record_crc;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_navcomp_accept(&bench.navcomp, proposal ^ 1U));
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_accept(&bench.navcomp, proposal));
    settle_to(TUMBLE_VERDICT_ACCEPTED);
}

/* Finding: a repeated ACCEPT, which had no name any more, took the name from the one that waited. */
static void test_an_accept_that_is_refused_leaves_the_one_that_waits(void)
{
    (void)run_and_judge();
    assert_verdict_after(2e-3, TUMBLE_VERDICT_HELD);
    ASSERT_STATUS(TUMBLE_OK, tumble_navcomp_accept(&bench.navcomp, set_of(TUMBLE_SET_PROPOSAL).record_crc));
    ASSERT_STATUS(TUMBLE_E_STATE, tumble_navcomp_accept(&bench.navcomp, 0));
    settle_to(TUMBLE_VERDICT_ACCEPTED);
    TEST_ASSERT_FALSE(state_of_keeper().has_proposal);
}

/* Every set tells how it came to be where it is. */
static void test_what_is_accepted_at_service_level_says_so(void)
{
    hold_one();
    unlock();
    decide(TUMBLE_COMMAND_ACCEPT);
    const tumble_set_t active = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_HEX16(TUMBLE_SET_OTHER_RULES, active.flags & TUMBLE_SET_OTHER_RULES);
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_OBJECTION_BIT(TUMBLE_OBJECTION_CHANGE), active.reasons);
    TEST_ASSERT_EQUAL_HEX16(active.flags, read_number(0x2100, 5, 2));
    keeper_power_cycle();
    const tumble_set_t after = set_of(TUMBLE_SET_ACTIVE);
    TEST_ASSERT_EQUAL_MEMORY(&active, &after, sizeof active);
}

/* It ends at every beginning of a run, and each has its number. */
static void test_a_run_by_itself_ends_the_level(void)
{
    unlock();
    TEST_ASSERT_EQUAL_HEX32(0, write_byte(0x2122, 6, TUMBLE_SETS_STARTS));
    assert_starts_after(1.0, 1);
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2006, 2, 1));
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x2007, 0, 4));
}

static void test_a_start_that_is_refused_does_not_end_it(void)
{
    TEST_ASSERT_EQUAL_HEX32(0, sdo_write(0x2121, 2, (const uint8_t[]){30, 0}, 2));
    unlock();
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, command(TUMBLE_COMMAND_START)); /* inhibited */
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x2006, 2, 1));
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2007, 0, 4));
}

static void test_a_run_gone_on_with_ends_the_level(void)
{
    start_and_cut(3);
    bench_pass(&bench, 1.0);
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2007, 0, 4));
    unlock();
    obey_for(0.1, TUMBLE_COMMAND_RESUME);
    TEST_ASSERT_EQUAL_UINT32(1, keeper.counters.resumed);
    TEST_ASSERT_EQUAL_UINT32(0, read_number(0x2006, 2, 1));
    TEST_ASSERT_EQUAL_UINT32(1, read_number(0x2007, 0, 4));
    TEST_ASSERT_EQUAL_HEX32(TUMBLE_ABORT_DEVICE_STATE, give_key(TUMBLE_SERVICE_KEY));
}

static const around_t around_each = {keeper_sdo_power_on, NULL};
