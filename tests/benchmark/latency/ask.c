/* ask.c - ask a node and an echo on two CAN interfaces in turn; print when the kernel had each request and each answer.
 *
 *   ask NODE_INTERFACE ECHO_INTERFACE REQUESTS PERIOD_US
 *
 * Requests are sent at moments that were drawn beforehand, PERIOD_US apart on average, whether or not the ones before
 * are answered: a node that is held up is asked as often as one that is not, and all that waited for it count. A line
 * per request, in the order of sending: `0` (node) or `1` (echo), nanoseconds of CLOCK_REALTIME at which the kernel had
 * the request, and the answer; 0: there was none until PATIENCE_S after the last request.
 *
 * Both stamps are the kernel's, taken when it hands a frame to all sockets of an interface; so it does not matter when
 * this program reads them. It does so before it sends, never after it: it sleeps while the node works.
 *
 * The node is read by its second SDO server, 2003h:1 to :8; the echo repeats the eight bytes. Both send their answers
 * in the order of the requests, and the subindex in them tells where one is missing.
 */
#define _GNU_SOURCE

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define NODE_REQUEST 0x401U /* the second SDO server of node 1 */
#define NODE_ANSWER 0x381U
#define ECHO_REQUEST 0x5F0U
#define ECHO_ANSWER 0x5F1U
#define UPLOAD 0x40U
#define UPLOAD_ANSWER_MASK 0xE0U
#define OBJECT 0x2003U
#define SUBINDICES 8U
#define TARGETS 2U
#define MOST_REQUESTS 1000000U
#define PATIENCE_S 3
#define RECEIVE_BUFFER (8 * 1024 * 1024)
#define NS_PER_US 1000U
#define NS_PER_S 1000000000U

typedef struct {
    uint64_t asked_ns;
    uint64_t answered_ns;
} request_t;

typedef struct {
    int fd;
    uint32_t request_id;
    uint32_t answer_id;
    request_t *requests;
    uint32_t sent;
    uint32_t stamped;  /* requests that were read back */
    uint32_t answered; /* requests up to here have their answer, or will have none */
} target_t;

static void fail(const char *what)
{
    perror(what);
    exit(1);
}

static void open_target(target_t *target, const char *interface, uint32_t requests)
{
    const struct can_filter filters[] = {{target->request_id, CAN_SFF_MASK}, {target->answer_id, CAN_SFF_MASK}};
    const int on = 1;
    const int buffer = RECEIVE_BUFFER;
    const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(interface)};
    target->requests = calloc(requests, sizeof *target->requests);
    target->fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    if (target->requests == NULL || target->fd < 0 ||
        setsockopt(target->fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters, sizeof filters) != 0 ||
        setsockopt(target->fd, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &on, sizeof on) != 0 ||
        setsockopt(target->fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0 ||
        setsockopt(target->fd, SOL_SOCKET, SO_RCVBUFFORCE, &buffer, sizeof buffer) != 0 ||
        bind(target->fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        fail(interface);
    }
}

static uint64_t stamp_of(struct msghdr *message)
{
    struct timespec at = {0, 0};
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c != NULL; c = CMSG_NXTHDR(message, c)) {
        if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_TIMESTAMPNS) {
            memcpy(&at, CMSG_DATA(c), sizeof at);
        }
    }
    return (uint64_t)at.tv_sec * NS_PER_S + (uint64_t)at.tv_nsec;
}

static uint8_t subindex_of(uint32_t number)
{
    return (uint8_t)(1U + number % SUBINDICES);
}

/* Answers come in order: what waits before the one that it belongs to was lost. */
static void take_answer(target_t *target, const struct can_frame *frame, uint64_t stamp_ns)
{
    uint32_t number = target->answered;
    if (target->answer_id == NODE_ANSWER && (frame->data[0] & UPLOAD_ANSWER_MASK) != UPLOAD) {
        fprintf(stderr, "the node refuses to read 2003h:%u\n", frame->data[3]);
        exit(1);
    }
    while (number < target->stamped && subindex_of(number) != frame->data[3]) {
        number++;
    }
    if (number < target->stamped) {
        target->requests[number].answered_ns = stamp_ns;
        target->answered = number + 1U;
    }
}

