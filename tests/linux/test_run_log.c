/* What the logs tell of a run and of its result, and that every reason has its remedy. */
#include "log_pipe.h"
#include "run_log.h"
#include "suite.h"

#include <stdio.h>
#include <string.h>

static const around_t around_each = {NULL, log_pipe_close};

static const tumble_progress_t no_cause = {.reason = TUMBLE_REASON_NONE};
static const tumble_progress_t stalled = {.state = TUMBLE_STATE_FAULT,
                                          .reason = TUMBLE_REASON_STALL,
                                          .failed_in = TUMBLE_STATE_MOVE,
                                          .mounting = 1,
                                          .position = 3,
                                          .index = 2,
                                          .count = 18,
                                          .finished = 2,
                                          .drive_code = 0x7500};
static const tumble_progress_t given_up = {.state = TUMBLE_STATE_ABORT,
                                           .reason = TUMBLE_REASON_COMMAND,
                                           .mounting = 1,
                                           .position = 3,
                                           .index = 2,
                                           .count = 18,
                                           .finished = 2};

/* The lines since the last call, which must be these. */
static void expect(const char *lines)
{
    TEST_ASSERT_EQUAL_STRING(lines, log_pipe_read());
}

static void expect_within(const char *part)
{
    const char *const lines = log_pipe_read();
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(lines, part), lines);
}

/* Remedies. */

static void test_every_reason_has_a_remedy_of_its_own(void)
{
    log_pipe_open(NULL, NULL);
    for (unsigned a = 0; a < (unsigned)TUMBLE_REASON_COUNT; a++) {
        TEST_ASSERT_NOT_NULL(tumble_reason_remedy((tumble_reason_t)a));
        TEST_ASSERT_TRUE(strlen(tumble_reason_remedy((tumble_reason_t)a)) > 15U);
        for (unsigned b = 0; b < a; b++) {
            TEST_ASSERT_TRUE(
                strcmp(tumble_reason_remedy((tumble_reason_t)a), tumble_reason_remedy((tumble_reason_t)b)) != 0);
        }
    }
    TEST_ASSERT_EQUAL_STRING("The axis does not follow: brake, obstacle, current limit.",
                             tumble_reason_remedy(TUMBLE_REASON_STALL));
    TEST_ASSERT_EQUAL_STRING("This reason is not in the list.", tumble_reason_remedy(TUMBLE_REASON_COUNT));
}

/* A run. */

static void test_a_fault_in_plain_is_the_sentence_of_old(void)
{
    log_pipe_open(NULL, NULL);
    run_log_state(&stalled, &stalled, true);
    expect(
        "tumble-node: fault at position 1.3 (TUMBLE_REASON_STALL in TUMBLE_STATE_MOVE): the axis did not follow its "
        "command; waits for RESUME or ABORT\n");
    run_log_state(&given_up, &stalled, true);
    expect("");
}

static void test_a_fault_in_text_has_its_remedy(void)
{
    log_pipe_open("text", NULL);
    run_log_state(&stalled, &stalled, false);
    expect(LOG_PIPE_TIME
           " tumble-node: error: fault at position 1.3 (TUMBLE_REASON_STALL in TUMBLE_STATE_MOVE): the "
           "axis did not follow its command. Remedy: The axis does not follow: brake, obstacle, current "
           "limit.\n");
}

static void test_a_fault_in_json_has_its_members(void)
{
    log_pipe_open("json", NULL);
    run_log_state(&stalled, &stalled, true);
    expect_within(
        "\"level\":\"error\",\"event\":\"fault\",\"state\":\"TUMBLE_STATE_MOVE\",\"mounting\":1,\"position\":3,"
        "\"reason\":\"TUMBLE_REASON_STALL\",\"reason_number\":9,\"sentence\":\"the axis did not follow its "
        "command\",\"remedy\":\"The axis does not follow: brake, obstacle, current limit.\",\"drive_code\":29952,");
}

/* The longest of all sentences, remedies and names fit into a line. */
static void test_no_fault_is_cut_off(void)
{
    for (unsigned reason = 0; reason < (unsigned)TUMBLE_REASON_COUNT; reason++) {
        tumble_progress_t now = stalled;
        now.reason = (tumble_reason_t)reason;
        now.failed_in = TUMBLE_STATE_WAIT_MOUNTING;
        now.mounting = UINT8_MAX;
        now.position = UINT8_MAX;
        log_pipe_open("json", NULL);
        run_log_state(&now, &now, true);
        const char *const line = log_pipe_read();
        const char *const remedy = tumble_reason_remedy(now.reason);
        TEST_ASSERT_TRUE(strlen(line) > strlen(remedy) + 4U);
        TEST_ASSERT_EQUAL_MEMORY(remedy, line + strlen(line) - strlen(remedy) - 3U, strlen(remedy));
        log_pipe_close();
    }
    log_pipe_open(NULL, NULL);
}

