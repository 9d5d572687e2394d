/* canopen_client.h - the fixture's SDO client at work, and what its tests expect of it. */
#ifndef TUMBLE_TESTS_CANOPEN_CLIENT_H
#define TUMBLE_TESTS_CANOPEN_CLIENT_H

#include "canopen_fixture.h"

static tumble_sdo_client_t *const client = &at.node.client;

static inline tumble_status_t result(void)
{
    return tumble_sdo_client_result(client);
}

static inline void expect_request(const char *text)
{
    expect_next(0x602, text);
    expect_nothing();
}

/* What the client asks next, and the server's answer. */
static inline void serve(const char *request, const char *answer)
{
    expect_request(request);
    give(0x582, answer);
}

static inline void expect_end(tumble_status_t status, uint32_t abort)
{
    expect_no_next();
    TEST_ASSERT_EQUAL_STRING(tumble_status_name(status), tumble_status_name(result()));
    TEST_ASSERT_EQUAL_HEX32(abort, client->abort);
}

#endif
