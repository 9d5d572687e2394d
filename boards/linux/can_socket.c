#define _GNU_SOURCE /* struct ifreq, SO_RCVBUFFORCE */

#include "can_socket.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <net/if_arp.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#define CLASSES_OF_ERRORS (CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL | CAN_ERR_PROT | CAN_ERR_ACK)

/* Null-terminated by the caller's check of the length. */
static void name_request(struct ifreq *request, const char *name)
{
    memset(request, 0, sizeof *request);
    memcpy(request->ifr_name, name, strlen(name));
}

static bool is_can_interface(int fd, const char *name)
{
    struct ifreq request;
    name_request(&request, name);
    return ioctl(fd, SIOCGIFHWADDR, &request) == 0 && request.ifr_hwaddr.sa_family == ARPHRD_CAN;
}

static bool is_up(const can_socket_t *can)
{
    struct ifreq request;
    name_request(&request, can->name);
    return ioctl(can->fd, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) != 0;
}

/* An interface that is removed takes the socket's filters with it: so everything is asked for anew. */
static bool bind_to(const can_socket_t *can)
{
    const struct can_filter everything = {0, 0};
    (void)setsockopt(can->fd, SOL_CAN_RAW, CAN_RAW_FILTER, &everything, sizeof everything);
    const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(can->name)};
    return address.can_ifindex != 0 && bind(can->fd, (const struct sockaddr *)&address, sizeof address) == 0;
}

/* Large, whatever the system's limit if we may; and let the kernel tell what it drops all the same. */
static void set_buffers(can_socket_t *can)
{
    const int wanted = CAN_SOCKET_RECEIVE_BUFFER / 2; /* the kernel doubles it, for its own overhead */
    const int on = 1;
    int granted = 0;
    socklen_t size = sizeof granted;
    if (setsockopt(can->fd, SOL_SOCKET, SO_RCVBUFFORCE, &wanted, sizeof wanted) != 0) {
        (void)setsockopt(can->fd, SOL_SOCKET, SO_RCVBUF, &wanted, sizeof wanted);
    }
    (void)getsockopt(can->fd, SOL_SOCKET, SO_RCVBUF, &granted, &size);
    (void)setsockopt(can->fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
    (void)setsockopt(can->fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    can->receive_buffer = (uint32_t)granted;
}

static can_socket_status_t give_up(can_socket_t *can, can_socket_status_t status)
{
    const int reason = errno;
    can_socket_close(can);
    errno = reason;
    return status;
}

can_socket_status_t can_socket_open(can_socket_t *can, const char *interface)
{
    const can_err_mask_t errors = CLASSES_OF_ERRORS;
    *can = (can_socket_t){.fd = -1};
    if (strlen(interface) >= sizeof can->name || *interface == '\0') {
        return CAN_SOCKET_NO_INTERFACE;
    }
    memcpy(can->name, interface, strlen(interface) + 1U);
    can->fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (can->fd < 0) {
        return (errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT) ? CAN_SOCKET_NO_CAN : CAN_SOCKET_FAILED;
    }
    if (!is_can_interface(can->fd, interface)) {
        return give_up(can, CAN_SOCKET_NO_INTERFACE);
    }
    set_buffers(can);
    if (setsockopt(can->fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0 || !bind_to(can)) {
        return give_up(can, CAN_SOCKET_FAILED);
    }
    return CAN_SOCKET_OK;
}

const char *can_socket_sentence(can_socket_status_t status)
{
    switch (status) {
    case CAN_SOCKET_NO_CAN:
        return "this kernel has no CAN sockets: modprobe -a can can_raw (to try without: docs/gateway.md)";
    case CAN_SOCKET_NO_INTERFACE:
        return "there is no CAN interface of this name";
    case CAN_SOCKET_FAILED:
        return strerror(errno);
    default:
        return "";
    }
}

static can_socket_status_t note_down(can_socket_t *can)
{
    if (!can->is_down) {
        can->is_down = true;
        can->counters.downs++;
    }
    return CAN_SOCKET_DOWN;
}

/* The kernel tells of an interface that goes down, but not of one that is back: so look. */
static bool is_still_down(can_socket_t *can)
{
    if (can->is_down && is_up(can) && bind_to(can)) {
        can->is_down = false;
    }
    return can->is_down || can->is_off;
}

static void take_error(can_socket_t *can, const struct can_frame *frame)
{
    can->counters.errors++;
    if ((frame->can_id & CAN_ERR_RESTARTED) != 0U) {
        can->is_off = false;
    }
    if ((frame->can_id & CAN_ERR_BUSOFF) != 0U) {
        can->counters.bus_offs += can->is_off ? 0U : 1U;
        can->is_off = true;
    }
}

/* The kernel's own count so far, modulo 32 bits. */
static void count_drops(can_socket_t *can, uint32_t now)
{
    can->counters.dropped += (uint32_t)(now - can->overflow);
    can->overflow = now;
}

static void take_stamp(uint64_t *stamp_us, const struct cmsghdr *c)
{
    struct timespec at;
    memcpy(&at, CMSG_DATA(c), sizeof at);
    *stamp_us = (uint64_t)at.tv_sec * 1000000U + (uint64_t)at.tv_nsec / 1000U;
}

/* What the kernel says beside a frame. */
static void take_remarks(can_socket_t *can, struct msghdr *message, uint64_t *stamp_us)
{
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c != NULL; c = CMSG_NXTHDR(message, c)) {
        if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SO_RXQ_OVFL) {
            uint32_t now;
            memcpy(&now, CMSG_DATA(c), sizeof now);
            count_drops(can, now);
        } else if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_TIMESTAMPNS) {
            take_stamp(stamp_us, c);
        }
    }
}

