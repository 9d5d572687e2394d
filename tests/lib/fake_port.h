/* fake_port.h - a port that a test holds in its hands: the clock stands still until told, frames wait in two queues.
 *
 * `fake_port_give` puts a frame where the firmware will receive it, `fake_port_take` takes what it has sent, oldest
 * first. The port can be told to be busy, down, or to lie (return a status outside its list).
 */
#ifndef TUMBLE_TESTS_FAKE_PORT_H
#define TUMBLE_TESTS_FAKE_PORT_H

#include "tumble/port.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef FAKE_PORT_QUEUE
#define FAKE_PORT_QUEUE 4096U
#endif

typedef struct {
    tumble_can_frame_t frames[FAKE_PORT_QUEUE];
    size_t first;
    size_t count;
} fake_queue_t;

typedef struct {
    tumble_port_t port;
    uint64_t now_us;
    fake_queue_t to_firmware;
    fake_queue_t from_firmware;
    tumble_status_t send_status;    /* TUMBLE_OK: frames are taken; anything else is returned instead */
    tumble_status_t receive_status; /* likewise */
    size_t send_room;               /* frames that are still taken before the port is busy; SIZE_MAX: no limit */
    bool overflowed;                /* a queue was full: the test is wrong */
} fake_port_t;

static inline bool fake_queue_put(fake_queue_t *queue, const tumble_can_frame_t *frame)
{
    if (queue->count == FAKE_PORT_QUEUE) {
        return false;
    }
    queue->frames[(queue->first + queue->count) % FAKE_PORT_QUEUE] = *frame;
    queue->count++;
    return true;
}

static inline bool fake_queue_get(fake_queue_t *queue, tumble_can_frame_t *frame)
{
    if (queue->count == 0U) {
        return false;
    }
    *frame = queue->frames[queue->first];
    queue->first = (queue->first + 1U) % FAKE_PORT_QUEUE;
    queue->count--;
    return true;
}

static inline uint64_t fake_port_now_us(void *context)
{
    return ((const fake_port_t *)context)->now_us;
}

static inline tumble_status_t fake_port_send(void *context, const tumble_can_frame_t *frame)
{
    fake_port_t *fake = context;
    if (fake->send_status != TUMBLE_OK) {
        return fake->send_status;
    }
    if (fake->send_room == 0U) {
        return TUMBLE_E_PORT_BUSY;
    }
    fake->send_room -= (fake->send_room == SIZE_MAX) ? 0U : 1U;
    fake->overflowed = !fake_queue_put(&fake->from_firmware, frame) || fake->overflowed;
    return TUMBLE_OK;
}

static inline tumble_status_t fake_port_receive(void *context, tumble_can_frame_t *frame)
{
    fake_port_t *fake = context;
    if (fake->receive_status != TUMBLE_OK) {
        return fake->receive_status;
    }
    return fake_queue_get(&fake->to_firmware, frame) ? TUMBLE_OK : TUMBLE_E_PORT_EMPTY;
}

static inline void fake_port_init(fake_port_t *fake)
{
    fake->port = (tumble_port_t){
        .context = fake, .now_us = fake_port_now_us, .can_send = fake_port_send, .can_receive = fake_port_receive};
    fake->now_us = 0;
    fake->to_firmware.first = 0;
    fake->to_firmware.count = 0;
    fake->from_firmware.first = 0;
    fake->from_firmware.count = 0;
    fake->send_status = TUMBLE_OK;
    fake->receive_status = TUMBLE_OK;
    fake->send_room = SIZE_MAX;
    fake->overflowed = false;
}

/* Let the firmware receive a frame. */
static inline void fake_port_give(fake_port_t *fake, const tumble_can_frame_t *frame)
{
    fake->overflowed = !fake_queue_put(&fake->to_firmware, frame) || fake->overflowed;
}

/* Take the oldest frame that the firmware has sent; false when there is none. */
static inline bool fake_port_take(fake_port_t *fake, tumble_can_frame_t *frame)
{
    return fake_queue_get(&fake->from_firmware, frame);
}

/* A frame from its bytes, for tests that write frames out. */
static inline tumble_can_frame_t fake_frame(uint16_t id, uint8_t length, const uint8_t *data)
{
    tumble_can_frame_t frame = {.id = id, .length = length};
    for (size_t i = 0; (i < length) && (i < TUMBLE_CAN_MAX_BYTES); i++) {
        frame.data[i] = data[i];
    }
    return frame;
}

#endif
