/* The log: its forms and levels, what a line may hold, the journal, and that nobody who does not read holds it up. */
#define _GNU_SOURCE

#include "event_log.h"
#include "log_pipe.h"
#include "suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

static const around_t around_each = {NULL, log_pipe_close};

static unsigned count_lines(const char *text)
{
    unsigned lines = 0;
    for (const char *at = text; *at != '\0'; at++) {
        lines += (*at == '\n') ? 1U : 0U;
    }
    return lines;
}

static void tell_times(unsigned times)
{
    for (unsigned i = 0; i < times; i++) {
        event_log_tell(EVENT_LOG_INFO, "state", NULL, "%u", i);
    }
}

/* Forms. */

static void test_plain_tells_what_it_always_told_and_nothing_else(void)
{
    log_pipe_open(NULL, NULL);
    TEST_ASSERT_FALSE(event_log_is_on());
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "not told");
    event_log_always(EVENT_LOG_DEBUG, "ready", NULL, "node %d on %s", 1, "vcan0");
    TEST_ASSERT_EQUAL_STRING("tumble-node: node 1 on vcan0\n", log_pipe_read());
}

static void test_a_line_of_text(void)
{
    log_pipe_open("text", NULL);
    TEST_ASSERT_TRUE(event_log_is_on());
    event_log_tell(EVENT_LOG_WARNING, "refused", EVENT_FIELDS(EVENT_WHOLE("number", 1U)), "refused %u", 12U);
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: warning: refused 12\n", log_pipe_read());
}

static void test_a_line_of_json(void)
{
    log_pipe_open("json", NULL);
    event_log_always(
        EVENT_LOG_ERROR, "fault",
        EVENT_FIELDS(EVENT_TEXT("reason", "STALL"), EVENT_WHOLE("code", UINT64_MAX), EVENT_WHOLE("no", 0U)),
        "fault: %s", "it");
    TEST_ASSERT_EQUAL_STRING("{\"schema\":\"tumble.log/1\",\"time\":\"" LOG_PIPE_TIME
                             "\",\"program\":\"tumble-node\",\"level\":\"error\",\"event\":\"fault\","
                             "\"reason\":\"STALL\",\"code\":18446744073709551615,\"no\":0,\"message\":\"fault: it\"}\n",
                             log_pipe_read());
}

static void test_levels(void)
{
    static const char *const names[] = {"error", "warning", "notice", "info", "debug"};
    for (unsigned least = 0; least < 5U; least++) {
        log_pipe_open("text", names[least]);
        for (unsigned level = 0; level < 5U; level++) {
            event_log_tell((event_log_level_t)(EVENT_LOG_ERROR + level), "state", NULL, "x");
        }
        TEST_ASSERT_EQUAL_UINT(least + 1U, count_lines(log_pipe_read()));
        if (least < 4U) {
            log_pipe_close();
        }
    }
}

static void test_without_a_level_it_is_info(void)
{
    log_pipe_open("json", NULL);
    event_log_tell(EVENT_LOG_DEBUG, "state", NULL, "x");
    TEST_ASSERT_EQUAL_STRING("", log_pipe_read());
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "x");
    TEST_ASSERT_EQUAL_UINT(1, count_lines(log_pipe_read()));
}

static void test_a_level_alone_means_text(void)
{
    log_pipe_open(NULL, "notice");
    event_log_tell(EVENT_LOG_NOTICE, "state", NULL, "x");
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: notice: x\n", log_pipe_read());
}

static void test_a_level_before_json_leaves_it_json(void)
{
    log_pipe_open("json", "error");
    event_log_tell(EVENT_LOG_ERROR, "state", NULL, "x");
    TEST_ASSERT_EQUAL_CHAR('{', log_pipe_read()[0]);
}

static void test_words_that_are_none_are_refused(void)
{
    log_pipe_open(NULL, NULL);
    TEST_ASSERT_FALSE(event_log_take_form(NULL, "xml"));
    TEST_ASSERT_FALSE(event_log_take_form(NULL, ""));
    TEST_ASSERT_FALSE(event_log_take_level(NULL, "info "));
    TEST_ASSERT_FALSE(event_log_is_on());
}

static void test_nothing_before_it_has_begun(void)
{
    log_pipe_open("text", NULL);
    event_log_reset();
    event_log_always(EVENT_LOG_ERROR, "fault", NULL, "x");
    TEST_ASSERT_EQUAL_STRING("", log_pipe_read());
}

/* What a line may hold. */

