/* uml_clock.c - preloaded into Debian's linux.uml, so that its clock stands still while the machine lets it wait.
 *
 * What runs in there has times to keep, such as heartbeats. A machine that is busy, or whose host takes its processors
 * away, holds the whole kernel up, and every process in there would see the others silent. So the monotonic clock that
 * it reads goes on with the processor time that it and its processes have had, and while it sleeps until its timer; what
 * it waited for a processor is no time. Its timers stay the machine's. They come too early then, by what it waited;
 * Linux looks at the clock, finds nothing due, and sets its timer anew.
 *
 * The kernel of user-mode Linux 6.1 calls these functions of the C library, in one thread: clock_gettime and
 * timer_settime; sigsuspend while idle; and waitpid while a process of its own, which it traces, runs. A handler of a
 * signal may run inside sigsuspend and waitpid, and reads the clock.
 */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_S INT64_C(1000000000)

static volatile int64_t slept_ns;  /* until its timers */
static volatile int64_t traced_ns; /* processor time of its processes */
static volatile int64_t alarm_ns;  /* the machine's time at which its timer ends; 0: it is not set */
static volatile int64_t period_ns; /* after which the timer ends again; 0: it does not */
static volatile int64_t asleep_since_ns;
static volatile bool is_asleep;
static volatile pid_t running; /* its process that runs; 0: none */
static volatile int64_t running_from_ns;

static int64_t to_ns(const struct timespec *time)
{
    return time->tv_sec * NS_PER_S + time->tv_nsec;
}

static int64_t read_ns(clockid_t clock)
{
    struct timespec time = {0, 0};
    return (syscall(SYS_clock_gettime, clock, &time) == 0) ? to_ns(&time) : -1;
}

/* A process has the clock that the kernel's headers call MAKE_PROCESS_CPUCLOCK(pid, CPUCLOCK_SCHED). */
static int64_t used_ns(pid_t pid)
{
    return read_ns((clockid_t)(~(unsigned int)pid << 3 | 2U));
}

/* The sleep has ended, at the latest when the timer did: what it was late is no time. */
static void wake_up(void)
{
    if (is_asleep) {
        const int64_t now_ns = read_ns(CLOCK_MONOTONIC);
        const int64_t end_ns = (alarm_ns != 0 && alarm_ns < now_ns) ? alarm_ns : now_ns;
        is_asleep = false;
        slept_ns += (end_ns > asleep_since_ns) ? end_ns - asleep_since_ns : 0;
        while (period_ns != 0 && alarm_ns <= now_ns) {
            alarm_ns += period_ns;
        }
    }
}

static int64_t running_ns(void)
{
    const int64_t now_ns = (running != 0) ? used_ns(running) : -1;
    return (now_ns > running_from_ns) ? now_ns - running_from_ns : 0;
}

/* It goes on by as much as was used, and by no more than the machine's own clock: where a host takes processors away, what
 * a process has used can leap, and go back, by what was taken. */
static int64_t monotonic_ns(void)
{
    static volatile int64_t time_ns;
    static int64_t before_ns;
    static int64_t used_before_ns;
    static volatile bool is_reading; /* and a handler asks in the midst of it: no later than what was read before */
    if (is_reading) {
        return time_ns;
    }
    is_reading = true;
    wake_up();
    const int64_t now_ns = read_ns(CLOCK_MONOTONIC);
    const int64_t used_now_ns = slept_ns + traced_ns + running_ns() + read_ns(CLOCK_PROCESS_CPUTIME_ID);
    const int64_t passed_ns = (before_ns != 0) ? now_ns - before_ns : 0;
    const int64_t spent_ns = used_now_ns - used_before_ns;
    const int64_t gone_ns = (spent_ns < passed_ns) ? spent_ns : passed_ns;
    time_ns += (gone_ns > 0) ? gone_ns : 0;
    before_ns = now_ns;
    used_before_ns = used_now_ns;
    is_reading = false;
    return time_ns;
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    if (clock != CLOCK_MONOTONIC) {
        return (int)syscall(SYS_clock_gettime, clock, time);
    }
    const int64_t now_ns = monotonic_ns();
    *time = (struct timespec){.tv_sec = now_ns / NS_PER_S, .tv_nsec = now_ns % NS_PER_S};
    return 0;
}

int timer_settime(timer_t timer, int flags, const struct itimerspec *value, struct itimerspec *before)
{
    static int (*set)(timer_t, int, const struct itimerspec *, struct itimerspec *);
    if (set == NULL) {
        *(void **)&set = dlsym(RTLD_NEXT, "timer_settime");
    }
    wake_up();
    const int64_t delay_ns = to_ns(&value->it_value);
    period_ns = to_ns(&value->it_interval);
    alarm_ns = (delay_ns != 0) ? read_ns(CLOCK_MONOTONIC) + delay_ns : 0;
    return set(timer, flags, value, before);
}

int sigsuspend(const sigset_t *mask)
{
    asleep_since_ns = read_ns(CLOCK_MONOTONIC);
    is_asleep = true;
    const int result = (int)syscall(SYS_rt_sigsuspend, mask, (size_t)_NSIG / 8);
    const int reason = errno;
    wake_up();
    errno = reason;
    return result;
}

pid_t waitpid(pid_t pid, int *status, int options)
{
    const pid_t outer = running;
    const int64_t outer_from_ns = running_from_ns;
    running_from_ns = used_ns(pid);
    running = (pid > 0) ? pid : 0;
    const pid_t result = (pid_t)syscall(SYS_wait4, pid, status, options, NULL);
    const int reason = errno;
    const int64_t ran_ns = running_ns();
    running = 0;
    traced_ns += ran_ns;
    running_from_ns = outer_from_ns;
    running = outer;
    errno = reason;
    return result;
}
