#define _GNU_SOURCE

#include "signals.h"

#include <signal.h>
#include <stddef.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>

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

bool signals_with_parent(void *options, const char *none)
{
    (void)options;
    (void)none;
    return prctl(PR_SET_PDEATHSIG, SIGTERM) == 0;
}
