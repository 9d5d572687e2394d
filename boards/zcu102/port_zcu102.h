/* port_zcu102.h - port.h on this board: one CAN controller and the processor's timer. */
#ifndef ZCU102_PORT_H
#define ZCU102_PORT_H

#include "can.h"
#include "tumble/port.h"

typedef struct {
    tumble_port_t port; /* what the firmware gets */
    zcu102_can_t can;
} zcu102_port_t;

/* `config` must outlive the port, which must not be moved. Returns as zcu102_can_init. */
tumble_status_t zcu102_port_init(zcu102_port_t *port, const zcu102_can_config_t *config);

#endif
