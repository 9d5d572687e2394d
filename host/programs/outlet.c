#define _GNU_SOURCE

#include "outlet.h"

#include "events.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/signalfd.h>
#include <unistd.h>

#define TURN_MS 20

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
