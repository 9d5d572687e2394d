#define _POSIX_C_SOURCE 200809L

#include "bench/interrupt.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t interrupted;

static void note(int signal_number)
{
    (void)signal_number;
    interrupted = 1;
}

void bench_interrupt_watch(void)
{
    struct sigaction action = {.sa_handler = note}; /* no SA_RESTART */
    struct sigaction given;
    (void)sigemptyset(&action.sa_mask);
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    if (sigaction(SIGHUP, NULL, &given) == 0 && given.sa_handler != SIG_IGN) { /* as nohup wants it */
        (void)sigaction(SIGHUP, &action, NULL);
    }
    action.sa_handler = SIG_IGN;
    (void)sigaction(SIGPIPE, &action, NULL);
    (void)sigaction(SIGXFSZ, &action, NULL);
}

bool bench_interrupted(void)
{
    return interrupted != 0;
}
