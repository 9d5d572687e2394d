/* Lines for a reader who does not read, reads late, or has gone. Whoever writes them must not wait for it; a case that
 * waits is ended by SIGALRM. */
#define _GNU_SOURCE

#include "events.h"
#include "outlet.h"
#include "suite.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define PATIENCE_S 60 /* of a case, on a machine however busy */
#define LINE 1000U

static outlet_t outlet;
static int ends[2];
static int signals;
static char text[1 << 20]; /* that has come out of the pipe so far */
static size_t text_size;

static void set_up(void)
{
    (void)alarm(PATIENCE_S);
    signals = signals_open(0); /* SIGPIPE is ignored, SIGTERM waits */
    TEST_ASSERT_EQUAL_INT(0, pipe(ends));
    TEST_ASSERT_TRUE(outlet_open(&outlet, ends[1]));
    text_size = 0;
    text[0] = '\0';
}

static void tear_down(void)
{
    struct timespec at_once = {0};
    sigset_t set;
    (void)sigemptyset(&set);
    (void)sigaddset(&set, SIGTERM);
    (void)sigtimedwait(&set, NULL, &at_once); /* that nobody has taken */
    (void)outlet_end(&outlet, true);
    (void)close(ends[0]);
    (void)close(ends[1]);
    (void)close(signals);
    (void)alarm(0);
}

/* Lines "000...N\n" from `first` on, each flushed. */
static void put_lines(unsigned first, unsigned count)
{
    for (unsigned i = first; i < first + count; i++) {
        (void)fprintf(outlet.stream, "%0*u\n", (int)LINE - 1, i);
        (void)fflush(outlet.stream);
    }
}

static void take_all(void)
{
    ssize_t got = 1;
    TEST_ASSERT_EQUAL_INT(0, fcntl(ends[0], F_SETFL, O_NONBLOCK));
    while (got > 0) {
        got = read(ends[0], &text[text_size], sizeof text - 1U - text_size);
        text_size += (got > 0) ? (size_t)got : 0U;
        outlet_retry(&outlet);
    }
    text[text_size] = '\0';
}

/* Whole lines, the first `count` of all in their order. */
static void expect_lines(unsigned count)
{
    TEST_ASSERT_EQUAL_size_t((size_t)count * LINE, text_size);
    for (unsigned i = 0; i < count; i++) {
        char line[LINE + 1U];
        (void)snprintf(line, sizeof line, "%0*u\n", (int)LINE - 1, i);
        TEST_ASSERT_EQUAL_MEMORY(line, &text[i * LINE], LINE);
    }
}

static void test_what_is_read_at_once_goes_at_once(void)
{
    put_lines(0, 3);
    take_all();
    expect_lines(3);
    TEST_ASSERT_TRUE(outlet_end(&outlet, false));
}

/* A document is written piece by piece, and goes whole. */
static void test_nothing_goes_before_it_is_flushed(void)
{
    (void)fputs("{\"a\":", outlet.stream);
    take_all();
    TEST_ASSERT_EQUAL_STRING("", text);
    (void)fputs("1}\n", outlet.stream);
    (void)fflush(outlet.stream);
    take_all();
    TEST_ASSERT_EQUAL_STRING("{\"a\":1}\n", text);
}

/* The pipe is full and so is the outlet: lines are left out whole, and those before them come in their order. */
static void test_who_reads_late_gets_whole_lines_in_their_order(void)
{
    put_lines(0, 500);
    const unsigned most = 500U - outlet.lost; /* and so many in the pipe as it pleases the kernel */
    TEST_ASSERT_TRUE(most > OUTLET_BYTES / LINE && most < 200U);
    take_all();
    expect_lines(most);
    put_lines(most, 2); /* there is room again */
    take_all();
    expect_lines(most + 2U);
    TEST_ASSERT_FALSE(outlet_end(&outlet, false)); /* some are missing */
}

/* The flags of a pipe are those of all who have it. */
static void test_others_on_the_same_pipe_notice_nothing(void)
{
    put_lines(0, 200);
    TEST_ASSERT_EQUAL_INT(0, fcntl(ends[1], F_GETFL) & O_NONBLOCK);
}

/* The end. */

/* Another process that begins to read, and leaves with how many kB have come. */
static pid_t fork_reader(void)
{
    const pid_t child = fork();
    if (child == 0) {
        size_t size = 0;
        ssize_t got = 1;
        (void)close(ends[1]);
        nowait_close(&outlet.to);
        while (got > 0) {
            got = read(ends[0], text, sizeof text);
            size += (got > 0) ? (size_t)got : 0U;
        }
        _exit((int)(size / LINE));
    }
    TEST_ASSERT_TRUE(child > 0);
    return child;
}

static void test_the_end_waits_for_a_reader(void)
{
    int status = 0;
    put_lines(0, 120); /* more than the pipe takes */
    TEST_ASSERT_TRUE(outlet.size > 0U);
    const pid_t child = fork_reader();
    TEST_ASSERT_TRUE(outlet_end(&outlet, false));
    (void)close(ends[1]);
    TEST_ASSERT_EQUAL_INT(child, waitpid(child, &status, 0));
    TEST_ASSERT_TRUE(WIFEXITED(status));
    TEST_ASSERT_EQUAL_INT(120, WEXITSTATUS(status));
}

static void test_a_signal_ends_the_wait(void)
{
    put_lines(0, 120);
    TEST_ASSERT_EQUAL_INT(0, raise(SIGTERM));
    TEST_ASSERT_FALSE(outlet_end(&outlet, false));
}

static void test_who_was_told_to_end_does_not_wait_long(void)
{
    put_lines(0, 120);
    TEST_ASSERT_FALSE(outlet_end(&outlet, true));
}

static void test_a_reader_who_has_gone_is_not_waited_for(void)
{
    put_lines(0, 120);
    (void)close(ends[0]);
    TEST_ASSERT_FALSE(outlet_end(&outlet, false));
}

static void test_a_full_disk_is_told(void)
{
    static outlet_t full;
    const int fd = open("/dev/full", O_WRONLY);
    TEST_ASSERT_TRUE(outlet_open(&full, fd));
    (void)fputs("{}\n", full.stream);
    TEST_ASSERT_FALSE(outlet_end(&full, false));
    (void)close(fd);
}

static void test_what_is_no_descriptor_to_write_to_is_refused(void)
{
    static outlet_t none;
    TEST_ASSERT_FALSE(outlet_open(&none, ends[0]));
    TEST_ASSERT_FALSE(outlet_open(&none, 1000));
    TEST_ASSERT_TRUE(outlet_end(&none, false)); /* nothing was to be written */
}

/* As of ">>file": written to at its end. */
static void test_a_file_is_written_as_ever(void)
{
    static outlet_t file;
    char path[] = "outlet_XXXXXX";
    char got[20] = "";
    const int fd = mkstemp(path);
    TEST_ASSERT_TRUE(fd >= 0);
    (void)unlink(path);
    TEST_ASSERT_EQUAL_INT(4, write(fd, "one\n", 4));
    TEST_ASSERT_TRUE(outlet_open(&file, fd));
    (void)fputs("two\n", file.stream);
    TEST_ASSERT_TRUE(outlet_end(&file, false));
    TEST_ASSERT_EQUAL_INT(6, write(fd, "three\n", 6));
    TEST_ASSERT_TRUE(pread(fd, got, sizeof got - 1U, 0) > 0);
    TEST_ASSERT_EQUAL_STRING("one\ntwo\nthree\n", got);
    (void)close(fd);
}
