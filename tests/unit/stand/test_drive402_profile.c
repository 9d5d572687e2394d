/* The CiA 402 master and the drive profile: what is configured, units, other makers, profiles that cannot be. */
#include "drive_bench.h"

static void test_configuration_in_order_and_in_units(void)
{
    static const scripted_write_t expected[] = {
        {0x1016, 1, 4, 0x000101F4}, {0x1017, 0, 2, 100},        {0x6060, 0, 1, 1},          {0x6098, 0, 1, 0xFD},
        {0x6081, 0, 4, 100000},     {0x6083, 0, 4, 18000},      {0x6085, 0, 4, 72050},      {0x6099, 1, 4, 2000},
        {0x1400, 1, 4, 0x80000202}, {0x1600, 0, 1, 0},          {0x1600, 1, 4, 0x60400010}, {0x1600, 2, 4, 0x607A0020},
        {0x1600, 0, 1, 2},          {0x1400, 2, 1, 255},        {0x1400, 1, 4, 0x202},      {0x1800, 1, 4, 0xC0000182},
        {0x1A00, 0, 1, 0},          {0x1A00, 1, 4, 0x60410010}, {0x1A00, 2, 4, 0x60640020}, {0x1A00, 0, 1, 2},
        {0x1800, 2, 1, 255},        {0x1800, 3, 2, 7},          {0x1800, 5, 2, 10},         {0x1800, 1, 4, 0x40000182},
    };
    bring_up(&common);
    TEST_ASSERT_EQUAL_UINT(COUNT_OF(expected), played.write_count);
    for (size_t i = 0; i < COUNT_OF(expected); i++) {
        const scripted_write_t *found = &played.writes[i];
        TEST_ASSERT_EQUAL_HEX16(expected[i].index, found->index);
        TEST_ASSERT_EQUAL_HEX8(expected[i].subindex, found->subindex);
        TEST_ASSERT_EQUAL_UINT8(expected[i].size, found->size);
        TEST_ASSERT_EQUAL_HEX32(expected[i].value, found->value);
    }
}

/* Drive units of another maker: gears, the other way round, two PDOs each way, a mode and a torque among them. */
static const tumble_drive_pdo_t other_receive[] = {
    {2, {.cob_id = 0x322, .type = 254, .count = 2, .map = {0x60600008, 0x60400010}}},
    {3, {.cob_id = 0x422, .type = 254, .count = 1, .map = {0x607A0020}}},
};
static const tumble_drive_pdo_t other_transmit[] = {
    {1, {.cob_id = 0x2A2, .type = 254, .count = 3, .event_ms = 20, .map = {0x60410010, 0x60610008, 0x60770010}}},
    {2, {.cob_id = 0x3A2, .type = 254, .count = 2, .event_ms = 20, .map = {0x60640020, 0x60790020}}},
};
static const tumble_object_write_t other_writes[] = {{0x1802, 1, 4, 0x800002A2}, {0x6007, 0, 2, 3}};

static tumble_drive_profile_t other_profile(void)
{
    tumble_drive_profile_t profile = common;
    profile.counts_per_revolution = 14400.0 * 101.0 / 3.0; /* not whole per degree */
    profile.velocity_units_per_deg_s = 1.0 / 6.0;          /* rpm */
    profile.velocity_deg_s = 90.0;
    profile.sign = -1;
    profile.receive = other_receive;
    profile.transmit = other_transmit;
    profile.receive_count = 2;
    profile.transmit_count = 2;
    profile.writes = other_writes;
    profile.write_count = 2;
    return profile;
}

/* Every quantity that the profile may have, in the drive's units. */
static void test_all_quantities(void)
{
    static const scripted_write_t expected[] = {
        {0x6081, 0, 4, 100}, {0x6083, 0, 4, 400}, {0x6084, 0, 4, 600},  {0x6085, 0, 4, 800},
        {0x6099, 1, 4, 500}, {0x6099, 2, 4, 600}, {0x609A, 0, 4, 1400},
    };
    bring_up(CHANGED(common, made.acceleration_units_per_deg_s2 = 200.0, made.velocity_deg_s = 1.0,
                     made.acceleration_deg_s2 = 2.0, made.deceleration_deg_s2 = 3.0, made.quick_stop_deg_s2 = 4.0,
                     made.homing_fast_deg_s = 5.0, made.homing_slow_deg_s = 6.0,
                     made.homing_acceleration_deg_s2 = 7.0));
    for (size_t i = 0; i < COUNT_OF(expected); i++) {
        TEST_ASSERT_EQUAL_MEMORY(&expected[i], &played.writes[4U + i], sizeof expected[i]);
    }
}

