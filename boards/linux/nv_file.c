#define _GNU_SOURCE /* flock */

#include "nv_file.h"

#include "nv/nv_rules.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define PATIENCE_NS 2000000L /* that a call may take: most media have ended by then */
#define NS_PER_S 1000000000L

/* Bytes of the file. False: errno says why. */

static bool read_all(int fd, uint8_t *bytes, uint32_t size, uint32_t offset)
{
    uint32_t done = 0;
    while (done < size) {
        const ssize_t got = pread(fd, bytes + done, size - done, (off_t)(offset + done));
        if (got == 0) {
            errno = EIO; /* somebody has cut it off */
            return false;
        }
        if (got < 0 && errno != EINTR) {
            return false;
        }
        done += (got > 0) ? (uint32_t)got : 0U;
    }
    return true;
}

static bool write_all(int fd, const uint8_t *bytes, uint32_t size, uint32_t offset)
{
    uint32_t done = 0;
    while (done < size) {
        const ssize_t put = pwrite(fd, bytes + done, size - done, (off_t)(offset + done));
        if (put < 0 && errno != EINTR) {
            return false;
        }
        done += (put > 0) ? (uint32_t)put : 0U;
    }
    return fdatasync(fd) == 0;
}

/* The thread that writes. */

static void *serve(void *context)
{
    nv_file_t *const file = context;
    (void)pthread_mutex_lock(&file->mutex);
    while (file->state != NV_FILE_CLOSING) {
        if (file->state != NV_FILE_RUNNING) {
            (void)pthread_cond_wait(&file->changed, &file->mutex);
            continue;
        }
        (void)pthread_mutex_unlock(&file->mutex); /* while it runs nobody else touches the operation */
        const bool written = write_all(file->fd, file->bytes, file->size, file->offset);
        (void)pthread_mutex_lock(&file->mutex);
        file->result = written ? TUMBLE_OK : TUMBLE_E_NV;
        file->state = NV_FILE_ENDED;
        (void)pthread_cond_broadcast(&file->changed);
    }
    (void)pthread_mutex_unlock(&file->mutex);
    return NULL;
}

/* Signals are for the program's own loop. */
static bool start_thread(nv_file_t *file)
{
    sigset_t all;
    sigset_t before;
    pthread_condattr_t monotonic;
    (void)pthread_condattr_init(&monotonic);
    (void)pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    (void)pthread_mutex_init(&file->mutex, NULL);
    (void)pthread_cond_init(&file->changed, &monotonic);
    (void)pthread_condattr_destroy(&monotonic);
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    errno = pthread_create(&file->thread, NULL, serve, file);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return errno == 0;
}

/* What the firmware calls. */

static void wait_a_moment(nv_file_t *file)
{
    struct timespec until;
    (void)clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += PATIENCE_NS;
    until.tv_sec += until.tv_nsec / NS_PER_S;
    until.tv_nsec %= NS_PER_S;
    while (file->state == NV_FILE_RUNNING && pthread_cond_timedwait(&file->changed, &file->mutex, &until) == 0) {
        /* woken, maybe for nothing */
    }
}

/* The operation in `offset` and `size` has been begun: how far is it? */
static tumble_status_t look(nv_file_t *file)
{
    wait_a_moment(file);
    if (file->state == NV_FILE_RUNNING) {
        return TUMBLE_E_PORT_BUSY;
    }
    file->state = NV_FILE_IDLE;
    return file->result;
}

/* Is it the call that is under way, made again? */
static bool is_under_way(const nv_file_t *file, const uint8_t *bytes, uint32_t offset, uint32_t size)
{
    return file->state != NV_FILE_IDLE && file->offset == offset && file->size == size &&
           memcmp(file->bytes, bytes, size) == 0;
}

static bool may_program(const nv_file_t *file, uint32_t offset, uint32_t size)
{
    uint8_t there[NV_FILE_SECTOR];
    return read_all(file->fd, there, size, offset) && nv_is_blank(there, size);
}

/* What was given up while it was under way has an end, but nobody who asks for it. */
static tumble_status_t operate(nv_file_t *file, uint32_t offset, const uint8_t *bytes, uint32_t size, bool blank_first)
{
    if (is_under_way(file, bytes, offset, size)) {
        return look(file);
    }
    if (file->state == NV_FILE_RUNNING) {
        return TUMBLE_E_PORT_BUSY;
    }
    file->state = NV_FILE_IDLE;
    if (blank_first && !may_program(file, offset, size)) {
        return TUMBLE_E_NV;
    }
    file->offset = offset;
    file->size = size;
    (void)memcpy(file->bytes, bytes, size);
    file->state = NV_FILE_RUNNING;
    (void)pthread_cond_broadcast(&file->changed);
    return look(file);
}

