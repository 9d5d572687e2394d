/* What tumble-node tells of its own outputs. */
#include "log_pipe.h"
#include "node_log.h"
#include "suite.h"

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
