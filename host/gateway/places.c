#include "places.h"

#include <string.h>

#define NONE GATEWAY_MAX_CLIENTS

static bool is_same(const gateway_address_t *one, const gateway_address_t *other)
{
    return memcmp(one->bytes, other->bytes, sizeof one->bytes) == 0;
}

static uint32_t places_of(const gateway_client_t *clients, const gateway_address_t *address)
{
    uint32_t count = 0;
    for (uint32_t place = 0; place < GATEWAY_MAX_CLIENTS; place++) {
        count += (clients[place].fd >= 0 && is_same(&clients[place].address, address)) ? 1U : 0U;
    }
    return count;
}

/* Nothing begun, no answer owed, and no request of late. */
static bool is_idle(const gateway_client_t *client, uint64_t now_us)
{
    const bool is_calm = !client->has_asked || now_us - client->asked_us >= GATEWAY_CALM_US;
    return client->in_count == 0U && client->out_count == 0U && is_calm;
}

static uint32_t free_place(const gateway_client_t *clients)
{
    uint32_t place = 0;
    while (place < GATEWAY_MAX_CLIENTS && clients[place].fd >= 0) {
        place++;
    }
    return place;
}

/* It gives way to an address that would still hold fewer places than its own; to one that holds as many, if it is idle. */
static bool may_give_way(const gateway_client_t *client, uint32_t held, uint32_t own, uint64_t now_us)
{
    return held > own + 1U || (held >= own && is_idle(client, now_us));
}

/* Of those whose address holds most, the client that has been silent for longest. */
static uint32_t place_to_take(const gateway_client_t *clients, const gateway_address_t *address, uint64_t now_us)
{
    const uint32_t own = places_of(clients, address);
    uint32_t chosen = NONE;
    uint32_t most = 0;
    for (uint32_t place = 0; place < GATEWAY_MAX_CLIENTS; place++) {
        const gateway_client_t *const client = &clients[place];
        const uint32_t held = places_of(clients, &client->address);
        const bool is_longer = held > most || (held == most && client->asked_us < clients[chosen].asked_us);
        if (is_longer && may_give_way(client, held, own, now_us)) {
            chosen = place;
            most = held;
        }
    }
    return chosen;
}

uint32_t gateway_place_for(const gateway_client_t clients[GATEWAY_MAX_CLIENTS], const gateway_address_t *address,
                           uint64_t now_us)
{
    const uint32_t place = free_place(clients);
    return (place != NONE) ? place : place_to_take(clients, address, now_us);
}
