/* What tumble-node tells of its outputs, of commands that it refuses, of its interface. */
#include "log_pipe.h"
#include "node_log.h"
#include "suite.h"

#include <stdio.h>
#include <string.h>

static const around_t around_each = {NULL, log_pipe_close};

static void test_lines_that_nobody_reads_are_told_once(void)
{
    bool told = false;
    log_pipe_open("text", NULL);
    node_log_unread(&told, 0, "progress");
    TEST_ASSERT_EQUAL_STRING("", log_pipe_read());
    node_log_unread(&told, 1, "progress");
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: warning: nobody reads progress, lines of it are left out\n",
                             log_pipe_read());
    node_log_unread(&told, 2, "progress");
    TEST_ASSERT_EQUAL_STRING("", log_pipe_read());
}

static void test_lines_that_nobody_reads_are_an_event(void)
{
    bool told = false;
    log_pipe_open("json", NULL);
    node_log_unread(&told, 7, "standard output");
    TEST_ASSERT_NOT_NULL(
        strstr(log_pipe_read(), "\"level\":\"warning\",\"event\":\"unread\",\"output\":\"standard output\""));
}

/* Commands that are refused: which one was it? */

static node_log_t heard;

static void hear(uint16_t id, const uint8_t data[TUMBLE_CAN_MAX_BYTES])
{
    tumble_can_frame_t frame = {.id = id, .length = TUMBLE_CAN_MAX_BYTES};
    (void)memcpy(frame.data, data, sizeof frame.data);
    node_log_frame(&heard, &frame);
}

static void expect_refused(unsigned command)
{
    const tumble_progress_t idle = {.state = TUMBLE_STATE_IDLE};
    char expected[80];
    (void)snprintf(expected, sizeof expected, "\"command_number\":%u,", command);
    hear(0x581, (const uint8_t[8]){0x80, 0x02, 0x20, 0x02, 0x22, 0x00, 0x00, 0x08});
    node_log_refused(&heard, &idle, 0);
    const char *const line = log_pipe_read();
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, expected), line);
}

/* A command that has to wait says for what. */
static void test_a_refused_clear_fault_says_that_a_stop_is_under_way(void)
{
    const tumble_progress_t idle = {.state = TUMBLE_STATE_IDLE};
    heard = (node_log_t){.asked = TUMBLE_COMMAND_CLEAR_FAULT};
    log_pipe_open("text", NULL);
    node_log_refused(&heard, &idle, TUMBLE_RUNG_SDO);
    const char *line = log_pipe_read();
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, "is not seen at rest yet"), line);
    node_log_refused(&heard, &idle, TUMBLE_RUNG_UNCONFIRMED);
    line = log_pipe_read();
    TEST_ASSERT_NULL_MESSAGE(strstr(line, "is not seen at rest yet"), line);
}

static void test_a_refused_command_is_named_by_its_value_in_the_frame_or_in_a_segment(void)
{
    heard = (node_log_t){0};
    log_pipe_open("json", NULL);
    hear(0x601, (const uint8_t[8]){0x2F, 0x02, 0x20, 0x02, 5});
    expect_refused(5);
    hear(0x601, (const uint8_t[8]){0x21, 0x02, 0x20, 0x02, 1}); /* one byte, in a segment */
    hear(0x601, (const uint8_t[8]){0x0D, 9});
    expect_refused(9);
    hear(0x601, (const uint8_t[8]){0x21, 0x02, 0x20, 0x03, 1}); /* an argument */
    hear(0x601, (const uint8_t[8]){0x0D, 7});
    expect_refused(9);
}

/* The interface. */

static void test_an_interface_that_goes_and_comes_back(void)
{
    link_log_t told = {0};
    can_socket_t can = {.name = "can0", .is_down = true};
    log_pipe_open("text", NULL);
    link_log_update(&told, &can);
    TEST_ASSERT_EQUAL_STRING("", log_pipe_read());
    can.counters.downs = 1;
    link_log_update(&told, &can);
    link_log_update(&told, &can);
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: warning: the interface can0 is down\n", log_pipe_read());
    can.is_down = false;
    link_log_update(&told, &can);
    link_log_update(&told, &can);
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: notice: the interface can0 is up again\n", log_pipe_read());
}
