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
 *     tear N                  N times from now on, 2020h:1 changes when 2020h:5 is read
 *     noise FRAMES            so many frames that mean nothing come before each answer
 * A write that was taken is a line "write INDEX SUB BYTES" on standard output. Ends with its input.
 */
#define _GNU_SOURCE

#include "server.h"

#include "canopen/sdo_frame.h"
#include "core/bytes.h"

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
#define MAX_VALUES 512
#define MAX_BYTES 64
#define INBOX 256U
#define TORN 0x2020U

typedef struct {
    unsigned index;
    unsigned sub;
    unsigned size;
    uint8_t bytes[MAX_BYTES];
} value_t;

typedef struct {
    int wake; /* readable while frames wait */
    value_t values[MAX_VALUES];
    unsigned count;
    unsigned refuse;
    unsigned silent;
    unsigned single;
    bool is_second; /* the server that was asked last */
    unsigned hold;
    unsigned play;
    unsigned down;
    unsigned tear;
    unsigned noise;
    value_t upload; /* under way */
    value_t download;
    unsigned sent;
    tumble_can_frame_t inbox[INBOX];
    unsigned put;
    unsigned taken;
    tumble_can_frame_t held;
    uint8_t owed[8];
    char line[1024];
    size_t length;
} node_t;

static node_t node;

static void offer(const uint8_t *bytes)
{
    const unsigned id = (node.is_second ? TUMBLE_SDO_SECOND_RESPONSE_ID : TUMBLE_SDO_RESPONSE_ID) + NODE;
    tumble_can_frame_t frame = {.id = (uint16_t)id, .length = 8};
    for (unsigned i = 0; i < node.noise; i++) {
        node.inbox[node.put++ % INBOX] = (tumble_can_frame_t){.id = (uint16_t)(0x181U + i), .length = 3};
    }
    memcpy(frame.data, bytes, sizeof frame.data);
    node.inbox[node.put++ % INBOX] = frame;
    (void)eventfd_write(node.wake, 1);
}

static void offer_abort(const uint8_t *request, unsigned code)
{
    uint8_t answer[8] = {TUMBLE_SDO_ABORT, request[1], request[2], request[3]};
    tumble_put_u32(&answer[4], code);
    offer(answer);
}

static value_t *find(unsigned index, unsigned sub)
{
    for (unsigned i = 0; i < node.count; i++) {
        if (node.values[i].index == index && node.values[i].sub == sub && node.values[i].size > 0U) {
            return &node.values[i];
        }
    }
    return NULL;
}

static void tear(unsigned index, unsigned sub)
{
    value_t *const first = find(TORN, 1);
    if (node.tear > 0U && index == TORN && sub == 5U && first != NULL) {
        node.tear--;
        first->bytes[0] ^= 1U;
    }
}

static void upload(const uint8_t *request)
{
    const value_t *const value = find(tumble_get_u16(&request[1]), request[3]);
    uint8_t answer[8] = {TUMBLE_SDO_UPLOAD_ANSWER | TUMBLE_SDO_S, request[1], request[2], request[3]};
    tear(tumble_get_u16(&request[1]), request[3]);
    if (value == NULL) {
        offer_abort(request, 0x08000024U);
        return;
    }
    node.upload = *value;
    node.sent = 0;
    if (value->size <= 4U) {
        answer[0] = tumble_sdo_expedited(TUMBLE_SDO_UPLOAD_ANSWER, (uint8_t)value->size);
        memcpy(&answer[4], value->bytes, value->size);
    } else {
        tumble_put_u32(&answer[4], value->size);
    }
    offer(answer);
}

static void upload_segment(const uint8_t *request)
{
    const unsigned left = node.upload.size - node.sent;
    const unsigned now = (left > 7U) ? 7U : left;
    uint8_t answer[8] = {0};
    answer[0] = (uint8_t)((request[0] & TUMBLE_SDO_TOGGLE) | (7U - now) << 1 | ((now == left) ? TUMBLE_SDO_C : 0U));
    memcpy(&answer[1], &node.upload.bytes[node.sent], now);
    node.sent += now;
    offer(answer);
}

static void take_write(const uint8_t *answer)
{
    printf("write %04X %u ", node.download.index, node.download.sub);
    for (unsigned i = 0; i < node.download.size; i++) {
        printf("%02X", node.download.bytes[i]);
    }
    printf("\n");
    (void)fflush(stdout);
    memcpy(node.owed, answer, sizeof node.owed);
    if (node.play == 0U) {
        offer(answer);
    }
}

