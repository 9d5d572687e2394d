/* signals.h - being told to end, as a descriptor to wait for. */
#ifndef TUMBLE_LINUX_SIGNALS_H
#define TUMBLE_LINUX_SIGNALS_H

/* From now on SIGINT, SIGTERM and `further` (0: no other) are taken by the descriptor returned alone, a signalfd that
 * does not block, and SIGPIPE is ignored. Negative: errno says why. */
int signals_open(int further);

#endif
