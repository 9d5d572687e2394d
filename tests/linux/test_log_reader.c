/* Nobody reads the log: a terminal that is stopped, a pipe or a socket that is full. Whoever tells of an event must not
 * wait for it; a case that waits is ended by SIGALRM. */
#define _GNU_SOURCE

#include "event_log.h"
#include "log_pipe.h"
#include "suite.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#define AT LOG_PIPE_TIME " tumble-node: "
#define PATIENCE_S 60 /* of a case, on a machine however busy */

/* The system, where a test wants it otherwise. */
static bool may_open = true;
static int filled_meanwhile = -1; /* a pipe into which somebody else writes as soon as the log was told of room in it */
static size_t taken_at_once = SIZE_MAX; /* by a socket */

static void fill(int fd)
{
    static const char filling[4096];
    const int flags = fcntl(fd, F_GETFL);
    TEST_ASSERT_EQUAL_INT(0, fcntl(fd, F_SETFL, flags | O_NONBLOCK));
    while (write(fd, filling, sizeof filling) > 0) {
        /* until it is full */
    }
    TEST_ASSERT_EQUAL_INT(0, fcntl(fd, F_SETFL, flags));
}

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags);

int __wrap_open(const char *path, int flags)
{
    errno = EACCES;
    return may_open ? __real_open(path, flags) : -1;
}

int __real_poll(struct pollfd *asked, nfds_t count, int timeout);
int __wrap_poll(struct pollfd *asked, nfds_t count, int timeout);

int __wrap_poll(struct pollfd *asked, nfds_t count, int timeout)
{
    const int ready = __real_poll(asked, count, timeout);
    if (filled_meanwhile >= 0) {
        fill(filled_meanwhile);
    }
    return ready;
}

ssize_t __real_send(int fd, const void *bytes, size_t size, int flags);
ssize_t __wrap_send(int fd, const void *bytes, size_t size, int flags);

ssize_t __wrap_send(int fd, const void *bytes, size_t size, int flags)
{
    return __real_send(fd, bytes, (size < taken_at_once) ? size : taken_at_once, flags);
}

/* A terminal: the log has one end, the test the other. */
static int master;
static int slave;
static char text[1 << 20]; /* that has come out of it so far */
static size_t text_size;

static void set_up(void)
{
    may_open = true;
    filled_meanwhile = -1;
    taken_at_once = SIZE_MAX;
    master = -1;
    slave = -1;
    text_size = 0;
    text[0] = '\0';
    (void)alarm(PATIENCE_S);
}

static void tear_down(void)
{
    (void)alarm(0);
    log_pipe_close();
    (void)close(master);
    (void)close(slave);
}

static void open_terminal(void)
{
    log_pipe_open("text", NULL);
    master = posix_openpt(O_RDWR | O_NOCTTY);
    TEST_ASSERT_TRUE(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
    slave = __real_open(ptsname(master), O_RDWR | O_NOCTTY);
    TEST_ASSERT_TRUE(slave >= 0);
    TEST_ASSERT_EQUAL_INT(0, fcntl(master, F_SETFL, O_NONBLOCK));
    event_log_start("tumble-node", slave);
}

/* Whose O_NONBLOCK others would notice. */
static void expect_flags_as_ever(int fd)
{
    TEST_ASSERT_EQUAL_INT(0, fcntl(fd, F_GETFL) & O_NONBLOCK);
}

/* Waits for more, a moment or (negative) for ever. False: nothing came. A terminal ends a line with \r\n. */
static bool read_more(int timeout_ms)
{
    struct pollfd asked = {.fd = master, .events = POLLIN};
    const bool is_ready = __real_poll(&asked, 1, timeout_ms) == 1;
    char bytes[4096];
    const ssize_t got = is_ready ? read(master, bytes, sizeof bytes) : 0;
    for (ssize_t i = 0; i < got && text_size < sizeof text - 1U; i++) {
        text[text_size] = bytes[i];
        text_size += (bytes[i] != '\r') ? 1U : 0U;
    }
    text[text_size] = '\0';
    return got > 0;
}

/* Terminals. */

#define LONG_LINE 500

/* Whole lines of errors, and how many the log itself says it left out. */
static void count_told(unsigned *whole, unsigned *lost)
{
    const size_t head = strlen(AT "error: ");
    *whole = 0;
    *lost = 0;
    for (const char *line = text; strchr(line, '\n') != NULL; line = strchr(line, '\n') + 1) {
        const size_t size = (size_t)(strchr(line, '\n') - line);
        unsigned number = 0;
        if (sscanf(line, AT "warning: lines left out before this one: %u\n", &number) == 1) {
            *lost += number;
        } else if (strncmp(line, AT "error: ", head) == 0 && (size == head + LONG_LINE || size == head + 4U)) {
            (*whole)++;
        }
    }
}

/* Every event is there as a whole line, or is counted among those that were left out. */
static void overflow_a_terminal(void)
{
    unsigned told = 0;
    unsigned whole = 0;
    unsigned lost = 0;
    open_terminal();
    for (; told < 300U; told++) {
        event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "%0*u", LONG_LINE, told);
    }
    expect_flags_as_ever(slave);
    while (lost == 0U || whole + lost != told) {
        if (!read_more(20)) {
            event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "more");
            told++;
        }
        count_told(&whole, &lost);
    }
    TEST_ASSERT_TRUE(whole > 0U && lost > 100U);
}

static void test_a_terminal_that_nobody_reads_holds_up_nothing(void)
{
    overflow_a_terminal();
}

static void test_nor_does_one_that_may_not_be_opened_anew(void)
{
    may_open = false;
    overflow_a_terminal();
}