static void download(const uint8_t *request)
{
    const uint8_t answer[8] = {TUMBLE_SDO_DOWNLOAD_ANSWER, request[1], request[2], request[3]};
    node.download = (value_t){.index = tumble_get_u16(&request[1]), .sub = request[3]};
    if (node.refuse != 0U) {
        offer_abort(request, node.refuse);
        return;
    }
    if ((request[0] & TUMBLE_SDO_E) != 0U) {
        node.download.size = 4U - ((request[0] >> 2) & 3U);
        memcpy(node.download.bytes, &request[4], node.download.size);
        take_write(answer);
    } else {
        offer(answer);
    }
}

static void download_segment(const uint8_t *request)
{
    const uint8_t answer[8] = {(uint8_t)(TUMBLE_SDO_DOWNLOAD_SEGMENT_ANSWER | (request[0] & TUMBLE_SDO_TOGGLE))};
    const unsigned size = 7U - ((request[0] >> 1) & 7U);
    memcpy(&node.download.bytes[node.download.size], &request[1], size);
    node.download.size += size;
    if ((request[0] & TUMBLE_SDO_C) != 0U) {
        take_write(answer);
    } else {
        offer(answer);
    }
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    (void)context;
    if (node.down != 0U) {
        return TUMBLE_E_PORT_DOWN;
    }
    const bool is_second = frame->id == TUMBLE_SDO_SECOND_REQUEST_ID + NODE;
    if (node.silent != 0U || (!is_second && frame->id != TUMBLE_SDO_REQUEST_ID + NODE) ||
        (is_second && node.single != 0U)) {
        return TUMBLE_OK;
    }
    node.is_second = is_second;
    switch (frame->data[0] & TUMBLE_SDO_COMMAND_MASK) {
    case TUMBLE_SDO_UPLOAD_REQUEST:
        upload(frame->data);
        break;
    case TUMBLE_SDO_UPLOAD_SEGMENT_REQUEST:
        upload_segment(frame->data);
        break;
    case TUMBLE_SDO_DOWNLOAD_REQUEST:
        node.held = *frame;
        if (node.hold == 0U) {
            download(frame->data);
        }
        break;
    case TUMBLE_SDO_DOWNLOAD_SEGMENT_REQUEST:
        download_segment(frame->data);
        break;
    default:
        break;
    }
    return TUMBLE_OK;
}

static void set(unsigned index, unsigned sub, const char *text)
{
    value_t *value = find(index, sub);
    unsigned byte;
    if (value == NULL && node.count < MAX_VALUES) {
        value = &node.values[node.count++];
    }
    if (value != NULL) {
        *value = (value_t){.index = index, .sub = sub};
        while (value->size < MAX_BYTES && sscanf(&text[2U * value->size], "%2x", &byte) == 1) {
            value->bytes[value->size++] = (uint8_t)byte;
        }
    }
}

static void take_line(const char *line)
{
    unsigned a;
    unsigned b;
    char text[2 * MAX_BYTES + 1] = "";
    if (sscanf(line, "set %x %u %128s", &a, &b, text) >= 2) {
        set(a, b, text);
    } else if (sscanf(line, "unset %x %u", &a, &b) == 2) {
        set(a, b, "");
    } else if (sscanf(line, "hold %u", &node.hold) == 1) {
        if (node.hold == 0U) {
            download(node.held.data);
        }
    } else if (strcmp(line, "played") == 0) {
        offer(node.owed);
    } else if (strcmp(line, "boot") == 0) {
        node.inbox[node.put++ % INBOX] = (tumble_can_frame_t){.id = 0x700U + NODE, .length = 1};
        (void)eventfd_write(node.wake, 1);
    } else if (sscanf(line, "refuse %x", &node.refuse) != 1 && sscanf(line, "silent %u", &node.silent) != 1 &&
               sscanf(line, "single %u", &node.single) != 1 && sscanf(line, "down %u", &node.down) != 1 &&
               sscanf(line, "tear %u", &node.tear) != 1 && sscanf(line, "noise %u", &node.noise) != 1 &&
               sscanf(line, "play %u", &node.play) != 1) {
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
    return gateway_serve(&options, &port, watch_both(STDIN_FILENO, node.wake));
}
