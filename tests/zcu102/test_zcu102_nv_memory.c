/* The stand-in for the board's flash: conformance, and what it takes for its own. */
#include "conformance_print.h"
#include "nv_memory.h"
#include "suite.h"

#include <string.h>

static uint8_t memory[ZCU102_NV_BYTES];
static tumble_nv_t nv;
static uint32_t passed;
static uint32_t skips;

static void keep(void *context, const char *check, conformance_verdict_t verdict, const char *why)
{
    conformance_print(context, check, verdict, why);
    passed += (verdict == CONFORMANCE_PASSED) ? 1U : 0U;
    skips += (verdict == CONFORMANCE_SKIPPED) ? 1U : 0U;
}

static const tumble_nv_t *reopen(void *context)
{
    (void)context;
    nv = zcu102_nv_memory(memory);
    return &nv;
}

static void set_up(void)
{
    memset(memory, 0, sizeof memory);
    (void)reopen(NULL);
}

static void test_it_conforms(void)
{
    const tumble_port_t port = {.nv = &nv};
    const conformance_bench_t bench = {.a = &port, .reopen = reopen, .report = keep};
    TEST_ASSERT_EQUAL_UINT32(0, conformance_run_nv(&bench));
    TEST_ASSERT_EQUAL_UINT32(9, passed);
    TEST_ASSERT_EQUAL_UINT32(1, skips); /* it ends at once */
}

static void test_memory_that_nobody_has_written_is_erased(void)
{
    TEST_ASSERT_EACH_EQUAL_HEX8(0xFF, memory, sizeof memory);
}

static void test_memory_that_was_loaded_is_kept(void)
{
    static const size_t PLACES[] = {0, 1, 4095, 40000, sizeof memory - 1U};
    for (size_t i = 0; i < sizeof PLACES / sizeof PLACES[0]; i++) {
        memset(memory, 0, sizeof memory);
        memory[PLACES[i]] = 1;
        (void)reopen(NULL);
        TEST_ASSERT_EQUAL_HEX8(1, memory[PLACES[i]]);
        TEST_ASSERT_EQUAL_HEX8(0, memory[(PLACES[i] + 1U) % sizeof memory]);
    }
}