static tumble_status_t erase(void *context, uint32_t offset)
{
    nv_file_t *const file = context;
    uint8_t bytes[NV_FILE_SECTOR];
    if (!nv_is_sector(&file->nv, offset)) {
        return TUMBLE_E_NV;
    }
    (void)memset(bytes, NV_ERASED, sizeof bytes);
    (void)pthread_mutex_lock(&file->mutex);
    const tumble_status_t status = operate(file, offset, bytes, NV_FILE_SECTOR, false);
    (void)pthread_mutex_unlock(&file->mutex);
    return status;
}

static tumble_status_t program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    nv_file_t *const file = context;
    if (!nv_are_granules(&file->nv, offset, size)) {
        return TUMBLE_E_NV;
    }
    (void)pthread_mutex_lock(&file->mutex);
    const tumble_status_t status = operate(file, offset, bytes, size, true);
    (void)pthread_mutex_unlock(&file->mutex);
    return status;
}

static tumble_status_t read_bytes(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    nv_file_t *const file = context;
    if (!nv_are_there(&file->nv, offset, size)) {
        return TUMBLE_E_NV;
    }
    (void)pthread_mutex_lock(&file->mutex);
    const bool running = file->state == NV_FILE_RUNNING;
    (void)pthread_mutex_unlock(&file->mutex);
    if (running) {
        return TUMBLE_E_PORT_BUSY;
    }
    return read_all(file->fd, bytes, size, offset) ? TUMBLE_OK : TUMBLE_E_NV;
}

/* Opening. */

static bool is_erased(int fd, uint32_t size)
{
    uint8_t bytes[NV_FILE_BYTES];
    return read_all(fd, bytes, size, 0) && nv_is_blank(bytes, size);
}

static bool complete(int fd, uint32_t size)
{
    uint8_t bytes[NV_FILE_BYTES];
    (void)memset(bytes, NV_ERASED, sizeof bytes);
    return write_all(fd, bytes, NV_FILE_BYTES - size, size) && fsync(fd) == 0;
}

/* Null, or what is wrong with the file. */
static const char *get_ready(int fd)
{
    struct stat about;
    if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
        return (errno == EWOULDBLOCK) ? "another process has it in use" : strerror(errno);
    }
    if (fstat(fd, &about) != 0) {
        return strerror(errno);
    }
    if (!S_ISREG(about.st_mode)) {
        return "is not a file";
    }
    if (about.st_size == (off_t)NV_FILE_BYTES) {
        return NULL;
    }
    if (about.st_size > (off_t)NV_FILE_BYTES || !is_erased(fd, (uint32_t)about.st_size)) {
        return "is not a memory of 65536 bytes";
    }
    return complete(fd, (uint32_t)about.st_size) ? NULL : strerror(errno);
}

_Static_assert(NV_FILE_BYTES == 65536U, "as the sentence above has it");

const char *nv_file_open(nv_file_t *file, const char *path)
{
    *file = (nv_file_t){.nv = {.context = file,
                               .size_bytes = NV_FILE_BYTES,
                               .sector_bytes = NV_FILE_SECTOR,
                               .granule_bytes = NV_FILE_GRANULE,
                               .erase = erase,
                               .program = program,
                               .read = read_bytes}};
    file->fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0644);
    if (file->fd < 0) {
        return strerror(errno);
    }
    const char *wrong = get_ready(file->fd);
    if (wrong == NULL && !start_thread(file)) {
        wrong = strerror(errno);
    }
    if (wrong != NULL) {
        (void)close(file->fd);
    }
    return wrong;
}

void nv_file_close(nv_file_t *file)
{
    (void)pthread_mutex_lock(&file->mutex);
    while (file->state == NV_FILE_RUNNING) {
        (void)pthread_cond_wait(&file->changed, &file->mutex);
    }
    file->state = NV_FILE_CLOSING;
    (void)pthread_cond_broadcast(&file->changed);
    (void)pthread_mutex_unlock(&file->mutex);
    (void)pthread_join(file->thread, NULL);
    (void)pthread_cond_destroy(&file->changed);
    (void)pthread_mutex_destroy(&file->mutex);
    (void)close(file->fd);
}
