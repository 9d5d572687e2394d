/* The CAN socket, on a kernel that is played: what comes, what finds no room, what is lost; an interface that goes. */
#define _GNU_SOURCE

#include "can_socket.h"
#include "port_linux.h"
#include "suite.h"

#include <errno.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <net/if_arp.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

/* The kernel. */

#define DESCRIPTOR 1000 /* nothing but the functions below ever sees it */
#define QUEUE 200

typedef struct {
    int no_socket; /* errno of the call, 0: it succeeds */
    unsigned short hardware;
    bool no_interface;
    bool is_up;
    bool may_force;
    int granted;
    int bound;
    int filters; /* how often asked for everything */
    struct can_frame queue[QUEUE];
    int first, last;
    uint32_t drops; /* so far, as told beside the next frame */
    int receive_error;
    int write_error;
    int calls; /* of recvmmsg */
    struct can_frame written;
} kernel_t;

static kernel_t kernel;
static can_socket_t can;

int __wrap_socket(int domain, int type, int protocol);
int __wrap_ioctl(int fd, unsigned long request, void *argument);
unsigned int __wrap_if_nametoindex(const char *name);
int __wrap_bind(int fd, const struct sockaddr *address, socklen_t size);
int __wrap_setsockopt(int fd, int level, int option, const void *value, socklen_t size);
int __wrap_getsockopt(int fd, int level, int option, void *value, socklen_t *size);
int __wrap_recvmmsg(int fd, struct mmsghdr *messages, unsigned int count, int flags, struct timespec *timeout);
ssize_t __real_write(int fd, const void *bytes, size_t size);
ssize_t __wrap_write(int fd, const void *bytes, size_t size);

int __wrap_socket(int domain, int type, int protocol)
{
    TEST_ASSERT_EQUAL_INT(PF_CAN, domain);
    TEST_ASSERT_EQUAL_INT(SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, type);
    TEST_ASSERT_EQUAL_INT(CAN_RAW, protocol);
    errno = kernel.no_socket;
    return (kernel.no_socket != 0) ? -1 : DESCRIPTOR;
}

int __wrap_ioctl(int fd, unsigned long request, void *argument)
{
    struct ifreq *const asked = argument;
    TEST_ASSERT_EQUAL_INT(DESCRIPTOR, fd);
    TEST_ASSERT_EQUAL_STRING("can0", asked->ifr_name);
    if (kernel.no_interface) {
        errno = ENODEV;
        return -1;
    }
    if (request == SIOCGIFHWADDR) {
        asked->ifr_hwaddr.sa_family = kernel.hardware;
    } else {
        asked->ifr_flags = kernel.is_up ? IFF_UP : 0;
    }
    return 0;
}

unsigned int __wrap_if_nametoindex(const char *name)
{
    (void)name;
    return kernel.no_interface ? 0U : 7U;
}

int __wrap_bind(int fd, const struct sockaddr *address, socklen_t size)
{
    struct sockaddr_can to;
    (void)fd;
    TEST_ASSERT_EQUAL_size_t(sizeof to, size);
    memcpy(&to, address, sizeof to);
    TEST_ASSERT_EQUAL_INT(7, to.can_ifindex);
    kernel.bound++;
    return 0;
}

int __wrap_setsockopt(int fd, int level, int option, const void *value, socklen_t size)
{
    (void)fd;
    if (level == SOL_SOCKET && option == SO_RCVBUFFORCE && !kernel.may_force) {
        errno = EPERM;
        return -1;
    }
    if (level == SOL_SOCKET && (option == SO_RCVBUFFORCE || option == SO_RCVBUF)) {
        int wanted;
        memcpy(&wanted, value, sizeof wanted);
        kernel.granted = (option == SO_RCVBUFFORCE) ? 2 * wanted : 425984;
    }
    if (level == SOL_CAN_RAW && option == CAN_RAW_FILTER) {
        const struct can_filter everything = {0, 0};
        TEST_ASSERT_EQUAL_size_t(sizeof everything, size);
        TEST_ASSERT_EQUAL_MEMORY(&everything, value, sizeof everything);
        kernel.filters++;
    }
    return 0;
}

