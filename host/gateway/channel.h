/* channel.h - which SDO server of the node the gateway uses: the second one (1201h), so that the first one is left to
 * others. After silence it tries the other one, for a node may have the first one alone; when that answers, it is asked
 * once whether there is a second. Pure functions on the poller's client. */
#ifndef TUMBLE_GATEWAY_CHANNEL_H
#define TUMBLE_GATEWAY_CHANNEL_H

#include "canopen/sdo.h"

#include <stdbool.h>

typedef struct {
    bool has_looked; /* since it uses the first server, for a second */
} gateway_channel_t;

void gateway_channel_init(gateway_channel_t *channel, tumble_sdo_client_t *client);

/* The server that is used did not answer. */
void gateway_channel_silent(gateway_channel_t *channel, tumble_sdo_client_t *client);

/* It has answered. True: it is to be asked for a second one, and a read has begun whose end `gateway_channel_found` is to
 * be told. */
bool gateway_channel_look(gateway_channel_t *channel, tumble_sdo_client_t *client, uint8_t node);
void gateway_channel_found(tumble_sdo_client_t *client);

/* The last transfer was aborted for its own sake, not that of the object: somebody else uses the same server. */
bool gateway_channel_is_disturbed(const tumble_sdo_client_t *client);

#endif
