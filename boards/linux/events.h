/* events.h - what a program on the bus waits for: frames, a moment, and being told to end by a signal. */
#ifndef TUMBLE_LINUX_EVENTS_H
#define TUMBLE_LINUX_EVENTS_H

#include <stdbool.h>
#include <stdint.h>

/* From now on SIGINT, SIGTERM and `further` (0: no other) are taken by the descriptor returned alone, a signalfd that
 * does not block. SIGPIPE is ignored, and so is SIGTTOU: after `stty tostop` the first line of its log would stop a
 * program in the background, and with it its heartbeat. Negative: errno says why. */
int signals_open(int further);

typedef struct {
    int epoll;
    int timer;         /* of the monotonic clock */
    int signals;       /* SIGINT, SIGTERM, SIGUSR1 */
    uint64_t armed_us; /* for when the timer is set */
    int signal;        /* that has come, not yet taken */
} events_t;

/* From now on SIGINT, SIGTERM and SIGUSR1 are taken by events_signal alone, and SIGPIPE is ignored. False: errno says
 * why. */
bool events_open(events_t *events, int can_fd);

/* Wake for this descriptor as well, or no more. False: it is none that can be waited for. */
bool events_watch(const events_t *events, int fd);
void events_forget(const events_t *events, int fd);

/* Wait for a frame, a signal or the moment `until_us` of the monotonic clock, whichever comes first. */
void events_wait(events_t *events, uint64_t until_us);

/* The signal that has come, or 0. */
int events_signal(events_t *events);

void events_close(events_t *events);

#endif
