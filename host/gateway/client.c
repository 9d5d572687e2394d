#define _GNU_SOURCE /* accept4 */

#include "client.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#define BACKLOG 64
#define HOST_BYTES 128
#define PORT_BYTES 16

/* Bytes. */

static bool is_passing(int error)
{
    return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

int gateway_stream_receive(gateway_stream_t *stream)
{
    const size_t room = sizeof stream->in - stream->in_count;
    if (room == 0U) {
        return 1;
    }
    const ssize_t got = read(stream->fd, &stream->in[stream->in_count], room);
    if (got < 0) {
        return is_passing(errno) ? 1 : -1;
    }
    stream->in_count += (size_t)got;
    return (int)got;
}

void gateway_stream_drop(gateway_stream_t *stream, size_t size)
{
    stream->in_count -= size;
    memmove(stream->in, &stream->in[size], stream->in_count);
}

bool gateway_stream_send(gateway_stream_t *stream)
{
    if (stream->out_count == 0U) {
        return true;
    }
    const ssize_t sent = write(stream->fd, stream->out, stream->out_count); /* SIGPIPE is ignored */
    if (sent <= 0) {
        return sent < 0 && is_passing(errno);
    }
    stream->out_count -= (size_t)sent;
    memmove(stream->out, &stream->out[sent], stream->out_count);
    return true;
}

/* Where they come to. */

static int listen_at(const struct addrinfo *address)
{
    const int on = 1;
    const int fd = socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) {
        return -1;
    }
    (void)setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(fd, address->ai_addr, address->ai_addrlen) != 0 || listen(fd, BACKLOG) != 0) {
        const int reason = errno;
        (void)close(fd);
        errno = reason;
        return -1;
    }
    return fd;
}

int gateway_listen(const char *host, const char *port, const char **what)
{
    const struct addrinfo wanted = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM, .ai_flags = AI_NUMERICSERV};
    struct addrinfo *found = NULL;
    int fd = -1;
    const int failure = getaddrinfo(host, port, &wanted, &found);
    if (failure != 0) {
        *what = gai_strerror(failure);
        return -1;
    }
    for (const struct addrinfo *address = found; address != NULL && fd < 0; address = address->ai_next) {
        fd = listen_at(address);
    }
    *what = strerror(errno);
    freeaddrinfo(found);
    return fd;
}

void gateway_listener_name(int listener, char *name, size_t size)
{
    struct sockaddr_storage address;
    socklen_t length = sizeof address;
    char host[HOST_BYTES] = "?";
    char port[PORT_BYTES] = "?";
    if (getsockname(listener, (struct sockaddr *)&address, &length) == 0) {
        (void)getnameinfo((const struct sockaddr *)&address, length, host, sizeof host, port, sizeof port,
                          NI_NUMERICHOST | NI_NUMERICSERV);
    }
    (void)snprintf(name, size, (address.ss_family == AF_INET6) ? "[%s]:%s" : "%s:%s", host, port);
}

static gateway_address_t address_of(const struct sockaddr_storage *from)
{
    gateway_address_t address = {.ip.s6_addr = {[10] = 0xFF, [11] = 0xFF}};
    if (from->ss_family == AF_INET6) {
        address.ip = ((const struct sockaddr_in6 *)from)->sin6_addr;
    } else {
        memcpy(&address.ip.s6_addr[12], &((const struct sockaddr_in *)from)->sin_addr, 4);
    }
    const bool is_old = IN6_IS_ADDR_V4MAPPED(&address.ip);
    (void)inet_ntop(is_old ? AF_INET : AF_INET6, &address.ip.s6_addr[is_old ? 12 : 0], address.text,
                    sizeof address.text);
    return address;
}

int gateway_accept(int listener, gateway_address_t *address, bool *is_short)
{
    const int on = 1;
    struct sockaddr_storage from;
    socklen_t length = sizeof from;
    const int fd = accept4(listener, (struct sockaddr *)&from, &length, SOCK_NONBLOCK | SOCK_CLOEXEC);
    *is_short = fd < 0 && (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM);
    if (fd >= 0) {
        (void)setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        *address = address_of(&from);
    }
    return fd;
}

/* Who gets a place. */

static bool is_same(const gateway_address_t *one, const gateway_address_t *other)
{
    return memcmp(&one->ip, &other->ip, sizeof one->ip) == 0;
}

static uint32_t places_of(const gateway_client_t *clients, const gateway_address_t *address)
{
    uint32_t count = 0;
    for (uint32_t place = 0; place < GATEWAY_MAX_CLIENTS; place++) {
        count += (clients[place].stream.fd >= 0 && is_same(&clients[place].address, address)) ? 1U : 0U;
    }
    return count;
}

/* Nothing begun, no answer owed, and no request of late. */
static bool is_idle(const gateway_client_t *client, uint64_t now_us)
{
    const bool is_calm = !client->has_asked || now_us - client->asked_us >= GATEWAY_CALM_US;
    return client->stream.in_count == 0U && client->stream.out_count == 0U && is_calm;
}

/* It gives way to an address that would still hold fewer places than its own; to one that holds as many, if it is idle. */
static bool may_give_way(const gateway_client_t *client, uint32_t held, uint32_t own, uint64_t now_us)
{
    return held > own + 1U || (held >= own && is_idle(client, now_us));
}

