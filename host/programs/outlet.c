#define _GNU_SOURCE

#include "outlet.h"

#include "events.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#define PATH_BYTES 40
#define TURN_MS 20

/* Bytes. */

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

/* A stream of lines. */

void outlet_retry(outlet_t *outlet)
{
    while (outlet->size > 0U && !outlet->is_broken) {
        const ssize_t written = nowait_write(&outlet->to, outlet->waiting, outlet->size);
        if (written <= 0) {
            outlet->is_broken = written < 0 && errno != EAGAIN && errno != EINTR;
            return;
        }
        outlet->size -= (size_t)written;
        memmove(outlet->waiting, &outlet->waiting[written], outlet->size);
    }
}

/* Of the stream, for each flush. */
static ssize_t take(void *context, const char *bytes, size_t size)
{
    outlet_t *const outlet = context;
    outlet_retry(outlet);
    if (size > OUTLET_BYTES - outlet->size) {
        outlet->lost += (outlet->lost < UINT32_MAX) ? 1U : 0U;
        return (ssize_t)size;
    }
    memcpy(&outlet->waiting[outlet->size], bytes, size);
    outlet->size += size;
    outlet_retry(outlet);
    return (ssize_t)size;
}

bool outlet_open(outlet_t *outlet, int fd)
{
    const int flags = fcntl(fd, F_GETFL);
    outlet->stream = NULL;
    if (flags < 0 || (flags & O_ACCMODE) == O_RDONLY) {
        return false;
    }
    outlet->size = 0;
    outlet->lost = 0;
    outlet->is_broken = false;
    outlet->stream = fopencookie(outlet, "w", (cookie_io_functions_t){.write = take});
    if (outlet->stream == NULL) {
        return false;
    }
    (void)setvbuf(outlet->stream, outlet->line, _IOFBF, sizeof outlet->line);
    nowait_open(&outlet->to, fd);
    return true;
}

/* Within a turn. */
static bool is_told_to_end(int signals)
{
    struct pollfd asked = {.fd = signals, .events = POLLIN};
    struct signalfd_siginfo info;
    return poll(&asked, 1, TURN_MS) == 1 && read(signals, &info, sizeof info) == (ssize_t)sizeof info;
}

static void wait_for_reader(outlet_t *outlet, bool is_told)
{
    const int signals = signals_open(0);
    unsigned turns_left = OUTLET_LAST_MS / TURN_MS;
    while (outlet->size > 0U && !outlet->is_broken && turns_left > 0U) {
        is_told = is_told_to_end(signals) || is_told;
        turns_left -= is_told ? 1U : 0U;
        outlet_retry(outlet);
    }
    (void)close(signals);
}

bool outlet_end(outlet_t *outlet, bool is_told)
{
    if (outlet->stream == NULL) {
        return true;
    }
    (void)fclose(outlet->stream);
    outlet->stream = NULL;
    wait_for_reader(outlet, is_told);
    nowait_close(&outlet->to);
    return outlet->size == 0U && outlet->lost == 0U && !outlet->is_broken;
}
