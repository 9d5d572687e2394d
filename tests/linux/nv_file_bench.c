#define _GNU_SOURCE

#include "nv_file_bench.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

char folder[40]; /* empty: there is none */
char path[100];
nv_file_t file;
static bool is_open;

int killed_after = -1;
int full_after = -1;
uint32_t most_at_once;
int interruptions;
int sync_error;
long sync_ms;
pthread_mutex_t medium = PTHREAD_MUTEX_INITIALIZER;

ssize_t __real_pwrite(int fd, const void *bytes, size_t size, off_t offset);
ssize_t __wrap_pwrite(int fd, const void *bytes, size_t size, off_t offset);
int __real_fdatasync(int fd);
int __wrap_fdatasync(int fd);

ssize_t __wrap_pwrite(int fd, const void *bytes, size_t size, off_t offset)
{
    if (killed_after >= 0) {
        (void)!__real_pwrite(fd, bytes, (size_t)killed_after, offset);
        (void)raise(SIGKILL);
    }
    if (interruptions > 0) {
        interruptions--;
        errno = EINTR;
        return -1;
    }
    if (full_after == 0) {
        errno = ENOSPC;
        return -1;
    }
    if (full_after > 0 && size > (size_t)full_after) {
        size = (size_t)full_after;
        full_after = 0;
    }
    return __real_pwrite(fd, bytes, (most_at_once != 0U && size > most_at_once) ? most_at_once : size, offset);
}

int __wrap_fdatasync(int fd)
{
    const struct timespec pause = {sync_ms / 1000, (sync_ms % 1000) * 1000000L};
    if (sync_ms > 0) {
        (void)nanosleep(&pause, NULL);
    }
    (void)pthread_mutex_lock(&medium);
    (void)pthread_mutex_unlock(&medium);
    if (sync_error != 0) {
        errno = sync_error;
        return -1;
    }
    return __real_fdatasync(fd);
}

static void remove_file(void)
{
    (void)snprintf(path, sizeof path, "%s/memory", folder); /* wherever a test has put it */
    (void)unlink(path);
}

void set_up(void)
{
    killed_after = -1;
    full_after = -1;
    most_at_once = 0;
    interruptions = 0;
    sync_error = 0;
    sync_ms = 0;
    if (folder[0] == '\0') {
        (void)snprintf(folder, sizeof folder, "/tmp/tumble-nv-XXXXXX");
        TEST_ASSERT_NOT_NULL(mkdtemp(folder));
    }
    remove_file();
}

void tear_down(void)
{
    (void)pthread_mutex_trylock(&medium); /* a test that failed may hold it */
    (void)pthread_mutex_unlock(&medium);
    if (is_open) {
        is_open = false;
        nv_file_close(&file);
    }
    remove_file();
    (void)rmdir(folder);
    folder[0] = '\0';
}

void open_it(void)
{
    TEST_ASSERT_NULL(nv_file_open(&file, path));
    is_open = true;
}

void close_it(void)
{
    is_open = false;
    nv_file_close(&file);
}

void pause_us(void *context, uint32_t us)
{
    const struct timespec pause = {us / 1000000U, (long)(us % 1000000U) * 1000L};
    (void)context;
    (void)nanosleep(&pause, NULL);
}

tumble_status_t erase(uint32_t offset)
{
    tumble_status_t status;
    while ((status = file.nv.erase(&file, offset)) == TUMBLE_E_PORT_BUSY) {
        pause_us(NULL, 100);
    }
    return status;
}

tumble_status_t program(uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    tumble_status_t status;
    while ((status = file.nv.program(&file, offset, bytes, size)) == TUMBLE_E_PORT_BUSY) {
        pause_us(NULL, 100);
    }
    return status;
}

void write_file(const void *bytes, size_t size)
{
    FILE *const out = fopen(path, "wb");
    TEST_ASSERT_NOT_NULL(out);
    TEST_ASSERT_EQUAL_size_t(size, fwrite(bytes, 1, size, out));
    TEST_ASSERT_EQUAL_INT(0, fclose(out));
}

size_t read_file(uint8_t bytes[NV_FILE_BYTES + 1U])
{
    FILE *const in = fopen(path, "rb");
    TEST_ASSERT_NOT_NULL(in);
    const size_t size = fread(bytes, 1, NV_FILE_BYTES + 1U, in);
    (void)fclose(in);
    return size;
}
