#include "canopen/link.h"

#include <string.h>

void tumble_link_init(tumble_link_t *link, const tumble_port_t *port)
{
    (void)memset(link, 0, sizeof *link);
    link->port = port;
    link->last = TUMBLE_OK;
}

tumble_status_t tumble_link_send(tumble_link_t *link, const tumble_can_frame_t *frame)
{
    tumble_status_t status = link->port->can_send(link->port->context, frame);
    if (status == TUMBLE_OK) {
        tumble_count(&link->counters.sent);
    } else if (status == TUMBLE_E_PORT_BUSY) {
        tumble_count(&link->counters.busy);
    } else {
        status = TUMBLE_E_PORT_DOWN;
        tumble_count(&link->counters.down);
    }
    link->last = status;
    return status;
}

tumble_status_t tumble_link_send_bytes(tumble_link_t *link, uint32_t id, const uint8_t *bytes, uint8_t length)
{
    tumble_can_frame_t frame = {.id = (uint16_t)id, .length = length};
    (void)memcpy(frame.data, bytes, length);
    return tumble_link_send(link, &frame);
}

tumble_status_t tumble_link_receive(tumble_link_t *link, tumble_can_frame_t *frame)
{
    tumble_status_t status = link->port->can_receive(link->port->context, frame);
    if ((status != TUMBLE_OK) && (status != TUMBLE_E_PORT_EMPTY)) {
        status = TUMBLE_E_PORT_DOWN;
        tumble_count(&link->counters.down);
    }
    link->last = status;
    if (status == TUMBLE_OK) {
        tumble_count(&link->counters.received);
        if ((frame->length > TUMBLE_CAN_MAX_BYTES) || (frame->id > TUMBLE_CAN_MAX_ID)) {
            tumble_count(&link->counters.invalid);
            status = TUMBLE_E_FRAME;
        }
    }
    return status;
}