int __wrap_getsockopt(int fd, int level, int option, void *value, socklen_t *size)
{
    uint32_t numbers[SK_MEMINFO_VARS] = {[SK_MEMINFO_DROPS] = kernel.drops};
    (void)fd;
    (void)level;
    if (option == SO_RCVBUF) {
        memcpy(value, &kernel.granted, sizeof kernel.granted);
    } else {
        TEST_ASSERT_EQUAL_INT(SO_MEMINFO, option);
        memcpy(value, numbers, *size);
    }
    return 0;
}

/* Beside a frame: the count of drops, once there are any, and the time 3 s + the frame's place in us. */
static void remark(struct msghdr *message, int place)
{
    const struct timespec at = {3, place * 1000L};
    struct cmsghdr *c = CMSG_FIRSTHDR(message);
    c->cmsg_level = SOL_SOCKET;
    c->cmsg_type = SCM_TIMESTAMPNS;
    c->cmsg_len = CMSG_LEN(sizeof at);
    memcpy(CMSG_DATA(c), &at, sizeof at);
    c = CMSG_NXTHDR(message, c);
    c->cmsg_level = SOL_SOCKET;
    c->cmsg_type = SO_RXQ_OVFL;
    c->cmsg_len = CMSG_LEN(sizeof kernel.drops);
    memcpy(CMSG_DATA(c), &kernel.drops, sizeof kernel.drops);
}

int __wrap_recvmmsg(int fd, struct mmsghdr *messages, unsigned int count, int flags, struct timespec *timeout)
{
    unsigned int given = 0;
    (void)timeout;
    TEST_ASSERT_EQUAL_INT(DESCRIPTOR, fd);
    TEST_ASSERT_EQUAL_INT(MSG_DONTWAIT, flags);
    kernel.calls++;
    while (kernel.receive_error == 0 && given < count && kernel.first < kernel.last) {
        memcpy(messages[given].msg_hdr.msg_iov->iov_base, &kernel.queue[kernel.first], sizeof(struct can_frame));
        remark(&messages[given].msg_hdr, kernel.first);
        messages[given++].msg_len = sizeof(struct can_frame);
        kernel.first++;
    }
    errno = (kernel.receive_error != 0) ? kernel.receive_error : EAGAIN;
    kernel.receive_error = 0; /* told once */
    return (given > 0U) ? (int)given : -1;
}

ssize_t __wrap_write(int fd, const void *bytes, size_t size)
{
    if (fd != DESCRIPTOR) {
        return __real_write(fd, bytes, size);
    }
    TEST_ASSERT_EQUAL_size_t(sizeof(struct can_frame), size);
    errno = kernel.write_error;
    if (kernel.write_error != 0) {
        return -1;
    }
    memcpy(&kernel.written, bytes, size);
    return (ssize_t)size;
}

static void give(uint32_t id, uint8_t length, uint8_t first)
{
    TEST_ASSERT_TRUE(kernel.last < QUEUE);
    kernel.queue[kernel.last++] = (struct can_frame){.can_id = id, .can_dlc = length, .data = {first}};
}

static void set_up(void)
{
    kernel = (kernel_t){.hardware = ARPHRD_CAN, .is_up = true, .may_force = true};
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_open(&can, "can0"));
}

/* Opening. */

static void test_what_is_asked_of_the_kernel(void)
{
    TEST_ASSERT_EQUAL_UINT32(CAN_SOCKET_RECEIVE_BUFFER, can.receive_buffer);
    TEST_ASSERT_EQUAL_INT(1, kernel.bound);
    TEST_ASSERT_EQUAL_INT(1, kernel.filters);
    kernel.may_force = false;
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_open(&can, "can0"));
    TEST_ASSERT_EQUAL_UINT32(425984, can.receive_buffer); /* what the system's limit allows, and it is told */
}