/* Whatever the kernel has of a target by now. */
static void drain(target_t *target)
{
    struct can_frame frame;
    union {
        struct cmsghdr header; /* for its alignment */
        char room[CMSG_SPACE(sizeof(struct timespec))];
    } control;
    for (;;) {
        struct iovec part = {&frame, sizeof frame};
        struct msghdr message = {
            .msg_iov = &part, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
        if (recvmsg(target->fd, &message, MSG_DONTWAIT) != (ssize_t)sizeof frame) {
            return;
        }
        const uint64_t stamp_ns = stamp_of(&message);
        if ((frame.can_id & CAN_SFF_MASK) == target->answer_id) {
            take_answer(target, &frame, stamp_ns);
        } else if (target->stamped < target->sent) {
            target->requests[target->stamped++].asked_ns = stamp_ns;
        }
    }
}

static void ask(target_t *target)
{
    struct can_frame frame = {.can_id = target->request_id, .can_dlc = 8};
    frame.data[0] = UPLOAD;
    frame.data[1] = OBJECT & 0xFFU;
    frame.data[2] = OBJECT >> 8U;
    frame.data[3] = subindex_of(target->sent);
    target->sent++;
    if (write(target->fd, &frame, sizeof frame) != (ssize_t)sizeof frame) {
        fail("write");
    }
}

static void sleep_until(uint64_t at_ns)
{
    const struct timespec at = {(time_t)(at_ns / NS_PER_S), (long)(at_ns % NS_PER_S)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL) != 0) {
    }
}

static uint64_t now_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * NS_PER_S + (uint64_t)now.tv_nsec;
}

/* Evenly between half and one and a half periods: no phase of what the node does at a period of its own is preferred. */
static uint64_t draw_gap_ns(uint64_t period_us)
{
    static uint64_t state = 1;
    state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    const uint64_t period_ns = period_us * NS_PER_US;
    return period_ns / 2U + (state >> 33U) % (period_ns + 1U);
}

/* A request that comes too late, because this process was held up, moves those after it: none come in bursts. */
static void ask_all(target_t *targets, uint32_t requests, uint64_t period_us)
{
    uint64_t due_ns = now_ns();
    for (uint32_t i = 0; i < TARGETS * requests; i++) {
        const uint64_t earliest_ns = now_ns();
        due_ns = ((due_ns > earliest_ns) ? due_ns : earliest_ns) + draw_gap_ns(period_us) / TARGETS;
        sleep_until(due_ns);
        for (uint32_t k = 0; k < TARGETS; k++) {
            drain(&targets[k]);
        }
        ask(&targets[i % TARGETS]);
    }
}

static bool are_answered(const target_t *targets)
{
    return targets[0].answered == targets[0].sent && targets[1].answered == targets[1].sent;
}

static void wait_for_answers(target_t *targets)
{
    const uint64_t until_ns = now_ns() + (uint64_t)PATIENCE_S * NS_PER_S;
    while (!are_answered(targets) && now_ns() < until_ns) {
        sleep_until(now_ns() + NS_PER_S / 100U);
        drain(&targets[0]);
        drain(&targets[1]);
    }
}

static void print(const target_t *targets)
{
    for (uint32_t i = 0; i < TARGETS * targets[0].sent; i++) {
        const request_t *const request = &targets[i % TARGETS].requests[i / TARGETS];
        printf("%u %llu %llu\n", (unsigned)(i % TARGETS), (unsigned long long)request->asked_ns,
               (unsigned long long)request->answered_ns);
    }
}

int main(int count, char **arguments)
{
    target_t targets[TARGETS] = {{.request_id = NODE_REQUEST, .answer_id = NODE_ANSWER},
                                 {.request_id = ECHO_REQUEST, .answer_id = ECHO_ANSWER}};
    const long requests = (count == 5) ? atol(arguments[3]) : 0;
    const long period_us = (count == 5) ? atol(arguments[4]) : 0;
    if (requests < 1 || requests > (long)MOST_REQUESTS || period_us < 100 || period_us > 1000000) {
        fprintf(stderr, "usage: ask NODE_INTERFACE ECHO_INTERFACE REQUESTS PERIOD_US\n");
        return 2;
    }
    open_target(&targets[0], arguments[1], (uint32_t)requests);
    open_target(&targets[1], arguments[2], (uint32_t)requests);
    ask_all(targets, (uint32_t)requests, (uint64_t)period_us);
    wait_for_answers(targets);
    print(targets);
    return 0;
}
