#define _GNU_SOURCE /* accept4 */

#include "listener.h"

#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define BACKLOG 64
#define HOST_BYTES 128
#define PORT_BYTES 16

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
    gateway_address_t address = {.bytes = {[10] = 0xFF, [11] = 0xFF}};
    if (from->ss_family == AF_INET6) {
        memcpy(address.bytes, &((const struct sockaddr_in6 *)from)->sin6_addr, sizeof address.bytes);
    } else {
        memcpy(&address.bytes[12], &((const struct sockaddr_in *)from)->sin_addr, 4);
    }
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
