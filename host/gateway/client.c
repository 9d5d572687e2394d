#define _POSIX_C_SOURCE 200809L

#include "client.h"

#include <errno.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

void gateway_client_open(gateway_client_t *client, int fd, const gateway_address_t *address, uint64_t now_us)
{
    client->fd = fd;
    client->address = *address;
    client->has_asked = false;
    client->has_ended = false;
    client->asked_us = now_us;
    client->begun_us = now_us;
    client->in_count = 0;
    client->out_count = 0;
    gateway_session_open(&client->session);
}

static bool has_room(const gateway_client_t *client)
{
    return GATEWAY_OUTPUT_BYTES - client->out_count >= GATEWAY_MAX_ADU;
}

/* False: the connection is broken. */
static bool receive(gateway_client_t *client, uint64_t now_us)
{
    const size_t room = GATEWAY_INPUT_BYTES - client->in_count;
    if (room == 0U || client->has_ended) {
        return true;
    }
    const ssize_t got = recv(client->fd, &client->in[client->in_count], room, MSG_DONTWAIT);
    if (got <= 0) {
        client->has_ended = got == 0;
        return got == 0 || errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    }
    client->begun_us = (client->in_count == 0U) ? now_us : client->begun_us;
    client->in_count += (size_t)got;
    return true;
}

static bool send_out(gateway_client_t *client)
{
    if (client->out_count == 0U) {
        return true;
    }
    const ssize_t sent = send(client->fd, client->out, client->out_count, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) {
        return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    }
    client->out_count -= (size_t)sent;
    memmove(client->out, &client->out[sent], client->out_count);
    return true;
}

static void take_frame(gateway_client_t *client, gateway_t *gateway, const gateway_replies_t *replies,
                       gateway_frame_t frame, const uint8_t *bytes, size_t size, uint64_t now_us)
{
    if (frame == GATEWAY_FRAME_PROTOCOL) {
        gateway_count(&gateway->counters, GATEWAY_COUNT_WRONG_PROTOCOL);
    } else if (frame == GATEWAY_FRAME_SHORT) {
        gateway_count(&gateway->counters, GATEWAY_COUNT_WRONG_LENGTH);
    } else {
        client->has_asked = true;
        client->asked_us = now_us;
        client->out_count += gateway_answer(gateway, replies, &client->session, false, bytes, size, now_us,
                                            &client->out[client->out_count]);
    }
}

/* All whole frames for whose answers there is room. False: what follows cannot be read. */
static bool take_frames(gateway_client_t *client, gateway_t *gateway, const gateway_replies_t *replies, uint64_t now_us)
{
    size_t done = 0;
    gateway_frame_t frame = GATEWAY_FRAME_WHOLE;
    while (has_room(client)) {
        size_t size = 0;
        frame = gateway_tcp_frame(&client->in[done], client->in_count - done, &size);
        if (frame == GATEWAY_FRAME_PART || frame == GATEWAY_FRAME_LOST) {
            break;
        }
        take_frame(client, gateway, replies, frame, &client->in[done], size, now_us);
        done += size;
    }
    client->in_count -= done;
    memmove(client->in, &client->in[done], client->in_count);
    client->begun_us = (done > 0U) ? now_us : client->begun_us;
    if (frame == GATEWAY_FRAME_LOST) {
        gateway_count(&gateway->counters, GATEWAY_COUNT_WRONG_LENGTH);
    }
    return frame != GATEWAY_FRAME_LOST;
}

bool gateway_client_step(gateway_client_t *client, gateway_t *gateway, const gateway_replies_t *replies,
                         uint64_t now_us)
{
    if (!send_out(client)) {
        return false;
    }
    if (has_room(client) && !receive(client, now_us)) {
        return false;
    }
    bool is_readable = true;
    bool is_full = true; /* of answers: frames may wait that no event will tell of */
    while (is_full && is_readable && has_room(client)) {
        is_readable = take_frames(client, gateway, replies, now_us);
        is_full = !has_room(client);
        if (!send_out(client)) {
            return false;
        }
    }
    return is_readable && (!client->has_ended || client->out_count > 0U);
}

uint32_t gateway_client_events(const gateway_client_t *client)
{
    const bool is_wanted = has_room(client) && !client->has_ended;
    return (is_wanted ? (uint32_t)EPOLLIN : 0U) | ((client->out_count > 0U) ? (uint32_t)EPOLLOUT : 0U);
}

uint64_t gateway_client_deadline_us(const gateway_client_t *client, const gateway_settings_t *settings)
{
    const uint64_t first_us = (settings->idle_us < GATEWAY_FIRST_US) ? settings->idle_us : GATEWAY_FIRST_US;
    const uint64_t idle_us = client->asked_us + (client->has_asked ? settings->idle_us : first_us);
    const uint64_t part_us = client->begun_us + GATEWAY_PART_US;
    return (client->in_count > 0U && part_us < idle_us) ? part_us : idle_us;
}

void gateway_client_close(gateway_client_t *client, gateway_t *gateway)
{
    gateway_session_close(&client->session, gateway);
    (void)close(client->fd);
    client->fd = -1;
}
