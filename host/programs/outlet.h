/* outlet.h - writing to a descriptor without ever waiting for whoever reads it, be it a terminal that is stopped, a pipe or a
 * socket that is full: byte by byte (nowait_t), and as a stream of lines, on standard output or on --progress-fd (outlet_t).
 *
 * Terminals and pipes are opened anew: their O_NONBLOCK belongs to all who have them, a shell above all, and others must
 * notice nothing. A file keeps nobody waiting, and a socket is asked with every write. SIGPIPE and SIGTTOU must be
 * ignored (events.h).
 *
 * What is written to the stream goes to the descriptor when it is flushed. What finds no room
 * there waits here, in its order, and goes with a later flush or with outlet_retry. A flush that finds no room here either
 * is left out whole and counted; so each flush should be of whole lines, of at most OUTLET_LINE_BYTES.
 */
#ifndef TUMBLE_PROGRAMS_OUTLET_H
#define TUMBLE_PROGRAMS_OUTLET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/types.h>

typedef struct {
    int fd;
    bool is_own;   /* opened anew */
    bool may_wait; /* a terminal or pipe that could not be opened anew */
} nowait_t;

/* Begin; the descriptor is the caller's and must stay open. One that is none fails with the first write. */
void nowait_open(nowait_t *to, int fd);

/* Closes what has been opened anew. */
void nowait_close(nowait_t *to);

/* Is there room for something, and no error: does anybody read it? */
bool nowait_is_writable(const nowait_t *to);

/* As write(): how many bytes it has taken, fewer than `size` perhaps; -1 and errno, EAGAIN where there is no room. */
ssize_t nowait_write(const nowait_t *to, const char *bytes, size_t size);

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
