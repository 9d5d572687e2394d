/* The log: its forms and levels, what a line may hold, the journal, and how much goes at a time. */
#define _GNU_SOURCE

#include "event_log.h"
#include "log_pipe.h"
#include "suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define AT LOG_PIPE_TIME " tumble-node: "

static const around_t around_each = {NULL, log_pipe_close};

/* Forms. */

static void test_plain_tells_what_it_always_told_and_nothing_else(void)
{
    log_pipe_open(NULL, NULL);
    TEST_ASSERT_FALSE(event_log_is_on());
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "not told");
    event_log_always(EVENT_LOG_INFO, "ready", NULL, "node %d on %s", 1, "vcan0");
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
    static const char *const names[] = {"error", "warning", "notice", "info"};
    for (unsigned least = 0; least < 4U; least++) {
        log_pipe_open("text", names[least]);
        for (unsigned level = 0; level < 4U; level++) {
            event_log_tell((event_log_level_t)(EVENT_LOG_ERROR + level), "state", NULL, "x");
        }
        TEST_ASSERT_EQUAL_UINT(least + 1U, log_pipe_lines(log_pipe_read()));
        if (least < 3U) {
            log_pipe_close();
        }
    }
}

static void test_without_a_level_it_is_info(void)
{
    log_pipe_open("json", NULL);
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "x");
    TEST_ASSERT_EQUAL_UINT(1, log_pipe_lines(log_pipe_read()));
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
    TEST_ASSERT_FALSE(event_log_take_level(NULL, "debug"));
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

/* Bytes of a name from outside, and what a line has of them: RFC 3629's own cases of what is none. */
static void test_what_is_no_utf8_becomes_question_marks(void)
{
    static const struct {
        const char *given;
        const char *told;
    } rows[] = {
        {"can\xff", "can?"},
        {"\xe4\xf6", "??"},                                                     /* Latin-1 */
        {"a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80z", "a\u00e4\u20ac\U0001f600z"}, /* all of it is */
        {"\xc0\xaf \xe0\x9f\xbf \xf0\x8f\xbf\xbf", "?? ??? ????"},              /* longer than need be */
        {"\xed\xa0\x80 \xed\x9f\xbf", "??? \xed\x9f\xbf"}, /* half of a pair; the last before them */
        {"\xf4\x90\x80\x80 \xf4\x8f\xbf\xbf", "???? \xf4\x8f\xbf\xbf"},
        {"\x80 \xe2\x82", "? ??"}, /* no beginning; no end */
        {"\xe2\x82z", "??z"},
        {"\xc2\x9b;31m", "?;31m"}, /* a control sequence in one character */
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char wanted[200];
        log_pipe_open("json", NULL);
        event_log_tell(EVENT_LOG_INFO, "ready", EVENT_FIELDS(EVENT_TEXT("a", rows[i].given)), "%s", rows[i].given);
        (void)snprintf(wanted, sizeof wanted, ",\"a\":\"%s\",\"message\":\"%s\"}\n", rows[i].told, rows[i].told);
        const char *const line = log_pipe_read();
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(line, wanted), line);
        log_pipe_close();
    }
    log_pipe_open(NULL, NULL);
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
    TEST_ASSERT_EQUAL_UINT(2, log_pipe_lines(lines));
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

/* Too much at a time. */

/* Whatever only informs, there is room for what somebody has to know. */
static void test_a_reserve_for_warnings_and_notices_and_room_for_the_end(void)
{
    log_pipe_open("text", NULL);
    log_pipe_tell(1000);
    TEST_ASSERT_EQUAL_UINT(EVENT_LOG_BURST, log_pipe_lines(log_pipe_read()));
    event_log_tell(EVENT_LOG_WARNING, "refused", NULL, "one");
    event_log_tell(EVENT_LOG_NOTICE, "commit", NULL, "two");
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "not told");
    TEST_ASSERT_EQUAL_STRING(AT "warning: lines left out before this one: 800\n" AT "warning: one\n" AT "notice: two\n",
                             log_pipe_read());
    for (unsigned i = 2; i < 1000U; i++) {
        event_log_tell(EVENT_LOG_WARNING, "refused", NULL, "x");
    }
    TEST_ASSERT_EQUAL_UINT(EVENT_LOG_RESERVE - 2U + 1U, log_pipe_lines(log_pipe_read())); /* and what was lost */
    event_log_end(EVENT_LOG_NOTICE, NULL, "ends");
    TEST_ASSERT_EQUAL_STRING(AT "warning: lines left out before this one: 900\n" AT "notice: ends\n", log_pipe_read());
    log_pipe_pass_ms(1000); /* what is earned goes to the reserve first */
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "not told");
    TEST_ASSERT_EQUAL_STRING("", log_pipe_read());
    event_log_tell(EVENT_LOG_NOTICE, "commit", NULL, "told");
    TEST_ASSERT_EQUAL_UINT(2, log_pipe_lines(log_pipe_read()));
}

static void test_more_than_a_burst_is_left_out_but_errors_are_not(void)
{
    log_pipe_open("text", NULL);
    log_pipe_tell(EVENT_LOG_BURST + 7U);
    TEST_ASSERT_EQUAL_UINT(EVENT_LOG_BURST, log_pipe_lines(log_pipe_read()));
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "told");
    TEST_ASSERT_EQUAL_STRING(LOG_PIPE_TIME " tumble-node: warning: lines left out before this one: 7\n" LOG_PIPE_TIME
                                           " tumble-node: error: told\n",
                             log_pipe_read());
    log_pipe_pass_ms(1000);
    log_pipe_tell(EVENT_LOG_BURST);
    TEST_ASSERT_EQUAL_UINT(EVENT_LOG_PER_SECOND, log_pipe_lines(log_pipe_read()));
    log_pipe_pass_ms(100000);
    log_pipe_tell(1000);
    TEST_ASSERT_EQUAL_UINT(EVENT_LOG_BURST + 1U, log_pipe_lines(log_pipe_read())); /* and what was lost */
}