static void test_an_abort_tells_its_first_cause(void)
{
    log_pipe_open("text", NULL);
    run_log_state(&given_up, &stalled, true);
    expect(LOG_PIPE_TIME
           " tumble-node: warning: TUMBLE_STATE_ABORT at position 1.3, 2 of 18 finished: given up, table "
           "stopped: aborted by command; first cause at position 1.3: TUMBLE_REASON_STALL in "
           "TUMBLE_STATE_MOVE, the axis did not follow its command\n");
    run_log_state(&given_up, &no_cause, true);
    expect(LOG_PIPE_TIME
           " tumble-node: warning: TUMBLE_STATE_ABORT at position 1.3, 2 of 18 finished: given up, table "
           "stopped: aborted by command. Remedy: Somebody gave ABORT, or the node was reset.\n");
}

/* Seen from outside, where nobody has seen the first cause: no guess at it. */
static void test_an_abort_whose_cause_is_not_known(void)
{
    log_pipe_open("json", NULL);
    run_log_state(&given_up, NULL, false);
    expect_within(
        ",\"reason\":\"TUMBLE_REASON_COMMAND\",\"message\":\"TUMBLE_STATE_ABORT at position 1.3, 2 of 18 "
        "finished: given up, table stopped: aborted by command\"}\n");
}

static void test_what_is_news(void)
{
    tumble_progress_t now = stalled;
    TEST_ASSERT_FALSE(run_log_is_news(&now, &stalled));
    now.samples++;
    now.drive_code = 0;
    TEST_ASSERT_FALSE(run_log_is_news(&now, &stalled));
    now = stalled;
    now.failed_in = TUMBLE_STATE_PREFLIGHT;
    TEST_ASSERT_TRUE(run_log_is_news(&now, &stalled));
    now = stalled;
    now.index++;
    TEST_ASSERT_TRUE(run_log_is_news(&now, &stalled));
    now = stalled;
    now.attempt++;
    TEST_ASSERT_TRUE(run_log_is_news(&now, &stalled));
    now = stalled;
    now.reason = TUMBLE_REASON_DRIVE_FAULT;
    TEST_ASSERT_TRUE(run_log_is_news(&now, &stalled));
    TEST_ASSERT_TRUE(run_log_is_news(&given_up, &stalled));
}

static void expect_state(tumble_state_t state, tumble_reason_t reason, const char *part)
{
    const tumble_progress_t now = {
        .state = state, .reason = reason, .mounting = 2, .position = 1, .finished = 9, .count = 18};
    run_log_state(&now, &no_cause, true);
    expect_within(part);
}

static void test_states_have_their_levels(void)
{
    log_pipe_open("text", NULL);
    expect_state(TUMBLE_STATE_MOVE, TUMBLE_REASON_NONE,
                 ": info: TUMBLE_STATE_MOVE at position 2.1, 9 of 18 finished: turning the table\n");
    expect_state(TUMBLE_STATE_WAIT_MOUNTING, TUMBLE_REASON_NONE, ": notice: TUMBLE_STATE_WAIT_MOUNTING at ");
    expect_state(TUMBLE_STATE_DONE, TUMBLE_REASON_NONE,
                 ": notice: TUMBLE_STATE_DONE at position 2.1, 9 of 18 finished: "
                 "finished\n");
    expect_state(TUMBLE_STATE_DONE, TUMBLE_REASON_GRAVITY_CHECK,
                 ": warning: TUMBLE_STATE_DONE at position 2.1, 9 of 18 "
                 "finished: finished: the result fails the gravity "
                 "check. Remedy: DONE, but ");
}

/* A result. */

static run_log_sets_t told;

static void expect_verdict(tumble_verdict_t verdict, const char *line)
{
    const tumble_sets_state_t state = {
        .verdict = (uint8_t)verdict, .counter = 4, .objections = 0x41, .status = (uint8_t)TUMBLE_E_NV};
    told = (run_log_sets_t){.has_begun = true, .verdict = UINT8_MAX, .counter = 3};
    run_log_sets(&told, &state);
    expect(line);
    run_log_sets(&told, &state);
    expect(""); /* once */
}

#define AT LOG_PIPE_TIME " tumble-node: "

static void test_verdicts(void)
{
    log_pipe_open("text", NULL);
    expect_verdict(TUMBLE_VERDICT_NONE, "");
    expect_verdict(TUMBLE_VERDICT_WORKING, "");
    expect_verdict(TUMBLE_VERDICT_COMMITTED, AT "notice: the result is committed: calibration counter 4\n");
    expect_verdict(TUMBLE_VERDICT_ACCEPTED, AT "notice: the proposal is accepted: calibration counter 4\n");
    expect_verdict(TUMBLE_VERDICT_ROLLED_BACK, AT "notice: the set before is active again: calibration counter 4\n");
    expect_verdict(TUMBLE_VERDICT_DISCARDED, AT "notice: the proposal is discarded\n");
    expect_verdict(TUMBLE_VERDICT_REPEATED, AT "warning: the result is one of before, to the last bit: not stored\n");
    expect_verdict(TUMBLE_VERDICT_HELD, AT
                   "warning: the result is held, ACCEPT or DISCARD it: TUMBLE_OBJECTION_GRAVITY_CHECK, the result "
                   "fails the gravity check; TUMBLE_OBJECTION_FIRST, there is no active set to compare with\n");
    expect_verdict(TUMBLE_VERDICT_FAILED, AT
                   "error: the memory failed: TUMBLE_E_NV, the non-volatile memory failed, or has no such place; "
                   "the active set is unchanged\n");
}