static void test_what_cannot_be_opened(void)
{
    static const int NO_CAN[] = {EAFNOSUPPORT, EPROTONOSUPPORT};
    for (size_t i = 0; i < 2U; i++) {
        kernel.no_socket = NO_CAN[i];
        TEST_ASSERT_EQUAL(CAN_SOCKET_NO_CAN, can_socket_open(&can, "can0"));
    }
    kernel.no_socket = EMFILE;
    TEST_ASSERT_EQUAL(CAN_SOCKET_FAILED, can_socket_open(&can, "can0"));
    TEST_ASSERT_EQUAL_STRING(strerror(EMFILE), can_socket_sentence(CAN_SOCKET_FAILED));
    kernel.no_socket = 0;
    kernel.hardware = ARPHRD_LOOPBACK;
    TEST_ASSERT_EQUAL(CAN_SOCKET_NO_INTERFACE, can_socket_open(&can, "can0"));
    kernel.no_interface = true;
    TEST_ASSERT_EQUAL(CAN_SOCKET_NO_INTERFACE, can_socket_open(&can, "can0"));
    TEST_ASSERT_EQUAL(CAN_SOCKET_NO_INTERFACE, can_socket_open(&can, ""));
    TEST_ASSERT_EQUAL(CAN_SOCKET_NO_INTERFACE, can_socket_open(&can, "a_name_of_sixteen"));
    TEST_ASSERT_EQUAL_INT(-1, can.fd);
}

/* Frames. */

static void test_frames_come_in_their_order_with_their_time(void)
{
    struct can_frame frame;
    for (uint32_t i = 0; i < 100U; i++) {
        give(0x100U + i, 1, (uint8_t)i);
    }
    for (uint32_t i = 0; i < 100U; i++) {
        TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_receive(&can, &frame));
        TEST_ASSERT_EQUAL_HEX32(0x100U + i, frame.can_id);
        TEST_ASSERT_EQUAL_UINT64(3000000U + i, can_socket_stamp_us(&can));
    }
    TEST_ASSERT_EQUAL_INT(4, kernel.calls); /* in batches */
    TEST_ASSERT_EQUAL(CAN_SOCKET_EMPTY, can_socket_receive(&can, &frame));
    TEST_ASSERT_EQUAL_INT(4, kernel.calls); /* the last batch was not full: there is no need to ask */
    give(0x200, 1, 1);
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_receive(&can, &frame));
    TEST_ASSERT_EQUAL_UINT64(101, can.counters.received);
}

static void test_drops_are_counted_across_the_wrap_of_the_kernels_count(void)
{
    struct can_frame frame;
    kernel.drops = 0xFFFFFFF0U;
    give(1, 0, 0);
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_receive(&can, &frame));
    TEST_ASSERT_EQUAL_UINT64(0xFFFFFFF0U, can.counters.dropped);
    (void)can_socket_receive(&can, &frame);
    kernel.drops = 0x10;
    give(2, 0, 0);
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_receive(&can, &frame));
    TEST_ASSERT_EQUAL_UINT64(0x100000010U, can.counters.dropped);
    kernel.drops = 0x15; /* behind the last frame */
    can_socket_count_drops(&can);
    can_socket_count_drops(&can);
    TEST_ASSERT_EQUAL_UINT64(0x100000015U, can.counters.dropped);
}

static void test_sending(void)
{
    const struct can_frame frame = {.can_id = 0x123, .can_dlc = 2, .data = {1, 2}};
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_send(&can, &frame));
    TEST_ASSERT_EQUAL_MEMORY(&frame, &kernel.written, sizeof frame);
    kernel.write_error = ENOBUFS;
    TEST_ASSERT_EQUAL(CAN_SOCKET_BUSY, can_socket_send(&can, &frame));
    kernel.write_error = EAGAIN;
    TEST_ASSERT_EQUAL(CAN_SOCKET_BUSY, can_socket_send(&can, &frame));
    TEST_ASSERT_EQUAL_UINT64(1, can.counters.sent);
    TEST_ASSERT_EQUAL_UINT64(2, can.counters.busy);
}

/* An interface that goes, and comes back. */

