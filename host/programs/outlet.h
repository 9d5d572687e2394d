/* outlet.h - lines for a reader outside, on standard output or on --progress-fd, that hold up nobody who writes them.
 *
 * What is written to the stream goes to the descriptor when it is flushed, without waiting (nowait.h). What finds no room
 * there waits here, in its order, and goes with a later flush or with outlet_retry. A flush that finds no room here either
 * is left out whole and counted; so each flush should be of whole lines, of at most OUTLET_LINE_BYTES.
 */
#ifndef TUMBLE_PROGRAMS_OUTLET_H
#define TUMBLE_PROGRAMS_OUTLET_H

#include "nowait.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define OUTLET_BYTES 65536U      /* that may wait */
#define OUTLET_LINE_BYTES 32768U /* of one flush */
#define OUTLET_LAST_MS 1000U     /* for what waits in the end, once the program was told to end */

typedef struct {
    nowait_t to;
    FILE *stream;   /* null: not open */
    size_t size;    /* bytes that wait */
    uint32_t lost;  /* flushes that were left out */
    bool is_broken; /* it takes nothing any more: no reader, or no room on a disk */
    char waiting[OUTLET_BYTES];
    char line[OUTLET_LINE_BYTES]; /* the stream's own */
} outlet_t;

/* False: the descriptor is not open for writing. It must stay open. */
bool outlet_open(outlet_t *outlet, int fd);

/* What waits goes, as far as there is room. Costs nothing if nothing waits. */
void outlet_retry(outlet_t *outlet);

/* Wait until all has gone, or until SIGTERM or SIGINT comes and OUTLET_LAST_MS are over (`is_told`: it has come), and
 * close. False: something has not gone. One that is not open has nothing to be done. */
bool outlet_end(outlet_t *outlet, bool is_told);

#endif
