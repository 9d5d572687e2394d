#define _GNU_SOURCE

#include "events.h"

#include <signal.h>
#include <stddef.h>
#include <sys/epoll.h>
#include <sys/signalfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#define US_PER_S 1000000U
#define MAX_READY 4

int signals_open(int further)
{
    const struct sigaction ignore = {.sa_handler = SIG_IGN};
    sigset_t set;
    (void)sigaction(SIGPIPE, &ignore, NULL);
    (void)sigaction(SIGTTOU, &ignore, NULL);
    (void)sigemptyset(&set);
    (void)sigaddset(&set, SIGINT);
    (void)sigaddset(&set, SIGTERM);
    if (further != 0) {
        (void)sigaddset(&set, further);
    }
    (void)sigprocmask(SIG_BLOCK, &set, NULL);
    return signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC);
}

bool events_watch(const events_t *events, int fd)
{
    struct epoll_event event = {.events = EPOLLIN, .data = {.fd = fd}};
    return fd >= 0 && epoll_ctl(events->epoll, EPOLL_CTL_ADD, fd, &event) == 0;
}

void events_forget(const events_t *events, int fd)
{
    (void)epoll_ctl(events->epoll, EPOLL_CTL_DEL, fd, NULL);
}

bool events_open(events_t *events, int can_fd)
{
    *events = (events_t){0};
    events->epoll = epoll_create1(EPOLL_CLOEXEC);
    events->timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    events->signals = signals_open(SIGUSR1);
    return events->epoll >= 0 && events_watch(events, events->timer) && events_watch(events, events->signals) &&
           events_watch(events, can_fd);
}

static void arm(events_t *events, uint64_t at_us)
{
    const struct itimerspec moment = {
        .it_value = {(time_t)(at_us / US_PER_S), (long)(at_us % US_PER_S) * 1000L},
    };
    if (at_us != events->armed_us) {
        events->armed_us = at_us;
        (void)timerfd_settime(events->timer, TFD_TIMER_ABSTIME, &moment, NULL);
    }
}

static void take(events_t *events, int fd)
{
    struct signalfd_siginfo info;
    uint64_t expirations;
    if (fd == events->timer) {
        events->armed_us = 0;
        (void)!read(fd, &expirations, sizeof expirations);
    } else if (fd == events->signals && read(fd, &info, sizeof info) == (ssize_t)sizeof info) {
        events->signal = (int)info.ssi_signo;
    }
}

void events_wait(events_t *events, uint64_t until_us)
{
    struct epoll_event ready[MAX_READY];
    arm(events, (until_us == 0U) ? 1U : until_us); /* 0 would disarm the timer */
    const int count = epoll_wait(events->epoll, ready, MAX_READY, -1);
    for (int i = 0; i < count; i++) {
        take(events, ready[i].data.fd);
    }
}

int events_signal(events_t *events)
{
    const int signal = events->signal;
    events->signal = 0;
    return signal;
}

void events_close(events_t *events)
{
    (void)close(events->epoll);
    (void)close(events->timer);
    (void)close(events->signals);
}