static void test_a_line_stays_one_line(void)
{
    log_pipe_open("text", NULL);
    event_log_tell(EVENT_LOG_INFO, "ready", NULL, "memory %s", "a\nb\x1b[2J\x7f\tc");
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: info: memory a?b?[2J??c\n", log_pipe_read());
}

static void test_json_stays_json(void)
{
    log_pipe_open("json", NULL);
    event_log_tell(EVENT_LOG_INFO, "ready", EVENT_FIELDS(EVENT_TEXT("memory", "\"\\\n")), "\"%s", "\\");
    const char *const line = log_pipe_read();
    TEST_ASSERT_NOT_NULL(strstr(line, ",\"memory\":\"\\\"\\\\?\",\"message\":\"\\\"\\\\\"}\n"));
}

/* Cut off behind a whole character: 599 bytes have room for 299 of two bytes, and none of half. */
static void test_a_long_text_is_cut_off_behind_a_character(void)
{
    char text[2U * EVENT_LOG_TEXT_BYTES + 1U];
    for (unsigned i = 0; i < EVENT_LOG_TEXT_BYTES; i++) {
        memcpy(&text[2U * i], "\xC3\xA4", 3);
    }
    log_pipe_open("text", NULL);
    event_log_tell(EVENT_LOG_INFO, "ready", NULL, "%s", text);
    const char *const line = strstr(log_pipe_read(), ": info: ") + strlen(": info: ");
    TEST_ASSERT_EQUAL_size_t(2U * 299U + 1U, strlen(line));
    TEST_ASSERT_EQUAL_MEMORY(text, line, 2U * 299U);
}

static void test_a_line_that_is_too_long_is_left_out_and_counted(void)
{
    char text[EVENT_LOG_TEXT_BYTES];
    memset(text, '"', sizeof text - 1U);
    text[sizeof text - 1U] = '\0';
    log_pipe_open("json", NULL);
    event_log_tell(EVENT_LOG_INFO, "ready",
                   EVENT_FIELDS(EVENT_TEXT("a", text), EVENT_TEXT("b", text), EVENT_TEXT("c", text)), "%s", text);
    TEST_ASSERT_EQUAL_STRING("", log_pipe_read());
    event_log_tell(EVENT_LOG_INFO, "ready", NULL, "x");
    const char *const lines = log_pipe_read();
    TEST_ASSERT_EQUAL_UINT(2, count_lines(lines));
    TEST_ASSERT_NOT_NULL(strstr(lines, "\"event\":\"lost\",\"lines\":1,"));
}

/* The journal. */

static void begin_with_stream(const char *form, const char *stream)
{
    log_pipe_open(form, NULL);
    TEST_ASSERT_EQUAL_INT(0, setenv("JOURNAL_STREAM", stream, 1));
    event_log_start("tumble-node", log_pipe_in());
}

static const char *own_stream(void)
{
    static char stream[60];
    struct stat status;
    log_pipe_open(NULL, NULL);
    TEST_ASSERT_EQUAL_INT(0, fstat(log_pipe_in(), &status));
    (void)snprintf(stream, sizeof stream, "%ju:%ju", (uintmax_t)status.st_dev, (uintmax_t)status.st_ino);
    return stream;
}

static void test_the_journal_gets_the_level_and_no_time(void)
{
    TEST_ASSERT_EQUAL_INT(0, setenv("JOURNAL_STREAM", own_stream(), 1));
    event_log_start("tumble-node", log_pipe_in());
    event_log_always(EVENT_LOG_NOTICE, "ready", NULL, "x");
    TEST_ASSERT_EQUAL_STRING("<5>tumble-node: x\n", log_pipe_read());
    TEST_ASSERT_TRUE(event_log_take_form(NULL, "text"));
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "y");
    TEST_ASSERT_EQUAL_STRING("<3>y\n", log_pipe_read());
    TEST_ASSERT_TRUE(event_log_take_form(NULL, "json"));
    event_log_tell(EVENT_LOG_INFO, "fault", NULL, "y");
    TEST_ASSERT_EQUAL_STRING_LEN("<6>{\"schema\":", log_pipe_read(), 12);
}

static void test_another_stream_is_not_the_journal(void)
{
    static const char *const streams[] = {"1:2", "", "x", "1", ":", "-1:-1", "1:2:3"};
    for (size_t i = 0; i < sizeof streams / sizeof streams[0]; i++) {
        begin_with_stream(NULL, streams[i]);
        event_log_always(EVENT_LOG_NOTICE, "ready", NULL, "x");
        TEST_ASSERT_EQUAL_STRING("tumble-node: x\n", log_pipe_read());
        log_pipe_close();
    }
    char longer[70];
    (void)snprintf(longer, sizeof longer, "%s0x", own_stream());
    TEST_ASSERT_EQUAL_INT(0, setenv("JOURNAL_STREAM", longer, 1));
    event_log_start("tumble-node", log_pipe_in());
    event_log_always(EVENT_LOG_NOTICE, "ready", NULL, "x");
    TEST_ASSERT_EQUAL_STRING("tumble-node: x\n", log_pipe_read());
}

