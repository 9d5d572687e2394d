/* gateway_log.h - the events of tumble-gateway (event_log.h): clients, what they command, the node as its snapshots show
 * it. Everything is seen from outside, by what has changed since it was looked at last. */
#ifndef TUMBLE_GATEWAY_GATEWAY_LOG_H
#define TUMBLE_GATEWAY_GATEWAY_LOG_H

#include "client.h"
#include "run_log.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t snapshot; /* its number */
    uint8_t link;
    tumble_progress_t progress;
    bool has_progress; /* of the node, since the gateway began */
    run_log_sets_t sets;
} gateway_log_t;

/* A client has come, or goes: `why`. */
void gateway_log_connected(const gateway_address_t *address, uint16_t clients);
void gateway_log_disconnected(const gateway_address_t *address, const char *why, uint16_t clients);

/* No place for a client. */
void gateway_log_turned_away(const gateway_address_t *address);

/* The session of somebody may have written, or have got its result: before it is another's turn. */
void gateway_log_session(gateway_stream_t *stream, const char *who, uint64_t now_us);

/* The poller has been stepped. */
void gateway_log_node(gateway_log_t *log, const gateway_poller_t *poller);

#endif
