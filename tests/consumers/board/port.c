#include "port.h"

#ifndef LOSES
#define LOSES 0
#endif

typedef struct mine_node {
    struct mine_node *other;
    tumble_can_frame_t waiting[MINE_QUEUE];
    uint32_t taken;
    uint32_t sent;
} mine_node_t;

static uint64_t time_us;
static mine_node_t nodes[2] = {{.other = &nodes[1]}, {.other = &nodes[0]}};

void mine_pass(void *context, uint32_t us)
{
    (void)context;
    time_us += us;
}

static uint64_t now_us(void *context)
{
    (void)context;
    return time_us;
}

static tumble_status_t send(void *context, const tumble_can_frame_t *frame)
{
    mine_node_t *node = ((mine_node_t *)context)->other;
    if ((node->sent - node->taken) == MINE_QUEUE) {
        return TUMBLE_E_PORT_BUSY;
    }
    if (!LOSES || (frame->id != 0x123U)) {
        node->waiting[node->sent++ % MINE_QUEUE] = *frame;
    }
    return TUMBLE_OK;
}

static tumble_status_t receive(void *context, tumble_can_frame_t *frame)
{
    mine_node_t *node = context;
    if (node->sent == node->taken) {
        return TUMBLE_E_PORT_EMPTY;
    }
    *frame = node->waiting[node->taken++ % MINE_QUEUE];
    return TUMBLE_OK;
}

const tumble_port_t mine_ports[2] = {
    {.context = &nodes[0], .now_us = now_us, .can_send = send, .can_receive = receive, .nv = &board_memory},
    {.context = &nodes[1], .now_us = now_us, .can_send = send, .can_receive = receive},
};
