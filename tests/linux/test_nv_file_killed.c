/* Non-volatile memory in a file, and a process that is killed while it writes. */
#define _GNU_SOURCE

#include "nv_file_bench.h"

#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* A process that is killed after so many bytes of one operation. */
static void die(bool erasing, uint32_t offset, const uint8_t *bytes, uint32_t size, int after)
{
    int how;
    const pid_t child = fork();
    TEST_ASSERT_TRUE(child >= 0);
    if (child == 0) {
        if (nv_file_open(&file, path) != NULL) {
            _exit(1);
        }
        killed_after = after;
        (void)(erasing ? erase(offset) : program(offset, bytes, size));
        _exit(2);
    }
    TEST_ASSERT_EQUAL_INT(child, waitpid(child, &how, 0));
    TEST_ASSERT_TRUE(WIFSIGNALED(how) && WTERMSIG(how) == SIGKILL);
}

/* All but these bytes are as they were. */
static void expect_outside(const uint8_t *before, uint32_t offset, uint32_t size)
{
    static uint8_t now[NV_FILE_BYTES + 1U];
    TEST_ASSERT_EQUAL_size_t(NV_FILE_BYTES, read_file(now));
    TEST_ASSERT_EQUAL_MEMORY(before, now, offset);
    TEST_ASSERT_EQUAL_MEMORY(before + offset + size, now + offset + size, NV_FILE_BYTES - offset - size);
}

static void test_killed_while_programming_after_every_byte(void)
{
    enum { AT = 2 * NV_FILE_SECTOR + 64, SIZE = 64 };
    static uint8_t before[NV_FILE_BYTES + 1U];
    uint8_t bytes[SIZE];
    uint8_t there[SIZE];
    for (uint32_t i = 0; i < SIZE; i++) {
        bytes[i] = (uint8_t)(i + 1U);
    }
    for (int after = 0; after <= SIZE; after++) {
        set_up();
        open_it();
        TEST_ASSERT_EQUAL(TUMBLE_OK, program(AT - 8, bytes, 8));
        TEST_ASSERT_EQUAL(TUMBLE_OK, program(AT + SIZE, bytes, 8));
        close_it();
        (void)read_file(before);
        die(false, AT, bytes, SIZE, after);
        expect_outside(before, AT, SIZE);
        open_it(); /* the lock has gone with the process */
        TEST_ASSERT_EQUAL(TUMBLE_OK, file.nv.read(&file, AT, there, SIZE));
        for (int i = 0; i < SIZE; i++) {
            TEST_ASSERT_EQUAL_HEX8((i < after) ? bytes[i] : 0xFF, there[i]);
        }
        const tumble_status_t again = program(AT, bytes, SIZE);
        TEST_ASSERT_EQUAL((after == 0) ? TUMBLE_OK : TUMBLE_E_NV, again);
        TEST_ASSERT_EQUAL(TUMBLE_OK, erase(2 * NV_FILE_SECTOR));
        TEST_ASSERT_EQUAL(TUMBLE_OK, program(AT, bytes, SIZE));
        close_it();
    }
}

static void test_killed_while_erasing(void)
{
    static uint8_t before[NV_FILE_BYTES + 1U];
    static const int AFTER[] = {0, 1, 7, 8, 9, 511, 512, 2048, 4095, 4096};
    for (size_t k = 0; k < sizeof AFTER / sizeof AFTER[0]; k++) {
        set_up();
        memset(before, 0x5A, sizeof before);
        write_file(before, NV_FILE_BYTES);
        die(true, NV_FILE_SECTOR, NULL, 0, AFTER[k]);
        expect_outside(before, NV_FILE_SECTOR, NV_FILE_SECTOR);
        open_it();
        TEST_ASSERT_EQUAL(TUMBLE_OK, erase(NV_FILE_SECTOR));
        TEST_ASSERT_EQUAL(TUMBLE_OK, program(NV_FILE_SECTOR, before, 8));
        close_it();
    }
}

static void test_killed_while_the_file_is_made(void)
{
    static uint8_t all[NV_FILE_BYTES + 1U];
    static const int AFTER[] = {0, 1, 4096, 65535, 65536};
    for (size_t k = 0; k < sizeof AFTER / sizeof AFTER[0]; k++) {
        set_up();
        const pid_t child = fork();
        if (child == 0) {
            killed_after = AFTER[k];
            (void)nv_file_open(&file, path);
            _exit(1);
        }
        TEST_ASSERT_EQUAL_INT(child, waitpid(child, NULL, 0));
        TEST_ASSERT_EQUAL_size_t((size_t)AFTER[k], read_file(all));
        open_it();
        TEST_ASSERT_EQUAL_size_t(NV_FILE_BYTES, read_file(all));
        TEST_ASSERT_EACH_EQUAL_HEX8(0xFF, all, NV_FILE_BYTES);
        close_it();
    }
}

static const around_t around_each = {set_up, tear_down};
