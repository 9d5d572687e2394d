/* Exchanges over Modbus TCP with a slave in a thread: what arrives, what is refused, silence, late answers, and that
 * nobody is held up. */
#define _POSIX_C_SOURCE 200809L

#include "modbus_link.h"
#include "support.h"

#include <errno.h>
#include <modbus.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdio.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define ADDRESS "127.0.0.1"
#define SHORT_MS 200U
#define LONG_MS 60000U /* longer than any test lasts */

static modbus_link_t link_;
static modbus_t *slave;
static modbus_mapping_t *registers;
static int listener;
static char port[8];

static void pause_ms(long ms)
{
    const struct timespec pause = {.tv_nsec = ms * 1000000L};
    (void)nanosleep(&pause, NULL);
}

static void set_up(void)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof at;
    listener = socket(AF_INET, SOCK_STREAM, 0);
    TEST_ASSERT_EQUAL(0, bind(listener, (struct sockaddr *)&at, size));
    TEST_ASSERT_EQUAL(0, listen(listener, 4));
    TEST_ASSERT_EQUAL(0, getsockname(listener, (struct sockaddr *)&at, &size));
    (void)snprintf(port, sizeof port, "%u", (unsigned)ntohs(at.sin_port));
    slave = modbus_new_tcp(ADDRESS, 0);
    registers = modbus_mapping_new(0, 0, 22, 0);
}

static void tear_down(void)
{
    if (listener >= 0) {
        (void)close(listener);
    }
    modbus_free(slave);
    modbus_mapping_free(registers);
}

static void open_link(uint16_t timeout_ms)
{
    TEST_ASSERT_TRUE(modbus_link_open(&link_, ADDRESS, port, 1, timeout_ms));
}

static tumble_status_t begin(uint8_t writes, uint16_t read_at)
{
    const tumble_exchange_t exchange = {
        .write_at = 2, .read_at = read_at, .writes = writes, .reads = 6, .values = {1, 2, 3, 0xFFFF, 5}};
    return link_.link.begin(link_.link.context, &exchange);
}

static tumble_status_t end(uint16_t values[TUMBLE_EXCHANGE_REGISTERS])
{
    return link_.link.end(link_.link.context, values);
}

static tumble_status_t wait_for_end(uint16_t values[TUMBLE_EXCHANGE_REGISTERS])
{
    tumble_status_t status = end(values);
    while (status == TUMBLE_E_PORT_BUSY) {
        pause_ms(1);
        status = end(values);
    }
    return status;
}

static void accept_one(void)
{
    TEST_ASSERT_TRUE(modbus_tcp_accept(slave, &listener) >= 0);
}

/* So many questions of the connection. */
static void answer(int questions)
{
    for (int i = 0; i < questions; i++) {
        uint8_t question[MODBUS_TCP_MAX_ADU_LENGTH];
        const int length = modbus_receive(slave, question);
        TEST_ASSERT_TRUE(length > 0);
        TEST_ASSERT_TRUE(modbus_reply(slave, question, length, registers) > 0);
    }
}

static void test_registers_are_written_and_then_others_read(void)
{
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS] = {0};
    open_link(LONG_MS);
    registers->tab_registers[7] = 0xBEEF;
    ASSERT_STATUS(TUMBLE_OK, begin(5, 2));
    accept_one();
    answer(2);
    ASSERT_STATUS(TUMBLE_OK, wait_for_end(values));
    const uint16_t expected[] = {1, 2, 3, 0xFFFF, 5, 0xBEEF};
    TEST_ASSERT_EQUAL_HEX16_ARRAY(expected, values, COUNT_OF(expected));
    ASSERT_STATUS(TUMBLE_OK, begin(0, 16)); /* one question, on the same connection */
    answer(1);
    ASSERT_STATUS(TUMBLE_OK, wait_for_end(values));
    TEST_ASSERT_EQUAL_HEX16(0, values[0]);
    modbus_link_close(&link_);
}

/* A slave that takes the connection and never answers: neither function waits, or the exchange would have
 * failed when they come back. */
static void test_nobody_is_held_up(void)
{
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS];
    open_link(LONG_MS);
    ASSERT_STATUS(TUMBLE_OK, begin(5, 16));
    accept_one();
    for (int i = 0; i < 100; i++) {
        ASSERT_STATUS(TUMBLE_E_PORT_BUSY, end(values));
        ASSERT_STATUS(TUMBLE_E_PORT_BUSY, begin(5, 16));
    }
    modbus_close(slave); /* the connection is gone: the exchange ends */
    ASSERT_STATUS(TUMBLE_E_PORT_DOWN, wait_for_end(values));
    modbus_link_close(&link_);
}

/* Refused at once, or after the time: both are no answer. */
static void test_nobody_there(void)
{
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS];
    (void)close(listener);
    listener = -1;
    open_link(SHORT_MS);
    for (int i = 0; i < 3; i++) {
        ASSERT_STATUS(TUMBLE_OK, begin(0, 16));
        ASSERT_STATUS(TUMBLE_E_PORT_DOWN, wait_for_end(values));
    }
    modbus_link_close(&link_);
}

static void test_registers_that_there_are_not(void)
{
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS];
    open_link(LONG_MS);
    ASSERT_STATUS(TUMBLE_OK, begin(0, 17)); /* the last of six would be the 23rd */
    accept_one();
    answer(1);
    ASSERT_STATUS(TUMBLE_E_FRAME, wait_for_end(values));
    ASSERT_STATUS(TUMBLE_OK, begin(0, 16)); /* and the connection is still good */
    answer(1);
    ASSERT_STATUS(TUMBLE_OK, wait_for_end(values));
    modbus_link_close(&link_);
}

/* The answer to a question that was given up is not that of the next one. */
static void test_a_late_answer_is_nobodys(void)
{
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS] = {0};
    open_link(SHORT_MS);
    registers->tab_registers[0] = 0xAAAA;
    registers->tab_registers[16] = 0xBBBB;
    ASSERT_STATUS(TUMBLE_OK, begin(0, 0));
    accept_one();
    ASSERT_STATUS(TUMBLE_E_PORT_DOWN, wait_for_end(values));
    (void)modbus_set_response_timeout(link_.modbus, LONG_MS / 1000U, 0);
    ASSERT_STATUS(TUMBLE_OK, begin(0, 16));
    answer(1); /* the first one's, into the connection that was closed */
    modbus_close(slave);
    accept_one();
    answer(1);
    ASSERT_STATUS(TUMBLE_OK, wait_for_end(values));
    TEST_ASSERT_EQUAL_HEX16(0xBBBB, values[0]);
    modbus_link_close(&link_);
}

/* What nobody has asked for is dropped. */
static void test_an_exchange_may_be_left_alone(void)
{
    uint16_t values[TUMBLE_EXCHANGE_REGISTERS];
    open_link(LONG_MS);
    registers->tab_registers[16] = 0xBBBB;
    ASSERT_STATUS(TUMBLE_OK, begin(0, 0));
    accept_one();
    answer(1);
    while (begin(0, 16) == TUMBLE_E_PORT_BUSY) {
        pause_ms(1);
    }
    answer(1);
    ASSERT_STATUS(TUMBLE_OK, wait_for_end(values));
    TEST_ASSERT_EQUAL_HEX16(0xBBBB, values[0]);
    modbus_link_close(&link_);
}

static void test_closing_waits_for_the_exchange_under_way(void)
{
    open_link(SHORT_MS);
    ASSERT_STATUS(TUMBLE_OK, begin(5, 16));
    modbus_link_close(&link_);
}