uint32_t gateway_place_for(const gateway_client_t clients[GATEWAY_MAX_CLIENTS], const gateway_address_t *address,
                           uint64_t now_us)
{
    const uint32_t own = places_of(clients, address);
    uint32_t chosen = GATEWAY_MAX_CLIENTS;
    uint32_t most = 0;
    for (uint32_t place = 0; place < GATEWAY_MAX_CLIENTS; place++) {
        const gateway_client_t *const client = &clients[place];
        const uint32_t held = places_of(clients, &client->address);
        if (client->stream.fd < 0) {
            return place;
        }
        const bool is_longer = held > most || (held == most && client->asked_us < clients[chosen].asked_us);
        if (is_longer && may_give_way(client, held, own, now_us)) {
            chosen = place;
            most = held;
        }
    }
    return chosen;
}

/* One client. */

void gateway_client_open(gateway_client_t *client, int fd, const gateway_address_t *address, uint64_t now_us)
{
    *client = (gateway_client_t){.stream = {.fd = fd}, .address = *address, .asked_us = now_us, .begun_us = now_us};
}

static bool has_room(const gateway_client_t *client)
{
    return GATEWAY_OUTPUT_BYTES - client->stream.out_count >= GATEWAY_MAX_ADU;
}

/* False: the connection is broken. */
static bool receive(gateway_client_t *client, uint64_t now_us)
{
    const size_t before = client->stream.in_count;
    const int got = client->has_ended ? 1 : gateway_stream_receive(&client->stream);
    client->has_ended = client->has_ended || got == 0;
    client->begun_us = (before == 0U && client->stream.in_count > 0U) ? now_us : client->begun_us;
    return got >= 0;
}

static void take_frame(gateway_client_t *client, gateway_t *gateway, gateway_frame_t frame, const uint8_t *bytes,
                       size_t size, uint64_t now_us)
{
    if (frame == GATEWAY_FRAME_PROTOCOL) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_WRONG_PROTOCOL]);
    } else if (frame == GATEWAY_FRAME_SHORT) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_WRONG_LENGTH]);
    } else {
        client->has_asked = true;
        client->asked_us = now_us;
        client->stream.out_count += gateway_answer(gateway, &client->stream.session, false, bytes, size, now_us,
                                                   &client->stream.out[client->stream.out_count]);
    }
}

/* All whole frames for whose answers there is room. False: what follows cannot be read. */
static bool take_frames(gateway_client_t *client, gateway_t *gateway, uint64_t now_us)
{
    size_t done = 0;
    gateway_frame_t frame = GATEWAY_FRAME_WHOLE;
    while (has_room(client)) {
        size_t size = 0;
        frame = gateway_tcp_frame(&client->stream.in[done], client->stream.in_count - done, &size);
        if (frame == GATEWAY_FRAME_PART || frame == GATEWAY_FRAME_LOST) {
            break;
        }
        take_frame(client, gateway, frame, &client->stream.in[done], size, now_us);
        done += size;
    }
    gateway_stream_drop(&client->stream, done);
    client->begun_us = (done > 0U) ? now_us : client->begun_us;
    if (frame == GATEWAY_FRAME_LOST) {
        tumble_count(&gateway->counters[GATEWAY_COUNT_WRONG_LENGTH]);
    }
    return frame != GATEWAY_FRAME_LOST;
}

bool gateway_client_step(gateway_client_t *client, gateway_t *gateway, uint64_t now_us)
{
    if (!gateway_stream_send(&client->stream)) {
        return false;
    }
    if (has_room(client) && !receive(client, now_us)) {
        return false;
    }
    bool is_readable = true;
    bool is_full = true; /* of answers: frames may wait that no event will tell of */
    while (is_full && is_readable && has_room(client)) {
        is_readable = take_frames(client, gateway, now_us);
        is_full = !has_room(client);
        if (!gateway_stream_send(&client->stream)) {
            return false;
        }
    }
    return is_readable && (!client->has_ended || client->stream.out_count > 0U);
}

uint32_t gateway_client_events(const gateway_client_t *client)
{
    const bool is_wanted = has_room(client) && !client->has_ended;
    return (is_wanted ? (uint32_t)EPOLLIN : 0U) | ((client->stream.out_count > 0U) ? (uint32_t)EPOLLOUT : 0U);
}

uint64_t gateway_client_deadline_us(const gateway_client_t *client, const gateway_settings_t *settings)
{
    const uint64_t first_us = (settings->idle_us < GATEWAY_FIRST_US) ? settings->idle_us : GATEWAY_FIRST_US;
    const uint64_t idle_us = client->asked_us + (client->has_asked ? settings->idle_us : first_us);
    const uint64_t part_us = client->begun_us + GATEWAY_PART_US;
    return (client->stream.in_count > 0U && part_us < idle_us) ? part_us : idle_us;
}

void gateway_client_close(gateway_client_t *client, gateway_t *gateway)
{
    gateway_session_close(&client->stream.session, gateway);
    (void)close(client->stream.fd);
    client->stream.fd = -1;
}
