/* The operator of a stand whose firmware runs elsewhere: what he sends to node 1 by SDO, and when. */
#include "scenario_file.h"
#include "stand_bridge.h"
#include "stand_operator.h"
#include "suite.h"

#include <stdio.h>
#include <string.h>

static bench_config_t config;
static bench_world_t world;
static stand_operator_t operator;

/* What he has sent, in its order. */
static tumble_can_frame_t sent[20];
static uint32_t sent_count;

static void on_frame(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    (void)context;
    (void)time_us;
    if (sender == STAND_BUS_OPERATOR) {
        TEST_ASSERT_TRUE(sent_count < 20U);
        sent[sent_count++] = *frame;
    }
}

static uint32_t
    server_below; /* so much lower than those of the first SDO server are his identifiers: first, the second's */

static bench_watcher_t watcher = {.on_frame = on_frame};

static void start(stand_operator_kind_t kind)
{
    TEST_ASSERT_TRUE(bench_config_prepare_stand(&config, NULL));
    config.scenario.operator.mount_s = 2.0;
    config.scenario.operator.mend_s = 1.0;
    config.scenario.operator.mends = 1;
    config.virtual_limit_s = 1e9;
    TEST_ASSERT_EQUAL(TUMBLE_OK, bench_world_init(&world, &config, 1, &watcher));
    stand_operator_init(&operator, kind);
    sent_count = 0;
    server_below = 0x200U;
}

/* The world and he, for so long. */
static void run_s(double seconds)
{
    const uint64_t end_us = world.clock.now_us + (uint64_t)(seconds * 1e6);
    while (world.clock.now_us < end_us) {
        const uint64_t step_us = world.clock.now_us + 1000U;
        while (bench_world_next_us(&world) <= step_us && bench_world_advance(&world)) {
            /* all that is due */
        }
        bench_world_pass(&world, step_us);
        stand_operator_step(&operator, &world);
    }
}

static void expect_sent_after(double seconds, uint32_t count)
{
    run_s(seconds);
    TEST_ASSERT_EQUAL_UINT32(count, sent_count);
}

/* From now on he asks the other of the two SDO servers: the one before did not answer. */
static void other_server(void)
{
    server_below = 0x200U - server_below;
}

static void tell_state(tumble_state_t state, tumble_reason_t reason, uint8_t index)
{
    const tumble_can_frame_t frame = {0x181, 8, {(uint8_t)state, (uint8_t)reason, index}};
    stand_operator_hear(&operator, &world, &frame);
}

static void answer_sdo(uint8_t command, uint8_t subindex)
{
    const tumble_can_frame_t frame = {(uint16_t)(0x581U - server_below), 8, {command, 0x02, 0x20, subindex}};
    stand_operator_hear(&operator, &world, &frame);
}

/* His last request: one byte into 2002h. */
static void expect_request(uint32_t count, uint8_t subindex, uint8_t value)
{
    const uint8_t data[8] = {0x2F, 0x02, 0x20, subindex, value};
    TEST_ASSERT_EQUAL_UINT32(count, sent_count);
    TEST_ASSERT_EQUAL_HEX16(0x601U - server_below, sent[count - 1U].id);
    TEST_ASSERT_EQUAL_UINT8(8, sent[count - 1U].length);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(data, sent[count - 1U].data, 8);
}

/* The argument, then the command; both are taken. */
static void expect_command(uint32_t before, uint8_t command, uint8_t argument)
{
    run_s(0.01);
    expect_request(before + 1U, 1, argument);
    answer_sdo(0x60, 1);
    run_s(0.01);
    expect_request(before + 2U, 2, command);
    answer_sdo(0x60, 2);
    run_s(0.01);
    TEST_ASSERT_EQUAL_UINT32(before + 2U, sent_count);
}

static void test_a_mounting_is_made_and_confirmed_after_its_time(void)
{
    start(STAND_OPERATOR_MOUNTS);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
    expect_sent_after(1.98, 0);
    TEST_ASSERT_EQUAL_UINT32(0, world.operator.mounted[1]);
    run_s(0.03);
    expect_command(0, TUMBLE_COMMAND_CONFIRM_MOUNTING, 2);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mounted[1]);
    TEST_ASSERT_EQUAL_UINT32(1, operator.answers);
    expect_sent_after(5.0, 2);
}

static void test_he_starts_once(void)
{
    start(STAND_OPERATOR_STARTS);
    tell_state(TUMBLE_STATE_IDLE, TUMBLE_REASON_NONE, 0);
    expect_command(0, TUMBLE_COMMAND_START, 0);
    tell_state(TUMBLE_STATE_PREFLIGHT, TUMBLE_REASON_NONE, 0);
    tell_state(TUMBLE_STATE_IDLE, TUMBLE_REASON_NONE, 0);
    expect_sent_after(5.0, 2);
}

