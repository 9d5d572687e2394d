#include "port_zcu102.h"

#include "processor.h"

static uint64_t now_us(void *context)
{
    (void)context;
    return zcu102_now_us();
}

static tumble_status_t can_send(void *context, const tumble_can_frame_t *frame)
{
    zcu102_port_t *port = context;
    return zcu102_can_send(&port->can, frame, zcu102_now_us());
}

static tumble_status_t can_receive(void *context, tumble_can_frame_t *frame)
{
    zcu102_port_t *port = context;
    return zcu102_can_receive(&port->can, frame, zcu102_now_us());
}

tumble_status_t zcu102_port_init(zcu102_port_t *port, const zcu102_can_config_t *config)
{
    port->port = (tumble_port_t){.context = port, .now_us = now_us, .can_send = can_send, .can_receive = can_receive};
    return zcu102_can_init(&port->can, config);
}
