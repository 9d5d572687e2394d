#define _GNU_SOURCE

#include "log_pipe.h"

#include "event_log.h"
#include "unity.h"

#include <fcntl.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#define NOW_S 1795434901 /* LOG_PIPE_TIME */

static int ends[2];
static unsigned passed_ms;

int __wrap_clock_gettime(clockid_t clock, struct timespec *now);

int __wrap_clock_gettime(clockid_t clock, struct timespec *now)
{
    const bool is_utc = clock == CLOCK_REALTIME;
    now->tv_sec = (is_utc ? NOW_S : 1000) + (is_utc ? 0 : (time_t)(passed_ms / 1000U));
    now->tv_nsec = is_utc ? 123456789 : (long)(passed_ms % 1000U) * 1000000;
    return 0;
}

void log_pipe_open(const char *form, const char *level)
{
    TEST_ASSERT_EQUAL_INT(0, pipe2(ends, O_NONBLOCK));
    event_log_reset();
    TEST_ASSERT_TRUE(form == NULL || event_log_take_form(NULL, form));
    TEST_ASSERT_TRUE(level == NULL || event_log_take_level(NULL, level));
    event_log_start("tumble-node", ends[1]);
}

void log_pipe_close(void)
{
    (void)unsetenv("JOURNAL_STREAM");
    (void)close(ends[0]);
    (void)close(ends[1]);
    event_log_reset();
    passed_ms = 0;
}

int log_pipe_in(void)
{
    return ends[1];
}

int log_pipe_out(void)
{
    return ends[0];
}

const char *log_pipe_read(void)
{
    static char text[1 << 17];
    size_t used = 0;
    ssize_t got;
    while (used < sizeof text - 1U && (got = read(ends[0], &text[used], sizeof text - 1U - used)) > 0) {
        used += (size_t)got;
    }
    text[used] = '\0';
    return text;
}

void log_pipe_tell(unsigned times)
{
    for (unsigned i = 0; i < times; i++) {
        event_log_tell(EVENT_LOG_INFO, "state", NULL, "%u", i);
    }
}

unsigned log_pipe_lines(const char *text)
{
    unsigned lines = 0;
    for (const char *at = text; *at != '\0'; at++) {
        lines += (*at == '\n') ? 1U : 0U;
    }
    return lines;
}

void log_pipe_pass_ms(unsigned ms)
{
    passed_ms += ms;
}