/* As by Ctrl-S. */
static void stop_a_terminal(void)
{
    open_terminal();
    TEST_ASSERT_EQUAL_INT(0, tcflow(slave, TCOOFF));
    log_pipe_tell(3);
    TEST_ASSERT_EQUAL_INT(0, tcflow(slave, TCOON));
    event_log_tell(EVENT_LOG_NOTICE, "state", NULL, "here");
    while (strstr(text, "here\n") == NULL) {
        (void)read_more(-1);
    }
    TEST_ASSERT_EQUAL_STRING(AT "warning: lines left out before this one: 3\n" AT "notice: here\n", text);
    expect_flags_as_ever(slave);
}

static void test_a_terminal_that_is_stopped_holds_up_nothing(void)
{
    stop_a_terminal();
}

static void test_nor_does_one_that_is_stopped_and_may_not_be_opened_anew(void)
{
    may_open = false;
    stop_a_terminal();
}

/* Pipes. */

static int ends[2]; /* that wait, unlike those of log_pipe.h */

static void open_pipe(void)
{
    log_pipe_open("text", NULL);
    TEST_ASSERT_EQUAL_INT(0, pipe(ends));
    TEST_ASSERT_EQUAL_INT(0, fcntl(ends[0], F_SETFL, O_NONBLOCK));
    event_log_start("tumble-node", ends[1]);
}

static void expect_in_pipe(const char *lines)
{
    char got[1000] = "";
    const ssize_t size = read(ends[0], got, sizeof got - 1U);
    TEST_ASSERT_TRUE(size >= 0 || errno == EAGAIN);
    TEST_ASSERT_EQUAL_STRING(lines, got);
}

/* There was room, and then somebody else who has the same pipe took it. */
static void share_a_pipe(void)
{
    static char filling[1 << 17];
    open_pipe();
    filled_meanwhile = ends[1];
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "left out");
    filled_meanwhile = -1;
    expect_flags_as_ever(ends[1]);
    TEST_ASSERT_TRUE(read(ends[0], filling, sizeof filling) > 0);
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "here");
    expect_in_pipe(AT "warning: lines left out before this one: 1\n" AT "error: here\n");
    (void)close(ends[0]);
    (void)close(ends[1]);
}

static void test_a_pipe_that_somebody_else_fills_holds_up_nothing(void)
{
    share_a_pipe();
}

static void test_nor_does_one_without_a_description_of_its_own(void)
{
    may_open = false;
    share_a_pipe();
}

/* Whoever reads it waits for its end, and so for the last who could write. */
static void test_a_log_that_has_ended_keeps_no_pipe_open(void)
{
    char byte;
    open_pipe();
    event_log_start("tumble-node", ends[1]); /* anew */
    TEST_ASSERT_EQUAL_INT(0, close(ends[1]));
    event_log_tell(EVENT_LOG_ERROR, "fault", NULL, "here");
    expect_in_pipe(AT "error: here\n");
    event_log_reset();
    TEST_ASSERT_EQUAL_INT(0, read(ends[0], &byte, 1));
    (void)close(ends[0]);
}

/* As of "2>log 1>&2": opened anew it would be written over from its beginning. */
static void test_a_file_that_others_write_to_as_well(void)
{
    char path[] = "log_reader_XXXXXX";
    char got[200] = "";
    const int fd = mkstemp(path);
    TEST_ASSERT_TRUE(fd >= 0);
    (void)unlink(path);
    log_pipe_open("text", NULL);
    event_log_start("tumble-node", fd);
    TEST_ASSERT_EQUAL_INT(4, write(fd, "one\n", 4));
    event_log_tell(EVENT_LOG_NOTICE, "state", NULL, "two");
    TEST_ASSERT_EQUAL_INT(6, write(fd, "three\n", 6));
    TEST_ASSERT_TRUE(pread(fd, got, sizeof got - 1U, 0) > 0);
    TEST_ASSERT_EQUAL_STRING("one\n" AT "notice: two\nthree\n", got);
    (void)close(fd);
}

static void test_a_pipe_that_nobody_reads_holds_up_nothing(void)
{
    log_pipe_open("text", NULL);
    fill(log_pipe_in());
    log_pipe_tell(3);
    event_log_always(EVENT_LOG_ERROR, "fault", NULL, "lost too");
    (void)log_pipe_read();
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "here");
    TEST_ASSERT_EQUAL_STRING(AT "warning: lines left out before this one: 4\n" AT "info: here\n", log_pipe_read());
    event_log_tell(EVENT_LOG_INFO, "state", NULL, "here");
    TEST_ASSERT_EQUAL_UINT(1, log_pipe_lines(log_pipe_read()));
}

/* SIGPIPE would end this process. */
static void test_a_pipe_whose_reader_has_gone_ends_nothing(void)
{
    log_pipe_open("text", NULL);
    const int out = dup(log_pipe_out());
    TEST_ASSERT_EQUAL_INT(0, close(log_pipe_out()));
    log_pipe_tell(1);
    TEST_ASSERT_EQUAL_INT(0, close(out)); /* until here somebody might have read it */
    log_pipe_tell(2);
}

/* Sockets, such as the journal's. */

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
    TEST_ASSERT_NOT_NULL(strstr(got, "\n" AT "error: last\n"));
    (void)close(pair[0]);
    (void)close(pair[1]);
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
    TEST_ASSERT_EQUAL_STRING(
        LOG_PIPE_TIME " tumbl\n" AT "warning: lines left out before this one: 1\n" AT "info: whole\n", got);
    (void)close(pair[0]);
    (void)close(pair[1]);
}