/* Frames that the kernel has, up to a batch; -1: none, errno says why. */
static int read_batch(can_socket_t *can)
{
    union {
        struct cmsghdr header; /* for its alignment */
        char room[CMSG_SPACE(sizeof(uint32_t)) + CMSG_SPACE(sizeof(struct timespec))];
    } control[CAN_SOCKET_BATCH];
    struct iovec parts[CAN_SOCKET_BATCH];
    struct mmsghdr messages[CAN_SOCKET_BATCH];
    memset(messages, 0, sizeof messages);
    for (uint32_t i = 0; i < CAN_SOCKET_BATCH; i++) {
        parts[i] = (struct iovec){&can->batch[i], sizeof can->batch[i]};
        messages[i].msg_hdr = (struct msghdr){
            .msg_iov = &parts[i], .msg_iovlen = 1, .msg_control = &control[i], .msg_controllen = sizeof control[i]};
    }
    const int got = recvmmsg(can->fd, messages, CAN_SOCKET_BATCH, MSG_DONTWAIT, NULL);
    for (int i = 0; i < got; i++) {
        take_remarks(can, &messages[i].msg_hdr, &can->stamps_us[i]);
    }
    return got;
}

static bool means_down(int reason)
{
    return reason == ENETDOWN || reason == ENODEV || reason == ENXIO;
}

/* OK: there is a batch. */
static can_socket_status_t refill(can_socket_t *can)
{
    if (can->drained) {
        can->drained = false;
        return is_still_down(can) ? CAN_SOCKET_DOWN : CAN_SOCKET_EMPTY;
    }
    const int got = read_batch(can);
    if (got < 0 && means_down(errno)) {
        return note_down(can);
    }
    if (got <= 0) {
        return is_still_down(can) ? CAN_SOCKET_DOWN : CAN_SOCKET_EMPTY;
    }
    can->first = 0;
    can->count = (uint32_t)got;
    can->drained = can->count < CAN_SOCKET_BATCH;
    return CAN_SOCKET_OK;
}

can_socket_status_t can_socket_receive(can_socket_t *can, struct can_frame *frame)
{
    for (;;) {
        const can_socket_status_t status = (can->first < can->count) ? CAN_SOCKET_OK : refill(can);
        if (status != CAN_SOCKET_OK) {
            return status;
        }
        *frame = can->batch[can->first++];
        if ((frame->can_id & CAN_ERR_FLAG) == 0U) {
            can->counters.received++;
            return CAN_SOCKET_OK;
        }
        take_error(can, frame);
    }
}

uint64_t can_socket_stamp_us(const can_socket_t *can)
{
    return (can->first > 0U) ? can->stamps_us[can->first - 1U] : 0U;
}

can_socket_status_t can_socket_send(can_socket_t *can, const struct can_frame *frame)
{
    if (is_still_down(can)) {
        return CAN_SOCKET_DOWN;
    }
    if (write(can->fd, frame, sizeof *frame) == (ssize_t)sizeof *frame) {
        can->counters.sent++;
        return CAN_SOCKET_OK;
    }
    if (means_down(errno)) {
        return note_down(can);
    }
    can->counters.busy++;
    return CAN_SOCKET_BUSY;
}

void can_socket_count_drops(can_socket_t *can)
{
    uint32_t numbers[SK_MEMINFO_VARS] = {0};
    socklen_t size = sizeof numbers;
    if (getsockopt(can->fd, SOL_SOCKET, SO_MEMINFO, numbers, &size) == 0) {
        count_drops(can, numbers[SK_MEMINFO_DROPS]);
    }
}

void can_socket_close(can_socket_t *can)
{
    if (can->fd >= 0) {
        (void)close(can->fd);
        can->fd = -1;
    }
}
