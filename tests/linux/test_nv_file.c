/* Non-volatile memory in a file: conformance, media that fail, and everything that a file can be. */
#define _GNU_SOURCE

#include "conformance_print.h"
#include "nv_file_bench.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* Conformance. */

static uint32_t verdicts[3];

static void count(void *context, const char *check, conformance_verdict_t verdict, const char *why)
{
    conformance_print(context, check, verdict, why);
    verdicts[verdict]++;
}

static const tumble_nv_t *reopen(void *context)
{
    (void)context;
    close_it();
    open_it();
    return &file.nv;
}

static void test_it_conforms(void)
{
    const conformance_bench_t bench = {
        .a = &(tumble_port_t){.nv = &file.nv}, .pass = pause_us, .erase_us = 50000, .reopen = reopen, .report = count};
    memset(verdicts, 0, sizeof verdicts);
    open_it();
    TEST_ASSERT_EQUAL_UINT32(0, conformance_run_nv(&bench));
    TEST_ASSERT_EQUAL_UINT32(10, verdicts[CONFORMANCE_PASSED] + verdicts[CONFORMANCE_SKIPPED]);
    TEST_ASSERT_TRUE(verdicts[CONFORMANCE_SKIPPED] <= 1U); /* on a fast disk it is never busy */
}

/* An erase on a disk that has not answered yet: nobody waits for it, or this would not end. */
static void test_a_slow_medium_is_busy_and_holds_nobody_up(void)
{
    uint8_t byte;
    open_it();
    (void)pthread_mutex_lock(&medium);
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_BUSY, file.nv.erase(&file, 0));
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_BUSY, file.nv.read(&file, 0, &byte, 1));
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_BUSY, file.nv.erase(&file, NV_FILE_SECTOR));
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_BUSY, file.nv.erase(&file, 0));
    (void)pthread_mutex_unlock(&medium);
    TEST_ASSERT_EQUAL(TUMBLE_OK, erase(0));
    TEST_ASSERT_EQUAL(TUMBLE_OK, file.nv.read(&file, 0, &byte, 1));
}

/* An operation that was begun is brought to its end when the file is closed. */
static void test_closing_waits_for_what_was_begun(void)
{
    static const uint8_t BYTES[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    static uint8_t all[NV_FILE_BYTES + 1U];
    open_it();
    sync_ms = 30;
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_BUSY, file.nv.program(&file, 4096, BYTES, sizeof BYTES));
    close_it();
    TEST_ASSERT_EQUAL_size_t(NV_FILE_BYTES, read_file(all));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(BYTES, &all[4096], sizeof BYTES);
}

/* A medium that fails. */

static void test_no_room_is_told(void)
{
    static const uint8_t BYTES[16] = {1};
    open_it();
    full_after = 3;
    TEST_ASSERT_EQUAL(TUMBLE_E_NV, program(0, BYTES, sizeof BYTES));
    TEST_ASSERT_EQUAL(TUMBLE_E_NV, program(64, BYTES, sizeof BYTES));
    full_after = -1;
    TEST_ASSERT_EQUAL(TUMBLE_E_NV, program(0, BYTES, sizeof BYTES)); /* some of it is there */
    TEST_ASSERT_EQUAL(TUMBLE_OK, program(64, BYTES, sizeof BYTES));
    TEST_ASSERT_EQUAL(TUMBLE_OK, erase(0));
    TEST_ASSERT_EQUAL(TUMBLE_OK, program(0, BYTES, sizeof BYTES));
}

static void test_what_does_not_reach_the_medium_is_told(void)
{
    open_it();
    sync_error = EIO;
    TEST_ASSERT_EQUAL(TUMBLE_E_NV, erase(0));
    sync_error = 0;
    TEST_ASSERT_EQUAL(TUMBLE_OK, erase(0));
}

static void test_short_and_interrupted_writes_go_on(void)
{
    static uint8_t all[NV_FILE_BYTES + 1U];
    uint8_t bytes[NV_FILE_SECTOR];
    for (uint32_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)(i * 3U);
    }
    open_it();
    most_at_once = 100;
    interruptions = 3;
    TEST_ASSERT_EQUAL(TUMBLE_OK, program(NV_FILE_SECTOR, bytes, sizeof bytes));
    (void)read_file(all);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, &all[NV_FILE_SECTOR], sizeof bytes);
}