/* As many objections as there can be: a line all the same. */
static void test_all_objections_at_once(void)
{
    const tumble_sets_state_t state = {.verdict = (uint8_t)TUMBLE_VERDICT_HELD, .objections = UINT16_MAX};
    told = (run_log_sets_t){.has_begun = true};
    log_pipe_open("json", NULL);
    run_log_sets(&told, &state);
    const char *const line = log_pipe_read();
    TEST_ASSERT_NOT_NULL(strstr(line, "\"objections\":65535,\"sentence\":\"TUMBLE_OBJECTION_GRAVITY_CHECK, "));
    TEST_ASSERT_EQUAL_STRING("\"}\n", line + strlen(line) - 3U);
}

/* Of every set of objections, the line tells the first ones whole and counts the others. */
static void test_no_objection_is_cut_off(void)
{
    for (unsigned bits = 1; bits < 1U << (unsigned)TUMBLE_OBJECTION_COUNT; bits += 37U) {
        const tumble_sets_state_t state = {.verdict = (uint8_t)TUMBLE_VERDICT_HELD,
                                           .objections = (uint16_t)bits,
                                           .more_objections = (uint16_t)(bits >> TUMBLE_OBJECTION_MORE)};
        char whole[2000] = "the result is held, ACCEPT or DISCARD it: ";
        unsigned left = 0;
        told = (run_log_sets_t){.has_begun = true};
        log_pipe_open("text", NULL);
        run_log_sets(&told, &state);
        const char *line = strstr(log_pipe_read(), whole);
        TEST_ASSERT_NOT_NULL(line);
        line += strlen(whole);
        for (unsigned bit = 0; bit < (unsigned)TUMBLE_OBJECTION_COUNT; bit++) {
            if ((bits >> bit & 1U) == 0U) {
                continue;
            }
            (void)snprintf(whole, sizeof whole, "%s, %s", tumble_objection_name((tumble_objection_t)bit),
                           tumble_objection_sentence((tumble_objection_t)bit));
            const bool is_told = left == 0U && strncmp(line, whole, strlen(whole)) == 0;
            line += is_told ? strlen(whole) : 0U;
            line += (is_told && strncmp(line, "; ", 2) == 0) ? 2U : 0U;
            left += is_told ? 0U : 1U;
        }
        (void)snprintf(whole, sizeof whole, "and %u more\n", left);
        TEST_ASSERT_EQUAL_STRING((left > 0U) ? whole : "\n", line);
        log_pipe_close();
    }
    log_pipe_open(NULL, NULL);
}

static void show(tumble_verdict_t verdict, uint32_t counter, const char *line)
{
    const tumble_sets_state_t state = {.verdict = (uint8_t)verdict, .counter = counter};
    run_log_sets(&told, &state);
    expect(line);
}

#define ACCEPTED(counter) AT "notice: the proposal is accepted: calibration counter " #counter "\n"
#define COMMITTED(counter) AT "notice: the result is committed: calibration counter " #counter "\n"

/* The counter comes after the verdict; or the other way round; or at once. */
static void test_a_commit_is_told_once_with_its_own_counter(void)
{
    told = (run_log_sets_t){0};
    log_pipe_open("text", NULL);
    show(TUMBLE_VERDICT_NONE, 0, "");
    show(TUMBLE_VERDICT_NONE, 7, ""); /* the memory has been looked through */
    show(TUMBLE_VERDICT_WORKING, 7, "");
    show(TUMBLE_VERDICT_ACCEPTED, 7, "");
    show(TUMBLE_VERDICT_ACCEPTED, 8, ACCEPTED(8));
    show(TUMBLE_VERDICT_ACCEPTED, 8, "");
    show(TUMBLE_VERDICT_WORKING, 9, "");
    show(TUMBLE_VERDICT_COMMITTED, 9, COMMITTED(9));
    show(TUMBLE_VERDICT_COMMITTED, 10, COMMITTED(10));
    show(TUMBLE_VERDICT_COMMITTED, 9, ""); /* it has decayed */
    show(TUMBLE_VERDICT_DISCARDED, 9, AT "notice: the proposal is discarded\n");
    show(TUMBLE_VERDICT_WORKING, 9, "");
    show(TUMBLE_VERDICT_DISCARDED, 9, AT "notice: the proposal is discarded\n");
}

static void test_what_was_so_at_first_is_no_event(void)
{
    told = (run_log_sets_t){0};
    log_pipe_open("text", NULL);
    show(TUMBLE_VERDICT_ACCEPTED, 4, "");
    show(TUMBLE_VERDICT_ACCEPTED, 5, ACCEPTED(5));
    told = (run_log_sets_t){0};
    show(TUMBLE_VERDICT_HELD, 4, "");
}
