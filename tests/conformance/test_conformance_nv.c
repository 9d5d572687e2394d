/* The suite finds every way in which a non-volatile memory can lie. */
#include "conformance_print.h"
#include "inprocess.h"
#include "suite.h"

#include <string.h>

static inprocess_t inprocess;
static conformance_bench_t bench;
static tumble_port_t port;
static tumble_nv_t lying;
static uint32_t calls;
static uint32_t skips;
static char failed[600]; /* names of the checks that failed, each behind a comma */

static void keep(void *context, const char *check, conformance_verdict_t verdict, const char *why)
{
    conformance_print(context, check, verdict, why);
    skips += (verdict == CONFORMANCE_SKIPPED) ? 1U : 0U;
    if (verdict == CONFORMANCE_FAILED) {
        (void)strncat(failed, ",", sizeof failed - strlen(failed) - 1U);
        (void)strncat(failed, check, sizeof failed - strlen(failed) - 1U);
    }
}

static void set_up(void)
{
    memset(failed, 0, sizeof failed);
    calls = 0;
    skips = 0;
    inprocess_init(&inprocess);
    bench = inprocess_bench(&inprocess);
    bench.report = keep;
    lying = inprocess.nv.nv;
    port = *bench.a;
    port.nv = &lying;
    bench.a = &port;
}

/* An honest memory, and what it does. */

static tumble_status_t erase(uint32_t offset)
{
    return inprocess.nv.nv.erase(&inprocess.nv, offset);
}

static tumble_status_t program(uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    return inprocess.nv.nv.program(&inprocess.nv, offset, bytes, size);
}

static tumble_status_t read(uint32_t offset, uint8_t *bytes, uint32_t size)
{
    return inprocess.nv.nv.read(&inprocess.nv, offset, bytes, size);
}

/* Defects. */

static tumble_status_t erases_nothing(void *context, uint32_t offset)
{
    (void)context;
    return (offset < SIM_NV_BYTES && offset % SIM_NV_SECTOR == 0U) ? TUMBLE_OK : TUMBLE_E_NV;
}

static tumble_status_t erases_to_zero(void *context, uint32_t offset)
{
    const tumble_status_t status = erase(offset);
    (void)context;
    if (status == TUMBLE_OK) {
        memset(&inprocess.nv.bytes[offset], 0, SIM_NV_SECTOR);
    }
    return status;
}

static tumble_status_t erases_half(void *context, uint32_t offset)
{
    static uint8_t half[SIM_NV_SECTOR / 2U];
    (void)context;
    if (offset < SIM_NV_BYTES) {
        memcpy(half, &inprocess.nv.bytes[offset / SIM_NV_SECTOR * SIM_NV_SECTOR + sizeof half], sizeof half);
    }
    const tumble_status_t status = erase(offset);
    if (status != TUMBLE_E_NV) {
        memcpy(&inprocess.nv.bytes[offset + sizeof half], half, sizeof half);
    }
    return status;
}

static tumble_status_t erases_the_next_one_too(void *context, uint32_t offset)
{
    const tumble_status_t status = erase(offset);
    (void)context;
    if (status == TUMBLE_OK && offset + SIM_NV_SECTOR < SIM_NV_BYTES) {
        memset(&inprocess.nv.bytes[offset + SIM_NV_SECTOR], 0xFF, SIM_NV_SECTOR);
    }
    return status;
}

static tumble_status_t erases_from_anywhere(void *context, uint32_t offset)
{
    (void)context;
    return erase(offset / SIM_NV_SECTOR * SIM_NV_SECTOR);
}

static tumble_status_t erases_beyond_the_end(void *context, uint32_t offset)
{
    (void)context;
    return erase(offset % SIM_NV_BYTES);
}

static tumble_status_t never_ends(void *context, uint32_t offset)
{
    (void)context;
    (void)offset;
    return TUMBLE_E_PORT_BUSY;
}

static tumble_status_t begins_anew_when_asked(void *context, uint32_t offset)
{
    (void)context;
    inprocess.nv.size = 0;
    return erase(offset);
}

static tumble_status_t programs_nothing(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    uint8_t blank[SIM_NV_SECTOR];
    (void)context;
    (void)bytes;
    memset(blank, 0xFF, sizeof blank);
    return program(offset, blank, size);
}

