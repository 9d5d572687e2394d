/* client.h - clients on TCP: where they come to, who gets a place, and each one's bytes in and answers out (the latter as
 * on the serial line). Nothing is ever waited for. */
#ifndef TUMBLE_GATEWAY_CLIENT_H
#define TUMBLE_GATEWAY_CLIENT_H

#include "request.h"

#include <netinet/in.h>
#include <stddef.h>

#define GATEWAY_INPUT_BYTES (2U * GATEWAY_MAX_ADU)
#define GATEWAY_OUTPUT_BYTES (8U * GATEWAY_MAX_ADU) /* who does not take its answers is not listened to meanwhile */

/* A client that has never asked anything, and one that has begun a request, must end a request within these. */
#define GATEWAY_FIRST_US 10000000U
#define GATEWAY_PART_US 5000000U

/* Who somebody is: the IPv6 address, or the mapped one of IPv4; and the same for people. */
typedef struct {
    struct in6_addr ip;
    char text[INET6_ADDRSTRLEN];
} gateway_address_t;

/* Of a session what was logged last. */
typedef struct {
    uint32_t refusals;
    uint16_t executed;
    uint8_t result;
    bool is_unlocked;
} gateway_told_t;

/* A session at the end of a connection, or of the serial line. */
typedef struct {
    int fd;           /* that does not block; -1: none */
    uint32_t watched; /* EPOLL... bits that are waited for; 0: epoll does not know it yet */
    size_t in_count;
    size_t out_count;
    uint8_t in[GATEWAY_INPUT_BYTES];
    uint8_t out[GATEWAY_OUTPUT_BYTES];
    gateway_session_t session;
    gateway_told_t told;
} gateway_stream_t;

/* Take what has come, as far as there is room. 0: the other end sends no more (or, on a serial line, nothing has come);
 * negative: it is broken. */
int gateway_stream_receive(gateway_stream_t *stream);

/* Forget the first bytes that have come. */
void gateway_stream_drop(gateway_stream_t *stream, size_t size);

/* Send what goes. False: it is broken. */
bool gateway_stream_send(gateway_stream_t *stream);

typedef struct {
    gateway_stream_t stream; /* without a descriptor: this place is free */
    gateway_address_t address;
    bool has_asked;
    bool has_ended;    /* it sends no more; what it has asked is answered */
    uint64_t asked_us; /* when it came, or the last whole frame did */
    uint64_t begun_us; /* when the first byte of a frame came that is not whole */
} gateway_client_t;

/* Where they come to. */

/* Listen at a host (name or address) and port ("0": any free one). Returns the descriptor, or -1 with `what` saying
 * why. */
int gateway_listen(const char *host, const char *port, const char **what);

/* Where it listens, as HOST:PORT. */
void gateway_listener_name(int listener, char *name, size_t size);

/* The next client, ready for use, and who it is; -1: there is none. Then `is_short` says whether that is for want of
 * something that the system does not have now, such as descriptors: errno says of what. Clients still wait then, and
 * the listener stays readable. */
int gateway_accept(int listener, gateway_address_t *address, bool *is_short);

/* Who gets a place. */

/* Who has asked something is left alone for so long, whether or not it asks more: it may poll once a second. */
#define GATEWAY_CALM_US 2000000U

/* The place that a newcomer from `address` gets: a free one; else that of the client that has been silent for longest,
 * of those whose address holds most. An address that holds two places more than the newcomer's gives one up even when
 * all its clients are busy, so that 32 clients of one address lock out nobody else; to others only an idle client gives
 * way, and nobody to an address that holds more than its own. GATEWAY_MAX_CLIENTS: there is none. */
uint32_t gateway_place_for(const gateway_client_t clients[GATEWAY_MAX_CLIENTS], const gateway_address_t *address,
                           uint64_t now_us);

/* One client. */

void gateway_client_open(gateway_client_t *client, int fd, const gateway_address_t *address, uint64_t now_us);

/* Take what has come, answer, send what goes. False: it is to be closed. */
bool gateway_client_step(gateway_client_t *client, gateway_t *gateway, uint64_t now_us);

/* EPOLL... bits to wait for. */
uint32_t gateway_client_events(const gateway_client_t *client);

/* When it will have been silent for too long. */
uint64_t gateway_client_deadline_us(const gateway_client_t *client, const gateway_settings_t *settings);

void gateway_client_close(gateway_client_t *client, gateway_t *gateway);

#endif