static void test_another_maker(void)
{
    bring_home(MADE(other_profile()));
    TEST_ASSERT_EQUAL_HEX16(0x1802, played.writes[0].index);
    TEST_ASSERT_EQUAL_HEX16(0x6007, played.writes[1].index);
    TEST_ASSERT_EQUAL_HEX16(0x1016, played.writes[2].index); /* the profile's own first, then all that any drive gets */
    move_to(10.0);
    TEST_ASSERT_EQUAL_INT32(-13467, played.target); /* -10 / 360 * 484,800 = -13,466.67 */
    TEST_ASSERT_DOUBLE_WITHIN(0.5 * 360.0 / 484800.0, 10.0, bench.stand.kind->angle_deg(bench.stand.self));
    bool found = false;
    for (unsigned i = 0; i < played.write_count; i++) {
        found = found || ((played.writes[i].index == 0x6081U) && (played.writes[i].value == 15U));
    }
    TEST_ASSERT_TRUE(found);
}

/* The mode travels with the controlword, so the process data must say what the SDO says. */
static void test_a_mode_in_the_process_data_is_kept(void)
{
    bring_home(CHANGED(other_profile(), made.transmit = common_transmit, made.transmit_count = 1));
    TEST_ASSERT_EQUAL_INT8(1, played.mode);
    move_to(10.0);
    TEST_ASSERT_EQUAL_INT8(1, played.mode);
}

static void test_a_wrapping_drive_goes_long_ways_in_quarters(void)
{
    static const double angles_deg[] = {45.0, 360.0, -5.0, 0.0, 315.0, 405.0, -180.0};
    bring_up(MADE(wrapping()));
    played.wrap = 36000;
    go_home();
    for (size_t i = 0; i < COUNT_OF(angles_deg); i++) {
        move_to(angles_deg[i]);
        assert_angle(angles_deg[i]);
        TEST_ASSERT_TRUE((played.target >= 0) && (played.target < 36000));
    }
}

/* Homing ends a count or so beside zero, on either side of the wrap: the table is at home, not a turn away. */
static void test_a_wrapping_drive_is_at_home_on_either_side(void)
{
    static const int32_t homes[] = {35999, 35990, 0, 1, 17999, 18001};
    static const double angles_deg[] = {-0.01, -0.1, 0.0, 0.01, 179.99, -179.99};
    tumble_drive_profile_t profile = wrapping();
    for (size_t i = 0; i < COUNT_OF(homes); i++) {
        bring_up(&profile);
        played.wrap = 36000;
        played.home = homes[i];
        go_home();
        assert_angle(angles_deg[i]);
        run_ms(50); /* and it stays there as the drive goes on reporting */
        assert_angle(angles_deg[i]);
    }
}

static void test_a_short_way_from_beside_home_is_short(void)
{
    bring_up(MADE(wrapping()));
    played.wrap = 36000;
    played.home = 35999;
    go_home();
    const unsigned before = played.control_count;
    move_to(45.0);
    assert_angle(45.0);
    TEST_ASSERT_EQUAL_INT32(4500, played.controls[before].target); /* in one go, and not down */
    TEST_ASSERT_EQUAL_UINT(before + 3U, played.control_count);
}

static void test_angles_beyond_the_drive(void)
{
    bring_home(&common);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, bench.stand.kind->move(bench.stand.self, 2.2e7));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, bench.stand.kind->move(bench.stand.self, -2.2e7));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, bench.stand.kind->move(bench.stand.self, (double)NAN));
    assert_state_after(0, TUMBLE_STAND_IN_POSITION);
}

/* Half a count goes away from zero, as people round. */
static void test_rounding(void)
{
    static const double angles_deg[] = {0.004, 0.006, -0.004, -0.006, 0.005, -0.005};
    static const int32_t counts[] = {0, 1, 0, -1, 1, -1};
    bring_home(&common);
    for (size_t i = 0; i < COUNT_OF(counts); i++) {
        move_to(angles_deg[i]);
        TEST_ASSERT_EQUAL_INT32(counts[i], played.target);
    }
}

#define EXPECT_BAD(change)                                                                                             \
    do {                                                                                                               \
        tumble_drive_profile_t profile = common;                                                                       \
        ASSERT_STATUS(TUMBLE_OK, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));                            \
        profile.change;                                                                                                \
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));                    \
    } while (0)

