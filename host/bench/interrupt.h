/* interrupt.h - Ctrl-C and its like: noted, and acted upon between two events. */
#ifndef TUMBLE_BENCH_INTERRUPT_H
#define TUMBLE_BENCH_INTERRUPT_H

#include <stdbool.h>

/* Note SIGINT, SIGTERM and SIGHUP from now on, instead of dying of them; system calls that wait return early. SIGPIPE
 * and SIGXFSZ are ignored: writing fails instead. */
void bench_interrupt_watch(void);

bool bench_interrupted(void);

#endif