/* Nobody reads; too much at a time. */

static void test_a_pipe_that_nobody_reads_holds_up_nothing(void)
{
    char filling[4096] = {0};
    log_pipe_open("text", NULL);
    while (write(log_pipe_in(), filling, sizeof filling) > 0) {
        /* until it is full */
    }
    tell_times(3);
    event_log_always(EVENT_LOG_ERROR, "fault", NULL, "lost too");
    (void)log_pipe_read();
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "here");
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: warning: lines left out before this one: 4\n" LOG_PIPE_TIME
                                           " tumble-node: info: here\n",
                             log_pipe_read());
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "here");
    TEST_ASSERT_EQUAL_UINT(1, count_lines(log_pipe_read()));
}

/* SIGPIPE would end this process. */
static void test_a_pipe_whose_reader_has_gone_ends_nothing(void)
{
    log_pipe_open("text", NULL);
    const int out = dup(log_pipe_out());
    TEST_ASSERT_EQUAL_INT(0, close(log_pipe_out()));
    tell_times(1);
    TEST_ASSERT_EQUAL_INT(0, close(out)); /* until here somebody might have read it */
    tell_times(2);
}

static void test_a_socket_that_is_full_holds_up_nothing(void)
{
    static char got[1 << 20];
    int pair[2];
    const int least = 1;
    log_pipe_open("text", NULL);
    TEST_ASSERT_EQUAL_INT(0, socketpair(AF_UNIX, SOCK_STREAM, 0, pair));
    TEST_ASSERT_EQUAL_INT(0, setsockopt(pair[1], SOL_SOCKET, SO_SNDBUF, &least, sizeof least));
    event_log_start("tumble-node", pair[1]);
    for (unsigned i = 0; i < 2000U; i++) {
        event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "%0500u", i);
    }
    ssize_t size = recv(pair[0], got, sizeof got, MSG_DONTWAIT);
    TEST_ASSERT_TRUE(size > 0 && size < 2000 * 500);
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "last");
    size = recv(pair[0], got, sizeof got - 1U, MSG_DONTWAIT);
    TEST_ASSERT_TRUE(size > 0);
    got[size] = '\0';
    TEST_ASSERT_NOT_NULL(strstr(got, ": lines left out before this one: "));
    TEST_ASSERT_NOT_NULL(strstr(got, "\n" LOG_PIPE_TIME " tumble-node: error: last\n"));
    (void)close(pair[0]);
    (void)close(pair[1]);
}

/* How much a socket takes at a time. */
static size_t taken_at_once = SIZE_MAX;

ssize_t __real_send(int fd, const void *bytes, size_t size, int flags);
ssize_t __wrap_send(int fd, const void *bytes, size_t size, int flags);

ssize_t __wrap_send(int fd, const void *bytes, size_t size, int flags)
{
    return __real_send(fd, bytes, (size < taken_at_once) ? size : taken_at_once, flags);
}

/* A line that went in part is lost, and what comes next begins on a line of its own. */
static void test_a_line_that_goes_in_part_spoils_no_other(void)
{
    char got[300] = "";
    int pair[2];
    log_pipe_open("text", NULL);
    TEST_ASSERT_EQUAL_INT(0, socketpair(AF_UNIX, SOCK_STREAM, 0, pair));
    event_log_start("tumble-node", pair[1]);
    taken_at_once = 30;
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "in part");
    taken_at_once = SIZE_MAX;
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "whole");
    TEST_ASSERT_TRUE(recv(pair[0], got, sizeof got - 1U, MSG_DONTWAIT) > 0);
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumbl\n" LOG_PIPE_TIME
                                           " tumble-node: warning: lines left out before this one: 1\n" LOG_PIPE_TIME
                                           " tumble-node: info: whole\n",
                             got);
    (void)close(pair[0]);
    (void)close(pair[1]);
}

static void test_more_than_a_burst_is_left_out_but_errors_are_not(void)
{
    log_pipe_open("text", NULL);
    tell_times(EVENT_LOG_BURST + 7U);
    TEST_ASSERT_EQUAL_UINT(EVENT_LOG_BURST, count_lines(log_pipe_read()));
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "told");
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: warning: lines left out before this one: 7\n" LOG_PIPE_TIME
                                           " tumble-node: error: told\n",
                             log_pipe_read());
    log_pipe_pass_ms(1000);
    tell_times(EVENT_LOG_BURST);
    TEST_ASSERT_EQUAL_UINT(EVENT_LOG_PER_SECOND, count_lines(log_pipe_read()));
    log_pipe_pass_ms(100000);
    tell_times(1000);
    TEST_ASSERT_EQUAL_UINT(EVENT_LOG_BURST + 1U, count_lines(log_pipe_read())); /* and what was lost */
}
