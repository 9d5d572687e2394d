/* nowait.h - write to a descriptor without ever waiting for whoever reads it, be it a terminal that is stopped, a pipe or
 * a socket that is full.
 *
 * Terminals and pipes are opened anew: their O_NONBLOCK belongs to all who have them, a shell above all, and others must
 * notice nothing. A file keeps nobody waiting, and a socket is asked with every write. SIGPIPE and SIGTTOU must be
 * ignored (events.h).
 */
#ifndef TUMBLE_PROGRAMS_NOWAIT_H
#define TUMBLE_PROGRAMS_NOWAIT_H

#include <stdbool.h>
#include <stddef.h>
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

#endif
