/* tumble-gateway with a node that the test plays: `gateway_harness --can ANY [options of tumble-gateway]`.
 *
 * The node is an SDO server of numbers that lines on standard input give it; every line is answered by "ok".
 *     set INDEX SUB BYTES     an object has a value (INDEX and BYTES hexadecimal, little-endian); others are refused
 *     unset INDEX SUB         it is refused again, with 0800 0024h
 *     refuse CODE             writes are refused with this abort code (hexadecimal); 0: taken
 *     silent 0|1              it does not answer
 *     single 0|1              it has the first SDO server alone
 *     hold 0|1                it answers writes later: when told "hold 0"
 *     play 0|1                it answers a write that was taken when told "played", so that objects may follow from it
 *     down 0|1                the bus is down
 *     boot                    it says that it has booted
 *     noise FRAMES            so many frames that mean nothing come before each answer
 * A write that was taken is a line "write INDEX SUB BYTES" on standard output. Ends with its input.
 */
#define _GNU_SOURCE

#include "server.h"

#include "canopen/sdo_frame.h"
#include "played_sdo.h"

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#define NODE 1U
#define INBOX 256U

typedef struct {
    int wake; /* readable while frames wait */
    played_sdo_t sdo;
    unsigned refuse;
    unsigned silent;
    unsigned single;
    unsigned hold;
    unsigned play;
    unsigned down;
    unsigned noise;
    tumble_can_frame_t inbox[INBOX];
    unsigned put;
    unsigned taken;
    tumble_can_frame_t held;
    char line[1024];
    size_t length;
} node_t;

static node_t node;

static void offer(const tumble_can_frame_t *frame)
{
    for (unsigned i = 0; i < node.noise; i++) {
        node.inbox[node.put++ % INBOX] = (tumble_can_frame_t){.id = (uint16_t)(0x181U + i), .length = 3};
    }
    node.inbox[node.put++ % INBOX] = *frame;
    (void)eventfd_write(node.wake, 1);
}

static uint32_t may_write(uint16_t index, uint8_t sub)
{
    (void)index;
    (void)sub;
    return node.refuse;
}

static bool on_write(void)
{
    const played_object_t *const written = &node.sdo.written;
    printf("write %04X %u ", written->index, written->subindex);
    for (unsigned i = 0; i < written->size; i++) {
        printf("%02X", written->bytes[i]);
    }
    printf("\n");
    (void)fflush(stdout);
    return node.play == 0U;
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    (void)context;
    if (node.down != 0U) {
        return TUMBLE_E_PORT_DOWN;
    }
    node.sdo.silent = node.silent != 0U;
    node.sdo.has_one_server = node.single != 0U;
    if (node.hold != 0U && node.silent == 0U &&
        (frame->data[0] & TUMBLE_SDO_COMMAND_MASK) == TUMBLE_SDO_DOWNLOAD_REQUEST) {
        node.held = *frame;
    } else {
        (void)played_sdo_receive(&node.sdo, frame);
    }
    return TUMBLE_OK;
}

static void set(unsigned index, unsigned sub, const char *text)
{
    uint8_t bytes[PLAYED_BYTES];
    uint8_t size = 0;
    unsigned byte;
    while (size < sizeof bytes && sscanf(&text[2U * size], "%2x", &byte) == 1) {
        bytes[size++] = (uint8_t)byte;
    }
    played_sdo_give(&node.sdo, (uint16_t)index, (uint8_t)sub, bytes, size);
}

static void take_line(const char *line)
{
    unsigned a;
    unsigned b;
    char text[2 * PLAYED_BYTES + 1] = "";
    if (sscanf(line, "set %x %u %128s", &a, &b, text) >= 2) {
        set(a, b, text);
    } else if (sscanf(line, "unset %x %u", &a, &b) == 2) {
        set(a, b, "");
    } else if (sscanf(line, "hold %u", &node.hold) == 1) {
        if (node.hold == 0U) {
            (void)played_sdo_receive(&node.sdo, &node.held);
        }
    } else if (strcmp(line, "played") == 0) {
        played_sdo_acknowledge(&node.sdo);
    } else if (strcmp(line, "boot") == 0) {
        node.inbox[node.put++ % INBOX] = (tumble_can_frame_t){.id = 0x700U + NODE, .length = 1};
        (void)eventfd_write(node.wake, 1);
    } else if (sscanf(line, "refuse %x", &node.refuse) != 1 && sscanf(line, "silent %u", &node.silent) != 1 &&
               sscanf(line, "single %u", &node.single) != 1 && sscanf(line, "down %u", &node.down) != 1 &&
               sscanf(line, "noise %u", &node.noise) != 1 && sscanf(line, "play %u", &node.play) != 1) {
        fprintf(stderr, "gateway_harness: %s?\n", line);
        exit(1);
    }
    printf("ok\n");
    (void)fflush(stdout);
}

static void read_lines(void)
{
    char byte;
    ssize_t got;
    while ((got = read(STDIN_FILENO, &byte, 1)) == 1) {
        if (byte == '\n' || node.length == sizeof node.line - 1U) {
            node.line[node.length] = '\0';
            node.length = 0;
            take_line(node.line);
        } else {
            node.line[node.length++] = byte;
        }
    }
    if (got == 0) {
        (void)raise(SIGTERM);
    }
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    eventfd_t waiting;
    (void)context;
    (void)eventfd_read(node.wake, &waiting);
    read_lines();
    if (node.taken == node.put) {
        return (node.down != 0U) ? TUMBLE_E_PORT_DOWN : TUMBLE_E_PORT_EMPTY;
    }
    *frame = node.inbox[node.taken++ % INBOX];
    return TUMBLE_OK;
}

static uint64_t now_us(void *context)
{
    struct timespec now;
    (void)context;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000U + (uint64_t)now.tv_nsec / 1000U;
}

/* Readable when either of the two is. */
static int watch_both(int one, int other)
{
    const int both = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    (void)epoll_ctl(both, EPOLL_CTL_ADD, one, &event);
    (void)epoll_ctl(both, EPOLL_CTL_ADD, other, &event);
    return both;
}

int main(int count, char **arguments)
{
    static const tumble_port_t port = {.now_us = now_us, .can_send = can_send, .can_receive = can_receive};
    gateway_options_t options;
    if (gateway_options_read(&options, count, arguments) != ARGUMENTS_WORK) {
        return BENCH_EXIT_USAGE;
    }
    (void)fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
    node.wake = eventfd(0, EFD_NONBLOCK);
    node.sdo = (played_sdo_t){.node = NODE, .send = offer, .may_write = may_write, .on_write = on_write};
    return gateway_serve(&options, &port, watch_both(STDIN_FILENO, node.wake));
}
