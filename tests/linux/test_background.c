/* A program in the background of a terminal that is to stop such programs when they write (stty tostop). */
#define _GNU_SOURCE

#include "event_log.h"
#include "events.h"
#include "suite.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#define PATIENCE_S 60
#define ENDED 10
#define STOPPED 11

static void tell_from_background(bool as_programs_do, int terminal)
{
    (void)setpgid(0, 0);
    (void)signal(SIGTTOU, SIG_DFL); /* whatever the cases before have left */
    if (as_programs_do) {
        (void)signals_open(0);
    }
    event_log_start("tumble-node", terminal);
    event_log_always(EVENT_LOG_NOTICE, "ready", NULL, "here");
    _exit(0);
}

/* The shell's place: the terminal is its own. */
static int lead(const char *path, bool as_programs_do)
{
    struct termios settings;
    int status = 0;
    (void)alarm(PATIENCE_S);
    (void)setsid();
    const int terminal = open(path, O_RDWR);
    if (terminal < 0 || tcgetattr(terminal, &settings) != 0) {
        return 1;
    }
    settings.c_lflag |= TOSTOP;
    (void)tcsetattr(terminal, TCSANOW, &settings);
    const pid_t child = fork();
    if (child == 0) {
        tell_from_background(as_programs_do, terminal);
    }
    (void)waitpid(child, &status, WUNTRACED);
    if (WIFSTOPPED(status)) {
        (void)kill(child, SIGKILL);
        return STOPPED;
    }
    return WIFEXITED(status) ? ENDED : 1;
}

/* What became of a program that has told of an event, and what the terminal has. */
static int tell(bool as_programs_do, char *text, size_t size)
{
    int status = 0;
    const int master = posix_openpt(O_RDWR | O_NOCTTY);
    TEST_ASSERT_TRUE(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
    const char *const path = ptsname(master);
    const pid_t leader = fork();
    if (leader == 0) {
        _exit(lead(path, as_programs_do));
    }
    const int slave = open(path, O_RDWR | O_NOCTTY); /* keeps what was written */
    TEST_ASSERT_EQUAL_INT(leader, waitpid(leader, &status, 0));
    TEST_ASSERT_EQUAL_INT(0, fcntl(master, F_SETFL, O_NONBLOCK));
    const ssize_t got = read(master, text, size - 1U);
    text[(got > 0) ? got : 0] = '\0';
    (void)close(slave);
    (void)close(master);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void test_its_log_does_not_stop_it(void)
{
    char text[100];
    TEST_ASSERT_EQUAL_INT(ENDED, tell(true, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("tumble-node: here\r\n", text);
}

/* Else the case above would show nothing. */
static void test_any_other_program_is_stopped(void)
{
    char text[100];
    TEST_ASSERT_EQUAL_INT(STOPPED, tell(false, text, sizeof text));
    TEST_ASSERT_EQUAL_STRING("", text);
}
