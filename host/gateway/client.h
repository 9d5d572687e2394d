/* client.h - one TCP connection: bytes in, answers out, nothing ever waited for. */
#ifndef TUMBLE_GATEWAY_CLIENT_H
#define TUMBLE_GATEWAY_CLIENT_H

#include "answer.h"

#define GATEWAY_INPUT_BYTES (2U * GATEWAY_MAX_ADU)
#define GATEWAY_OUTPUT_BYTES (8U * GATEWAY_MAX_ADU) /* who does not take its answers is not listened to meanwhile */

/* A client that has never asked anything, and one that has begun a request, must end a request within these. */
#define GATEWAY_FIRST_US 10000000U
#define GATEWAY_PART_US 5000000U

/* Who somebody is: the IPv6 address, or the mapped one of IPv4. */
typedef struct {
    uint8_t bytes[16];
} gateway_address_t;

typedef struct {
    int fd; /* -1: this place is free */
    gateway_address_t address;
    bool has_asked;
    bool has_ended;    /* it sends no more; what it has asked is answered */
    uint64_t asked_us; /* when it came, or the last whole frame did */
    uint64_t begun_us; /* when the first byte of a frame came that is not whole */
    size_t in_count;
    size_t out_count;
    uint8_t in[GATEWAY_INPUT_BYTES];
    uint8_t out[GATEWAY_OUTPUT_BYTES];
    gateway_session_t session;
} gateway_client_t;

void gateway_client_open(gateway_client_t *client, int fd, const gateway_address_t *address, uint64_t now_us);

/* Take what has come, answer, send what goes. False: it is to be closed. */
bool gateway_client_step(gateway_client_t *client, gateway_t *gateway, const gateway_replies_t *replies,
                         uint64_t now_us);

/* EPOLL... bits to wait for. */
uint32_t gateway_client_events(const gateway_client_t *client);

/* When it will have been silent for too long. */
uint64_t gateway_client_deadline_us(const gateway_client_t *client, const gateway_settings_t *settings);

void gateway_client_close(gateway_client_t *client, gateway_t *gateway);

#endif