static void test_a_file_that_somebody_cuts_off(void)
{
    uint8_t byte;
    static const uint8_t BYTES[8] = {1};
    open_it();
    TEST_ASSERT_EQUAL_INT(0, truncate(path, 100));
    TEST_ASSERT_EQUAL(TUMBLE_E_NV, file.nv.read(&file, 4096, &byte, 1));
    TEST_ASSERT_EQUAL(TUMBLE_E_NV, program(8192, BYTES, sizeof BYTES));
    TEST_ASSERT_EQUAL(TUMBLE_OK, file.nv.read(&file, 0, &byte, 1));
}

/* What is no memory. */

static void expect_refused(const char *what)
{
    const char *const wrong = nv_file_open(&file, path);
    TEST_ASSERT_EQUAL_STRING(what, wrong);
}

static void test_files_of_another_size_are_refused_and_left_alone(void)
{
    static uint8_t bytes[NV_FILE_BYTES + 1U];
    static uint8_t after[NV_FILE_BYTES + 1U];
    static const size_t SIZES[] = {1, 8, 4096, NV_FILE_BYTES - 1U, NV_FILE_BYTES + 1U};
    for (size_t k = 0; k < sizeof SIZES / sizeof SIZES[0]; k++) {
        memset(bytes, 0xFF, sizeof bytes);
        bytes[SIZES[k] - 1U] = 0xFE;
        write_file(bytes, SIZES[k]);
        expect_refused("is not a memory of 65536 bytes");
        TEST_ASSERT_EQUAL_size_t(SIZES[k], read_file(after));
        TEST_ASSERT_EQUAL_MEMORY(bytes, after, SIZES[k]);
    }
}

static void test_two_processes_do_not_share_it(void)
{
    open_it();
    const int other = open(path, O_RDWR);
    TEST_ASSERT_TRUE(other >= 0 && flock(other, LOCK_EX | LOCK_NB) != 0);
    (void)close(other);
    nv_file_t second;
    TEST_ASSERT_EQUAL_STRING("another process has it in use", nv_file_open(&second, path));
    close_it();
    TEST_ASSERT_NULL(nv_file_open(&second, path));
    nv_file_close(&second);
}

static void test_what_is_not_a_file_is_refused(void)
{
    (void)snprintf(path, sizeof path, "%s", folder);
    expect_refused("Is a directory");
    (void)snprintf(path, sizeof path, "/dev/null");
    expect_refused("is not a file");
    (void)snprintf(path, sizeof path, "%s/none/memory", folder);
    expect_refused("No such file or directory");
    (void)snprintf(path, sizeof path, "%s/fifo", folder);
    TEST_ASSERT_EQUAL_INT(0, mkfifo(path, 0600));
    expect_refused("is not a file");
    (void)unlink(path);
}

static void test_a_file_that_cannot_be_made_for_want_of_room(void)
{
    full_after = 1000;
    expect_refused("No space left on device");
    full_after = -1;
    open_it(); /* what was made of it is completed */
}

/* Signals go to the program, not to the thread that writes. */
static void test_signals_are_not_taken_by_the_thread(void)
{
    sigset_t only;
    sigset_t pending;
    (void)sigemptyset(&only);
    (void)sigaddset(&only, SIGUSR1);
    (void)sigprocmask(SIG_BLOCK, &only, NULL);
    open_it();
    TEST_ASSERT_EQUAL_INT(0, kill(getpid(), SIGUSR1));
    TEST_ASSERT_EQUAL(TUMBLE_OK, erase(0));
    (void)sigpending(&pending);
    TEST_ASSERT_TRUE(sigismember(&pending, SIGUSR1));
    (void)signal(SIGUSR1, SIG_IGN);
    (void)sigprocmask(SIG_UNBLOCK, &only, NULL);
}

static const around_t around_each = {set_up, tear_down};
