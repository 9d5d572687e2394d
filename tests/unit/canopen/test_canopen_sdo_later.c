/* A write whose answer comes later: confirmed or refused when the owner says so, and not at all when the client has
 * moved on meanwhile. */
#include "canopen_fixture.h"

static unsigned begun;

static tumble_abort_t write_later(void *context, const tumble_entry_t *entry, const uint8_t *bytes, uint8_t size)
{
    (void)context;
    (void)entry;
    (void)bytes;
    (void)size;
    begun++;
    return TUMBLE_ABORT_LATER;
}

static const tumble_object_hooks_t later = {.read = fixture_read, .write = write_later};

static void set_up(void)
{
    begun = 0;
    TEST_ASSERT_EQUAL_INT(TUMBLE_OK, fixture_start(&fixture_quiet));
    boot();
    at.node.dictionary.application.hooks = &later;
}

static void answer(tumble_abort_t refusal)
{
    tumble_sdo_server_answer(&at.node.server, refusal);
    step();
}

#define BEGIN() give(0x605, "23 10 20 00 73 61 76 65")

static void test_it_is_confirmed_when_it_is_done(void)
{
    BEGIN();
    expect_nothing();
    pass(60 * 1000 * MS); /* however long it takes */
    expect_nothing();
    TEST_ASSERT_EQUAL_UINT64(TUMBLE_NEVER, tumble_sdo_server_next_us(&at.node.server));
    answer(TUMBLE_ABORT_NONE);
    expect(0x585, "60 10 20 00 00 00 00 00");
    TEST_ASSERT_EQUAL_UINT(1, begun);
    ask("40 10 20 00 00 00 00 00", "43 10 20 00 00 00 00 00");
}

static void test_it_is_refused_when_it_failed(void)
{
    BEGIN();
    answer(TUMBLE_ABORT_HARDWARE);
    expect(0x585, "80 10 20 00 00 00 06 06");
    answer(TUMBLE_ABORT_NONE); /* it is over */
    expect_nothing();
}

static void test_it_goes_for_the_last_segment_too(void)
{
    ask("21 10 20 00 04 00 00 00", "60 10 20 00 00 00 00 00");
    give(0x605, "07 01 02 03 04 00 00 00");
    expect_nothing();
    answer(TUMBLE_ABORT_NONE);
    expect(0x585, "20 00 00 00 00 00 00 00");
}

static void test_nobody_is_answered_who_gave_up(void)
{
    BEGIN();
    give(0x605, "80 10 20 00 00 00 04 05");
    answer(TUMBLE_ABORT_NONE);
    expect_nothing();
    BEGIN();
    give(0x605, "40 05 20 00 00 00 00 00"); /* asks for something else */
    expect(0x585, "4B 05 20 00 00 00 00 00");
    answer(TUMBLE_ABORT_HARDWARE);
    expect_nothing();
    TEST_ASSERT_EQUAL_UINT16(2, at.node.server.aborted);
}

static void test_a_segment_meanwhile_ends_it(void)
{
    BEGIN();
    trade(0x605, "60 00 00 00 00 00 00 00", 0x585, "80 10 20 00 01 00 04 05");
    answer(TUMBLE_ABORT_NONE);
    expect_nothing();
}

static void test_a_reset_forgets_it(void)
{
    BEGIN();
    trade(0x000, "82 05", 0x705, "00");
    answer(TUMBLE_ABORT_NONE);
    expect_nothing();
}

static const around_t around_each = {set_up, fixture_end};