static void test_profiles_that_cannot_be(void)
{
    static const tumble_drive_pdo_t without_target[] = {
        {0, {.cob_id = 0x202, .count = 2, .map = {0x60400010, 0x60600008}}}};
    static const tumble_drive_pdo_t without_control[] = {
        {0, {.cob_id = 0x202, .count = 2, .map = {0x60600008, 0x607A0020}}}};
    static const tumble_drive_pdo_t without_status[] = {
        {0, {.cob_id = 0x182, .count = 2, .map = {0x60610008, 0x60640020}}}};
    static const tumble_drive_pdo_t without_position[] = {
        {0, {.cob_id = 0x182, .count = 2, .map = {0x60410010, 0x60610008}}}};
    static const tumble_drive_pdo_t too_many[] = {
        {0, {.cob_id = 0x182, .count = 9, .map = {0x60410010, 0x60640020, 0, 0, 0, 0, 0, 0}}}};
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_drive402_validate(NULL, SCRIPTED_MASTER_NODE));
    EXPECT_BAD(counts_per_revolution = 0.0);
    EXPECT_BAD(counts_per_revolution = (double)NAN);
    EXPECT_BAD(velocity_units_per_deg_s = -1.0);
    EXPECT_BAD(acceleration_units_per_deg_s2 = (double)INFINITY);
    EXPECT_BAD(sign = 0);
    EXPECT_BAD(sign = 2);
    EXPECT_BAD(wrap_counts = 0x80000000U);
    EXPECT_BAD(velocity_deg_s = 0.004); /* rounds to nothing */
    EXPECT_BAD(velocity_deg_s = 4.3e7); /* more than 32 bits */
    EXPECT_BAD(velocity_deg_s = -1.0);
    EXPECT_BAD(homing_slow_deg_s = (double)NAN);
    EXPECT_BAD(stop = 2);
    EXPECT_BAD(receive = NULL);
    EXPECT_BAD(receive_count = 0);
    EXPECT_BAD(receive_count = 3);
    EXPECT_BAD(transmit_count = 3);
    EXPECT_BAD(receive = without_target);
    EXPECT_BAD(receive = without_control);
    EXPECT_BAD(transmit = without_status);
    EXPECT_BAD(transmit = without_position);
    EXPECT_BAD(transmit = too_many);
    EXPECT_BAD(write_count = 1);
    EXPECT_BAD(start_timeout_ms = 0);
    EXPECT_BAD(power_timeout_ms = 0);
    EXPECT_BAD(handshake_timeout_ms = 0);
    EXPECT_BAD(home_timeout_ms = 0);
    EXPECT_BAD(move_timeout_ms = 0);
    EXPECT_BAD(stop_timeout_ms = 0);
}

/* NMT, SYNC, EMCY, TIME, SDO, the block, heartbeats, what CiA 301 reserves; our own; 29 bits; switched off. */
static void test_identifiers_that_are_taken(void)
{
    static const uint32_t taken[] = {0x000, 0x080, 0x081, 0x0FF, 0x100, 0x180, 0x181, 0x381,      0x401,
                                     0x580, 0x582, 0x602, 0x683, 0x693, 0x6E0, 0x702, 0x80000202, 0x20000202};
    static const uint32_t free_ids[] = {0x183, 0x201, 0x40000203, 0x57F};
    tumble_drive_pdo_t receive = common_receive[0];
    tumble_drive_profile_t profile = common;
    profile.receive = &receive;
    for (size_t i = 0; i < COUNT_OF(taken); i++) {
        receive.setup.cob_id = taken[i];
        ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));
    }
    for (size_t i = 0; i < COUNT_OF(free_ids); i++) {
        receive.setup.cob_id = free_ids[i];
        ASSERT_STATUS(TUMBLE_OK, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));
    }
    receive.setup.cob_id = 0x181;
    ASSERT_STATUS(TUMBLE_OK, tumble_drive402_validate(&profile, 9));
    receive.setup.cob_id = 0x189;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_drive402_validate(&profile, 9));
}

/* Any two of the four, whatever bit 30 says. */
static void test_identifiers_that_are_wanted_twice(void)
{
    for (size_t one = 0; one < 4U; one++) {
        for (size_t other = 0; other < one; other++) {
            tumble_drive_pdo_t pdos[4] = {other_receive[0], other_receive[1], other_transmit[0], other_transmit[1]};
            tumble_drive_profile_t profile = other_profile();
            profile.receive = &pdos[0];
            profile.transmit = &pdos[2];
            ASSERT_STATUS(TUMBLE_OK, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));
            pdos[one].setup.cob_id = pdos[other].setup.cob_id | 0x40000000U;
            ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_drive402_validate(&profile, SCRIPTED_MASTER_NODE));
        }
    }
}

static void test_further_writes_of_a_wrong_size(void)
{
    tumble_object_write_t odd = {0x6007, 0, 2, 1};
    ASSERT_STATUS(TUMBLE_OK, tumble_drive402_validate(CHANGED(common, made.writes = &odd, made.write_count = 1),
                                                      SCRIPTED_MASTER_NODE));
    odd.size = 3;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_drive402_validate(&made, SCRIPTED_MASTER_NODE));
}

static void test_init_refuses_what_the_node_cannot_carry(void)
{
    static const tumble_drive_pdo_t odd_bits[] = {
        {0, {.cob_id = 0x182, .type = 255, .count = 3, .map = {0x60410010, 0x60640020, 0x606C0018}}}};
    static const tumble_drive_pdo_t unknown[] = {
        {0, {.cob_id = 0x202, .type = 255, .count = 3, .map = {0x60400010, 0x607A0020, 0x60FF0010}}}};
    static const tumble_drive_pdo_t reserved[] = {
        {0, {.cob_id = 0x000, .type = 255, .count = 2, .map = {0x60400010, 0x607A0020}}}};
    bench_setup(&common);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, drive_init(CHANGED(common, made.transmit = odd_bits), 2));
    made = common;
    made.receive = unknown;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, drive_init(&made, 2));
    made.receive = reserved;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, drive_init(&made, 2));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, drive_init(NULL, 2));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, drive_init(&common, 0));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, drive_init(&common, 128));
}