static tumble_status_t forgets_the_last_granule(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    (void)context;
    return program(offset, bytes, (size > SIM_NV_GRANULE) ? size - SIM_NV_GRANULE : size);
}

static tumble_status_t spills_over(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    const tumble_status_t status = program(offset, bytes, size);
    (void)context;
    if (status == TUMBLE_OK && offset + size < SIM_NV_BYTES) {
        inprocess.nv.bytes[offset + size] &= 0xFEU;
    }
    return status;
}

static tumble_status_t spills_into_the_first_sector(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    const tumble_status_t status = program(offset, bytes, size);
    (void)context;
    if (status == TUMBLE_OK && offset == SIM_NV_SECTOR) {
        inprocess.nv.bytes[0] = 0;
    }
    return status;
}

/* As flash without error correction does it. */
static tumble_status_t programs_over_it(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    const tumble_status_t status = program(offset, bytes, size);
    (void)context;
    for (uint32_t i = 0; status == TUMBLE_E_NV && offset < SIM_NV_BYTES && size == SIM_NV_GRANULE && i < size; i++) {
        inprocess.nv.bytes[offset + i] &= bytes[i];
    }
    return status;
}

static tumble_status_t programs_twice(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    const tumble_status_t status = program(offset, bytes, size);
    (void)context;
    const bool again =
        status == TUMBLE_E_NV && offset % SIM_NV_SECTOR == 0U && offset < SIM_NV_BYTES && size == SIM_NV_GRANULE;
    return again ? TUMBLE_OK : status;
}

static tumble_status_t programs_any_size(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    (void)context;
    return program(offset, bytes, (size + SIM_NV_GRANULE - 1U) / SIM_NV_GRANULE * SIM_NV_GRANULE);
}

static tumble_status_t programs_across_sectors(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    (void)context;
    const uint32_t left = SIM_NV_SECTOR - offset % SIM_NV_SECTOR;
    return program(offset, bytes, (size > left) ? left : size);
}

static tumble_status_t refuses_the_last_granule(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    (void)context;
    return (offset + size == SIM_NV_BYTES) ? TUMBLE_E_NV : program(offset, bytes, size);
}

static tumble_status_t reads_whole_words(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    (void)context;
    return read(offset / 4U * 4U, bytes, size);
}

static tumble_status_t reads_beyond_the_end(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    (void)context;
    return (offset >= SIM_NV_BYTES || offset + size > SIM_NV_BYTES) ? TUMBLE_OK : read(offset, bytes, size);
}

static tumble_status_t reads_while_busy(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    const tumble_status_t status = read(offset, bytes, size);
    (void)context;
    return (status == TUMBLE_E_PORT_BUSY) ? TUMBLE_OK : status;
}

static tumble_status_t reads_a_wrong_bit(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    const tumble_status_t status = read(offset, bytes, size);
    (void)context;
    if (status == TUMBLE_OK && offset <= 5000U && offset + size > 5000U) {
        bytes[5000U - offset] ^= 4U;
    }
    return status;
}

static const tumble_nv_t *forgets(void *context)
{
    const tumble_nv_t *nv = inprocess_reopen(context);
    memset(inprocess.nv.bytes, 0xFF, sizeof inprocess.nv.bytes);
    return nv;
}

static const tumble_nv_t *is_gone(void *context)
{
    (void)context;
    return NULL;
}

#define ERASE "nv: an erase gives FFh, in its sector alone"
#define EVERY "nv: every granule is programmed and read back"
#define ELSE "nv: programming changes nothing else"
#define LONG "nv: several granules at one time"
#define ANY "nv: any bytes can be read"
#define ONCE "nv: a granule is programmed once"
#define OTHER "nv: other places are refused"
#define BUSY "nv: BUSY until the end"
#define POWER "nv: it outlives power"
#define GEOMETRY "nv: the geometry makes sense"

typedef struct {
    const char *defect;
    tumble_nv_t nv; /* what is null or 0 is honest */
    const tumble_nv_t *(*reopen)(void *context);
    const char *finds; /* the check that must fail, whatever else does */
} canary_t;

