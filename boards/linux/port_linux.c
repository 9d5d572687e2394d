#define _POSIX_C_SOURCE 200809L

#include "port_linux.h"

#include <string.h>
#include <time.h>

#define NO_CLASSIC_FRAME (CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_ERR_FLAG)

static uint64_t read_clock_us(clockid_t clock)
{
    struct timespec now;
    (void)clock_gettime(clock, &now);
    return (uint64_t)now.tv_sec * 1000000U + (uint64_t)now.tv_nsec / 1000U;
}

uint64_t port_linux_clock_us(void)
{
    return read_clock_us(CLOCK_MONOTONIC);
}

uint64_t port_linux_utc_us(void)
{
    return read_clock_us(CLOCK_REALTIME);
}

uint64_t port_linux_now_us(const port_linux_t *self)
{
    return port_linux_clock_us() - self->start_us;
}

bool port_linux_from(const struct can_frame *from, tumble_can_frame_t *frame)
{
    if ((from->can_id & NO_CLASSIC_FRAME) != 0U || from->can_dlc > TUMBLE_CAN_MAX_BYTES) {
        return false;
    }
    *frame = (tumble_can_frame_t){.id = (uint16_t)(from->can_id & CAN_SFF_MASK), .length = from->can_dlc};
    memcpy(frame->data, from->data, from->can_dlc);
    return true;
}

void port_linux_to(const tumble_can_frame_t *from, struct can_frame *frame)
{
    *frame = (struct can_frame){.can_id = from->id, .can_dlc = from->length};
    memcpy(frame->data, from->data, from->length);
}

static uint64_t now_us(void *context)
{
    return port_linux_now_us(context);
}

static void tell(const port_linux_t *self, const tumble_can_frame_t *frame)
{
    if (self->on_frame != NULL) {
        self->on_frame(self->context, frame);
    }
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    port_linux_t *const self = context;
    struct can_frame raw;
    if (frame->id > TUMBLE_CAN_MAX_ID || frame->length > TUMBLE_CAN_MAX_BYTES) {
        return TUMBLE_E_ARGUMENT;
    }
    port_linux_to(frame, &raw);
    switch (can_socket_send(&self->can, &raw)) {
    case CAN_SOCKET_OK:
        tell(self, frame);
        return TUMBLE_OK;
    case CAN_SOCKET_BUSY:
        return TUMBLE_E_PORT_BUSY;
    default:
        return TUMBLE_E_PORT_DOWN;
    }
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    port_linux_t *const self = context;
    struct can_frame raw;
    can_socket_status_t status;
    while ((status = can_socket_receive(&self->can, &raw)) == CAN_SOCKET_OK) {
        if (port_linux_from(&raw, frame)) {
            tell(self, frame);
            return TUMBLE_OK;
        }
        self->foreign++;
    }
    return (status == CAN_SOCKET_EMPTY) ? TUMBLE_E_PORT_EMPTY : TUMBLE_E_PORT_DOWN;
}

can_socket_status_t port_linux_open(port_linux_t *self, tumble_port_t *port, const char *interface)
{
    *self = (port_linux_t){.start_us = port_linux_clock_us()};
    *port = (tumble_port_t){.context = self, .now_us = now_us, .can_send = can_send, .can_receive = can_receive};
    return can_socket_open(&self->can, interface);
}

void port_linux_close(port_linux_t *self)
{
    can_socket_close(&self->can);
}
