#include "channel.h"

#define SECOND_SERVER 0x1201U
#define REQUESTS 1U           /* its subindex: their identifier */
#define PROTOCOL_ERRORS 0x05U /* first byte of their abort codes */

void gateway_channel_init(gateway_channel_t *channel, tumble_sdo_client_t *client)
{
    channel->has_looked = false;
    client->below = TUMBLE_SDO_TO_SECOND;
}

void gateway_channel_silent(gateway_channel_t *channel, tumble_sdo_client_t *client)
{
    channel->has_looked = false;
    client->below = (client->below == TUMBLE_SDO_TO_FIRST) ? TUMBLE_SDO_TO_SECOND : TUMBLE_SDO_TO_FIRST;
}

bool gateway_channel_look(gateway_channel_t *channel, tumble_sdo_client_t *client, uint8_t node)
{
    const bool looks = client->below == TUMBLE_SDO_TO_FIRST && !channel->has_looked;
    if (looks) {
        channel->has_looked = true;
        (void)tumble_sdo_client_read(client, node, SECOND_SERVER, REQUESTS);
    }
    return looks;
}

bool gateway_channel_is_disturbed(const tumble_sdo_client_t *client)
{
    return client->result == TUMBLE_E_SDO_ABORTED && (client->abort >> 24) == PROTOCOL_ERRORS;
}

/* Of a server that is not there the identifier is marked as invalid. */
void gateway_channel_found(tumble_sdo_client_t *client)
{
    if (tumble_sdo_client_u32(client) == TUMBLE_SDO_SECOND_REQUEST_ID + client->node) {
        client->below = TUMBLE_SDO_TO_SECOND;
    }
}
