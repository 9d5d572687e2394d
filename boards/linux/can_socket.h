/* can_socket.h - one raw CAN socket of Linux: frames in and out without waiting, and everything that is lost counted.
 *
 * Classic frames are taken and given as struct can_frame of <linux/can.h>. Error frames are consumed here: a controller
 * that is off the bus, an interface that is down or gone count as "down", and are looked after until they are back; an
 * interface that was removed is bound again when one of its name has come. Not re-entrant on one object.
 */
#ifndef TUMBLE_LINUX_CAN_SOCKET_H
#define TUMBLE_LINUX_CAN_SOCKET_H

#include <linux/can.h>
#include <net/if.h>

#include <stdbool.h>
#include <stdint.h>

/* Asked of the kernel; what it grants is in `receive_buffer`. About 10,000 frames, three seconds of a full bus. */
#define CAN_SOCKET_RECEIVE_BUFFER (8 * 1024 * 1024)

#define CAN_SOCKET_BATCH 32U /* frames taken from the kernel at one time */

typedef enum {
    CAN_SOCKET_OK = 0,
    CAN_SOCKET_EMPTY,        /* nothing to receive */
    CAN_SOCKET_BUSY,         /* no room to send now */
    CAN_SOCKET_DOWN,         /* interface down, gone, or its controller off the bus */
    CAN_SOCKET_NO_CAN,       /* of opening: this kernel has no CAN sockets */
    CAN_SOCKET_NO_INTERFACE, /* of opening: no interface of that name, or it is no CAN interface */
    CAN_SOCKET_FAILED        /* of opening: anything else, errno says what */
} can_socket_status_t;

/* Monotonic since opening. */
typedef struct {
    uint64_t received;
    uint64_t sent;
    uint64_t dropped; /* by the kernel: the receive buffer was full */
    uint64_t busy;    /* attempts to send that found no room */
    uint64_t errors;  /* error frames of the controller */
    uint64_t bus_offs;
    uint64_t downs; /* times that the interface went down or away */
} can_socket_counters_t;

typedef struct {
    int fd; /* -1: not open; for poll and epoll */
    char name[IF_NAMESIZE];
    uint32_t receive_buffer; /* bytes */
    uint32_t overflow;       /* the kernel's own count of drops, as last seen; wraps */
    bool is_down;            /* the interface */
    bool is_off;             /* the controller, off the bus */
    struct can_frame batch[CAN_SOCKET_BATCH];
    uint64_t stamps_us[CAN_SOCKET_BATCH];
    uint32_t first; /* of the batch that is not taken yet */
    uint32_t count;
    bool drained; /* the kernel had no more than the last batch */
    can_socket_counters_t counters;
} can_socket_t;

/* Open and bind. A down interface is no failure. On failure nothing stays open. */
can_socket_status_t can_socket_open(can_socket_t *can, const char *interface);

/* When the kernel received the frame that was taken last: UTC, in microseconds. */
uint64_t can_socket_stamp_us(const can_socket_t *can);

/* What went wrong in opening, for one line to the user. */
const char *can_socket_sentence(can_socket_status_t status);

/* The oldest frame: data, remote or extended frames alike. OK, EMPTY or DOWN. After EMPTY wait for the descriptor, or
 * ask again: what has come meanwhile is told by either. */
can_socket_status_t can_socket_receive(can_socket_t *can, struct can_frame *frame);

/* OK, BUSY or DOWN. All others on the interface get the frame, this socket does not. */
can_socket_status_t can_socket_send(can_socket_t *can, const struct can_frame *frame);

/* Count what the kernel has dropped behind frames that are still to be received. */
void can_socket_count_drops(can_socket_t *can);

void can_socket_close(can_socket_t *can);

#endif
