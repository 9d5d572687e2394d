#define _POSIX_C_SOURCE 200809L

#include "nowait.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#define PATH_BYTES 40

void nowait_open(nowait_t *to, int fd)
{
    char path[PATH_BYTES];
    struct stat status;
    *to = (nowait_t){.fd = fd};
    to->may_wait = fstat(fd, &status) == 0 && (S_ISFIFO(status.st_mode) || S_ISCHR(status.st_mode));
    if (!to->may_wait) {
        return;
    }
    (void)snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    const int own = open(path, O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (own >= 0) {
        *to = (nowait_t){.fd = own, .is_own = true};
    }
}

void nowait_close(nowait_t *to)
{
    if (to->is_own) {
        (void)close(to->fd);
    }
    to->is_own = false;
}

bool nowait_is_writable(const nowait_t *to)
{
    struct pollfd asked = {.fd = to->fd, .events = POLLOUT};
    return poll(&asked, 1, 0) == 1 && asked.revents == POLLOUT;
}

/* Of another's terminal, which this user may not open, say: for this one write nobody waits there. */
static ssize_t write_shared(int fd, const char *bytes, size_t size)
{
    const int flags = fcntl(fd, F_GETFL);
    if (flags < 0 || fcntl(fd, F_SETFL, flags | O_NONBLOCK) != 0) {
        return -1;
    }
    const ssize_t written = write(fd, bytes, size);
    const int error = errno;
    (void)fcntl(fd, F_SETFL, flags);
    errno = error;
    return written;
}

ssize_t nowait_write(const nowait_t *to, const char *bytes, size_t size)
{
    if (to->may_wait) {
        return write_shared(to->fd, bytes, size);
    }
    const ssize_t sent = send(to->fd, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    return (sent < 0 && errno == ENOTSOCK) ? write(to->fd, bytes, size) : sent;
}
