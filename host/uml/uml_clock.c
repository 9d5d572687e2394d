/* uml_clock.c - preloaded into Debian's linux.uml, so that its clock stands still while the machine holds it up.
 *
 * What runs in there has times to keep, such as heartbeats. A machine that is busy, or whose host takes its processors
 * away, holds the whole kernel up, and every process in there would see the others silent. While it runs, that kernel
 * looks at its monotonic clock at every tick; so what passes between two looks beyond a tick, and beyond its sleep until
 * its timer, is taken for a time without a processor, and is no time in there. Its timers stay the machine's. They come
 * too early then; Linux looks at the clock, finds nothing due, and sets its timer anew.
 *
 * The kernel of user-mode Linux 6.1 calls these functions of the C library, in one thread: clock_gettime and
 * timer_settime, and sigsuspend while idle. A handler of a signal calls the first two as well, at any moment; so signals
 * are held back wherever it would find half of a look.
 */
#define _GNU_SOURCE

#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_S INT64_C(1000000000)
#define TICK_NS (NS_PER_S / 100) /* its CONFIG_HZ is 100 */

/* Times of the machine's clock. */
static int64_t seen_ns;   /* at the last look, or at the end of a sleep after it; 0: there was none */
static int64_t lost_ns;   /* held up, in all */
static int64_t alarm_ns;  /* at which its timer ends; 0: it is not set */
static int64_t period_ns; /* after which the timer ends again; 0: it does not */
static bool is_asleep;

static sigset_t hold_signals_back(void)
{
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    sigprocmask(SIG_SETMASK, &all, &before);
    return before;
}

static void let_signals_come(sigset_t before)
{
    sigprocmask(SIG_SETMASK, &before, NULL);
}

static int64_t to_ns(const struct timespec *time)
{
    return time->tv_sec * NS_PER_S + time->tv_nsec;
}

static int64_t machine_ns(void)
{
    struct timespec time = {0, 0};
    (void)syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &time);
    return to_ns(&time);
}

/* A sleep ends at the latest when the timer does: from there on it is held up. */
static void wake_up(int64_t now_ns)
{
    if (is_asleep) {
        const int64_t end_ns = (alarm_ns != 0 && alarm_ns < now_ns) ? alarm_ns : now_ns;
        is_asleep = false;
        seen_ns = (end_ns > seen_ns) ? end_ns : seen_ns;
        while (period_ns != 0 && alarm_ns <= now_ns) {
            alarm_ns += period_ns;
        }
    }
}

static int64_t look(void)
{
    const sigset_t before = hold_signals_back();
    const int64_t now_ns = machine_ns();
    wake_up(now_ns);
    if (seen_ns != 0 && now_ns - seen_ns > TICK_NS) {
        lost_ns += now_ns - seen_ns - TICK_NS;
    }
    seen_ns = now_ns;
    const int64_t time_ns = now_ns - lost_ns;
    let_signals_come(before);
    return time_ns;
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    if (clock != CLOCK_MONOTONIC) {
        return (int)syscall(SYS_clock_gettime, clock, time);
    }
    const int64_t now_ns = look();
    *time = (struct timespec){.tv_sec = now_ns / NS_PER_S, .tv_nsec = now_ns % NS_PER_S};
    return 0;
}

int timer_settime(timer_t timer, int flags, const struct itimerspec *value, struct itimerspec *before)
{
    static int (*set)(timer_t, int, const struct itimerspec *, struct itimerspec *);
    if (set == NULL) {
        *(void **)&set = dlsym(RTLD_NEXT, "timer_settime");
    }
    (void)look();
    const sigset_t held = hold_signals_back();
    const int64_t delay_ns = to_ns(&value->it_value);
    period_ns = to_ns(&value->it_interval);
    alarm_ns = (delay_ns != 0) ? machine_ns() + delay_ns : 0;
    const int result = set(timer, flags, value, before);
    let_signals_come(held);
    return result;
}

int sigsuspend(const sigset_t *mask)
{
    const sigset_t before = hold_signals_back();
    (void)look();
    is_asleep = true;
    const int result = (int)syscall(SYS_rt_sigsuspend, mask, (size_t)_NSIG / 8);
    const int reason = errno;
    wake_up(machine_ns());
    let_signals_come(before);
    errno = reason;
    return result;
}