static void test_an_interface_that_goes_down_and_comes_back(void)
{
    static const int REASONS[] = {ENETDOWN, ENODEV, ENXIO};
    const struct can_frame frame = {.can_id = 1};
    struct can_frame got;
    for (size_t i = 0; i < sizeof REASONS / sizeof REASONS[0]; i++) {
        set_up();
        kernel.receive_error = REASONS[i];
        kernel.is_up = false;
        TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_receive(&can, &got));
        TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_receive(&can, &got));
        TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_send(&can, &frame));
        TEST_ASSERT_EQUAL_UINT64(1, can.counters.downs);
        kernel.is_up = true;
        TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_send(&can, &frame));
        TEST_ASSERT_EQUAL(CAN_SOCKET_EMPTY, can_socket_receive(&can, &got));
        TEST_ASSERT_EQUAL_INT(2, kernel.bound);
        TEST_ASSERT_EQUAL_INT(2, kernel.filters);
    }
}

static void test_sending_notices_an_interface_that_is_down(void)
{
    const struct can_frame frame = {.can_id = 1};
    kernel.write_error = ENETDOWN;
    kernel.is_up = false;
    TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_send(&can, &frame));
    kernel.write_error = 0;
    TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_send(&can, &frame));
    TEST_ASSERT_EQUAL_UINT64(1, can.counters.downs);
    TEST_ASSERT_EQUAL_UINT64(0, can.counters.sent);
}

static void test_an_interface_that_is_removed_and_made_anew(void)
{
    struct can_frame got;
    kernel.receive_error = ENODEV;
    kernel.no_interface = true;
    TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_receive(&can, &got));
    TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_receive(&can, &got));
    kernel.no_interface = false;
    give(5, 0, 0);
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_receive(&can, &got));
    TEST_ASSERT_EQUAL(CAN_SOCKET_EMPTY, can_socket_receive(&can, &got));
    TEST_ASSERT_FALSE(can.is_down);
}

static void test_bus_off_and_the_restart(void)
{
    struct can_frame got;
    const struct can_frame frame = {.can_id = 1};
    give(CAN_ERR_FLAG | CAN_ERR_CRTL, 8, 0);
    give(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8, 0);
    give(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8, 0);
    TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_receive(&can, &got));
    TEST_ASSERT_EQUAL(CAN_SOCKET_DOWN, can_socket_send(&can, &frame));
    TEST_ASSERT_EQUAL_UINT64(1, can.counters.bus_offs);
    TEST_ASSERT_EQUAL_UINT64(3, can.counters.errors);
    give(CAN_ERR_FLAG | CAN_ERR_RESTARTED, 8, 0);
    give(0x77, 1, 9);
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_receive(&can, &got));
    TEST_ASSERT_EQUAL_HEX32(0x77, got.can_id);
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, can_socket_send(&can, &frame));
    TEST_ASSERT_EQUAL_UINT64(1, can.counters.received); /* error frames are no frames */
}

/* The port on it. */

static void test_the_port_hands_on_classic_data_frames_alone(void)
{
    port_linux_t self;
    tumble_port_t port;
    tumble_can_frame_t frame;
    TEST_ASSERT_EQUAL(CAN_SOCKET_OK, port_linux_open(&self, &port, "can0"));
    give(0x12345678U | CAN_EFF_FLAG, 1, 1);
    give(0x123U | CAN_RTR_FLAG, 0, 0);
    give(0x7FF, 8, 3);
    TEST_ASSERT_EQUAL(TUMBLE_OK, port.can_receive(port.context, &frame));
    TEST_ASSERT_EQUAL_HEX16(0x7FF, frame.id);
    TEST_ASSERT_EQUAL_UINT64(2, self.foreign);
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_EMPTY, port.can_receive(port.context, &frame));
    frame = (tumble_can_frame_t){.id = 0x800};
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, port.can_send(port.context, &frame));
    frame = (tumble_can_frame_t){.id = 1, .length = 9};
    TEST_ASSERT_EQUAL(TUMBLE_E_ARGUMENT, port.can_send(port.context, &frame));
    frame.length = 8;
    kernel.write_error = ENOBUFS;
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_BUSY, port.can_send(port.context, &frame));
    kernel.receive_error = ENETDOWN;
    kernel.is_up = false;
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_DOWN, port.can_receive(port.context, &frame));
    TEST_ASSERT_EQUAL(TUMBLE_E_PORT_DOWN, port.can_send(port.context, &frame));
    TEST_ASSERT_NULL(port.nv);
}