static const canary_t CANARIES[] = {
    {"erases nothing", {.erase = erases_nothing}, NULL, ERASE},
    {"erases to zero", {.erase = erases_to_zero}, NULL, ERASE},
    {"erases half", {.erase = erases_half}, NULL, ERASE},
    {"erases two", {.erase = erases_the_next_one_too}, NULL, ERASE},
    {"erases from anywhere", {.erase = erases_from_anywhere}, NULL, OTHER},
    {"erases beyond the end", {.erase = erases_beyond_the_end}, NULL, OTHER},
    {"never ends", {.erase = never_ends}, NULL, ERASE},
    {"begins anew when asked", {.erase = begins_anew_when_asked}, NULL, BUSY},
    {"programs nothing", {.program = programs_nothing}, NULL, EVERY},
    {"forgets the last granule", {.program = forgets_the_last_granule}, NULL, LONG},
    {"spills over", {.program = spills_over}, NULL, EVERY},
    {"spills into another sector", {.program = spills_into_the_first_sector}, NULL, ELSE},
    {"programs over it", {.program = programs_over_it}, NULL, ONCE},
    {"programs twice", {.program = programs_twice}, NULL, ONCE},
    {"programs any size", {.program = programs_any_size}, NULL, OTHER},
    {"programs across sectors", {.program = programs_across_sectors}, NULL, OTHER},
    {"refuses the last granule", {.program = refuses_the_last_granule}, NULL, EVERY},
    {"reads whole words", {.read = reads_whole_words}, NULL, ANY},
    {"reads beyond the end", {.read = reads_beyond_the_end}, NULL, OTHER},
    {"reads while busy", {.read = reads_while_busy}, NULL, BUSY},
    {"reads a wrong bit", {.read = reads_a_wrong_bit}, NULL, ERASE},
    {"forgets", {0}, forgets, POWER},
    {"is gone", {0}, is_gone, POWER},
    {"granules of three bytes", {.granule_bytes = 3}, NULL, GEOMETRY},
    {"granules too large", {.granule_bytes = 64}, NULL, GEOMETRY},
    {"sectors of half a granule more", {.sector_bytes = SIM_NV_SECTOR + 4U}, NULL, GEOMETRY},
    {"one sector", {.size_bytes = SIM_NV_SECTOR}, NULL, GEOMETRY},
    {"half a sector more", {.size_bytes = SIM_NV_BYTES + 8U}, NULL, GEOMETRY},
};

static void plant(const canary_t *canary)
{
    const tumble_nv_t *nv = &canary->nv;
    lying.erase = (nv->erase != NULL) ? nv->erase : lying.erase;
    lying.program = (nv->program != NULL) ? nv->program : lying.program;
    lying.read = (nv->read != NULL) ? nv->read : lying.read;
    lying.granule_bytes = (nv->granule_bytes != 0U) ? nv->granule_bytes : lying.granule_bytes;
    lying.sector_bytes = (nv->sector_bytes != 0U) ? nv->sector_bytes : lying.sector_bytes;
    lying.size_bytes = (nv->size_bytes != 0U) ? nv->size_bytes : lying.size_bytes;
    bench.reopen = (canary->reopen != NULL) ? canary->reopen : bench.reopen;
}

static void test_every_defect_is_found(void)
{
    for (size_t i = 0; i < (sizeof CANARIES / sizeof CANARIES[0]); i++) {
        set_up();
        plant(&CANARIES[i]);
        (void)printf("-- %s\n", CANARIES[i].defect);
        TEST_ASSERT_TRUE_MESSAGE(conformance_run_nv(&bench) > 0U, CANARIES[i].defect);
        TEST_ASSERT_NOT_NULL_MESSAGE(strstr(failed, CANARIES[i].finds), CANARIES[i].defect);
    }
}

static void test_a_board_without_such_a_memory_is_skipped_not_passed(void)
{
    port.nv = NULL;
    TEST_ASSERT_EQUAL_UINT32(0, conformance_run_nv(&bench));
    TEST_ASSERT_EQUAL_UINT32(10, skips);
}

/* Every byte a granule of its own, as memories have it that need no erase. */
static void test_granules_of_a_byte(void)
{
    lying.granule_bytes = 1;
    inprocess.nv.nv.granule_bytes = 1;
    bench.reopen = NULL;
    TEST_ASSERT_EQUAL_UINT32(0, conformance_run_nv(&bench));
    TEST_ASSERT_EQUAL_UINT32(1, skips);
}
