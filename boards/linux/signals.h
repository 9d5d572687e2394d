/* signals.h - being told to end, as a descriptor to wait for. */
#ifndef TUMBLE_LINUX_SIGNALS_H
#define TUMBLE_LINUX_SIGNALS_H

#include <stdbool.h>

/* From now on SIGINT, SIGTERM and `further` (0: no other) are taken by the descriptor returned alone, a signalfd that
 * does not block. SIGPIPE is ignored, and so is SIGTTOU: after `stty tostop` the first line of its log would stop a
 * program in the background, and with it its heartbeat. Negative: errno says why. */
int signals_open(int further);

/* An option's `take` (arguments.h): SIGTERM comes when the process that started this one has ended. */
bool signals_with_parent(void *options, const char *none);

#endif