static void test_who_does_not_answer_is_asked_again(void)
{
    start(STAND_OPERATOR_STARTS);
    tell_state(TUMBLE_STATE_IDLE, TUMBLE_REASON_NONE, 0);
    run_s(0.01);
    expect_request(1, 1, 0);
    expect_sent_after(0.28, 1);
    run_s(0.03);
    other_server();
    expect_request(2, 1, 0);
    answer_sdo(0x60, 1);
    run_s(0.01);
    expect_request(3, 2, TUMBLE_COMMAND_START);
    run_s(0.35);
    other_server();
    expect_request(4, 1, 0); /* from the argument on */
    answer_sdo(0x80, 1);     /* refused: a second later again */
    TEST_ASSERT_EQUAL_UINT32(1, operator.refusals);
    run_s(0.01);
    expect_request(5, 1, 0);
    expect_sent_after(0.98, 5);
    run_s(0.03);
    other_server();
    expect_request(6, 1, 0);
}

static void test_what_is_not_for_him_is_ignored(void)
{
    static const tumble_can_frame_t FRAMES[] = {
        {0x181, 7, {TUMBLE_STATE_WAIT_MOUNTING}},
        {0x181, 8, {TUMBLE_STATE_COUNT}},
        {0x181, 8, {TUMBLE_STATE_WAIT_MOUNTING, 0, 18}},
        {0x182, 8, {TUMBLE_STATE_WAIT_MOUNTING}},
        {0x381, 8, {0x60, 0x02, 0x20, 1}},
        {0x381, 3, {0x60, 0x02, 0x20}},
    };
    start(STAND_OPERATOR_MOUNTS);
    for (size_t i = 0; i < sizeof FRAMES / sizeof FRAMES[0]; i++) {
        stand_operator_hear(&operator, &world, &FRAMES[i]);
    }
    expect_sent_after(3.0, 0);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 0);
    run_s(2.01);
    expect_request(1, 1, 1);
    answer_sdo(0x60, 2); /* of the wrong subindex */
    const tumble_can_frame_t other = {0x381, 8, {0x60, 0x03, 0x20, 1}};
    stand_operator_hear(&operator, &world, &other);
    expect_sent_after(0.1, 1);
}

static void test_a_fault_is_mended_as_often_as_he_is_let(void)
{
    start(STAND_OPERATOR_MOUNTS);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 3);
    run_s(1.01);
    expect_command(0, TUMBLE_COMMAND_RESUME, 0);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mended);
    tell_state(TUMBLE_STATE_MOVE, TUMBLE_REASON_NONE, 3);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 3);
    expect_sent_after(10.0, 2);
}

static void test_a_wrong_mounting_is_mounted_anew(void)
{
    start(STAND_OPERATOR_MOUNTS);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_WRONG_MOUNTING, 10);
    run_s(1.01);
    expect_command(0, TUMBLE_COMMAND_CONFIRM_MOUNTING, 2);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mounted[1]);
}

static void test_hands_mount_and_mend_at_once_and_say_nothing(void)
{
    start(STAND_OPERATOR_HANDS);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
    run_s(0.002);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mounted[1]);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
    run_s(5.0);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mounted[1]);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 10);
    run_s(0.002);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mended);
    tell_state(TUMBLE_STATE_IDLE, TUMBLE_REASON_NONE, 0);
    expect_sent_after(10.0, 0);
}

static void test_who_follows_mounts_when_others_have_confirmed(void)
{
    start(STAND_OPERATOR_FOLLOWS);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
    run_s(600.0);
    TEST_ASSERT_EQUAL_UINT32(0, world.operator.mounted[1]);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 0); /* the other one is repeated: nobody confirmed */
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
    TEST_ASSERT_EQUAL_UINT32(0, world.operator.mounted[0] + world.operator.mounted[1]);
    tell_state(TUMBLE_STATE_HOME, TUMBLE_REASON_NONE, 9);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mounted[1]);
    tell_state(TUMBLE_STATE_MOVE, TUMBLE_REASON_NONE, 10);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mounted[1]);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_WRONG_MOUNTING, 10);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mounted[1]);
    tell_state(TUMBLE_STATE_MOVE, TUMBLE_REASON_NONE, 10);
    TEST_ASSERT_EQUAL_UINT32(2, world.operator.mounted[1]);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mended);
    expect_sent_after(10.0, 0);
}

static void test_who_follows_mounts_nothing_where_nobody_confirmed(void)
{
    static const tumble_state_t STATES[] = {TUMBLE_STATE_FAULT, TUMBLE_STATE_ABORT, TUMBLE_STATE_IDLE};
    for (size_t i = 0; i < sizeof STATES / sizeof STATES[0]; i++) {
        start(STAND_OPERATOR_FOLLOWS);
        tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
        tell_state(STATES[i], TUMBLE_REASON_MOUNTING_NOT_CONFIRMED, 9);
        TEST_ASSERT_EQUAL_UINT32(0, world.operator.mounted[1]);
    }
}

static void test_who_follows_mends_when_node_1_goes_on_as_often_as_he_is_let(void)
{
    start(STAND_OPERATOR_FOLLOWS);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 3);
    expect_sent_after(10.0, 0);
    TEST_ASSERT_EQUAL_UINT32(0, world.operator.mended);
    tell_state(TUMBLE_STATE_PREFLIGHT, TUMBLE_REASON_NONE, 3);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mended);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 3);
    tell_state(TUMBLE_STATE_MOVE, TUMBLE_REASON_NONE, 3);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mended);
    TEST_ASSERT_EQUAL_UINT32(0, world.operator.mounted[0]);
}

static void test_who_is_to_do_nothing_does_nothing(void)
{
    start(STAND_OPERATOR_NONE);
    tell_state(TUMBLE_STATE_IDLE, TUMBLE_REASON_NONE, 0);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 0);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 0);
    expect_sent_after(5.0, 0);
    TEST_ASSERT_FALSE(stand_operator_answer(&operator, &world, "done"));
}

/* A person. */

static void test_a_person_is_waited_for_and_does_it(void)
{
    start(STAND_OPERATOR_ASKS);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
    expect_sent_after(60.0, 0);
    TEST_ASSERT_TRUE(stand_operator_answer(&operator, &world, "done"));
    expect_command(0, TUMBLE_COMMAND_CONFIRM_MOUNTING, 2);
    TEST_ASSERT_EQUAL_UINT32(1, world.operator.mounted[1]);
}

/* Node 1 itself has asked the person: that may be known before its state PDO is. */
static void test_an_answer_that_is_there_before_its_question(void)
{
    start(STAND_OPERATOR_ASKS);
    TEST_ASSERT_TRUE(stand_operator_answer(&operator, &world, "done"));
    run_s(1.9);
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
    expect_command(0, TUMBLE_COMMAND_CONFIRM_MOUNTING, 2);
    start(STAND_OPERATOR_ASKS);
    TEST_ASSERT_TRUE(stand_operator_answer(&operator, &world, "done"));
    run_s(2.1); /* so long before it was no answer to it */
    tell_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, 9);
    expect_sent_after(5.0, 0);
    TEST_ASSERT_TRUE(stand_operator_answer(&operator, &world, "repeat position 1"));
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 9); /* another question meanwhile */
    expect_command(0, TUMBLE_COMMAND_REPEAT_POSITION, 1);
}

static void test_a_person_says_what_is_to_be_done_after_a_fault(void)
{
    typedef struct {
        const char *line;
        uint8_t command;
        uint8_t argument;
    } said_t;
    static const said_t SAID[] = {
        {"done", TUMBLE_COMMAND_RESUME, 0},
        {"abort", TUMBLE_COMMAND_ABORT, 0},
        {"repeat position 0", TUMBLE_COMMAND_REPEAT_POSITION, 0},
        {"repeat position 17", TUMBLE_COMMAND_REPEAT_POSITION, 17},
        {"repeat mounting 255", TUMBLE_COMMAND_REPEAT_MOUNTING, 255},
    };
    for (size_t i = 0; i < sizeof SAID / sizeof SAID[0]; i++) {
        start(STAND_OPERATOR_ASKS);
        tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 3);
        TEST_ASSERT_TRUE_MESSAGE(stand_operator_answer(&operator, &world, SAID[i].line), SAID[i].line);
        expect_command(0, SAID[i].command, SAID[i].argument);
    }
}

static void test_what_is_no_answer(void)
{
    static const char *const LINES[] = {"",
                                        "Done",
                                        "done ",
                                        "leave",
                                        "repeat",
                                        "abort now",
                                        "repeat position",
                                        "repeat position x",
                                        "repeat position 256",
                                        "repeat position 1 2",
                                        "repeat table 1"};
    start(STAND_OPERATOR_ASKS);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 3);
    for (size_t i = 0; i < sizeof LINES / sizeof LINES[0]; i++) {
        TEST_ASSERT_FALSE_MESSAGE(stand_operator_answer(&operator, &world, LINES[i]), LINES[i]);
    }
    expect_sent_after(1.0, 0);
}

/* Refused, it is not repeated behind the person's back; he may say something else. */
static void test_what_node_1_refuses_is_the_persons_affair(void)
{
    start(STAND_OPERATOR_ASKS);
    tell_state(TUMBLE_STATE_FAULT, TUMBLE_REASON_DRIVE_FAULT, 3);
    TEST_ASSERT_TRUE(stand_operator_answer(&operator, &world, "repeat mounting 7"));
    run_s(0.01);
    answer_sdo(0x60, 1);
    run_s(0.01);
    answer_sdo(0x80, 2);
    expect_sent_after(5.0, 2);
    TEST_ASSERT_EQUAL_UINT32(1, operator.refusals);
    TEST_ASSERT_TRUE(stand_operator_answer(&operator, &world, "done"));
    expect_command(2, TUMBLE_COMMAND_RESUME, 0);
}
