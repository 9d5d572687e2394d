#include "conformance.h"

#include "finding.h"

#include <string.h>

#define ERASED 0xFFU
#define WAITS 1000U         /* an operation is waited for so many times a thousandth of what an erase may take ... */
#define PATIENCE 4U         /* ... and so many times that */
#define MOST_READ 256U      /* at one time */
#define NEVER_WRITTEN 0xEEU /* what a buffer holds that a read has not filled */

typedef enum { ERASE, PROGRAM, READ } operation_t;

static tumble_status_t once(const tumble_nv_t *nv, operation_t operation, uint32_t offset, uint8_t *bytes,
                            uint32_t size)
{
    switch (operation) {
    case ERASE:
        return nv->erase(nv->context, offset);
    case PROGRAM:
        return nv->program(nv->context, offset, bytes, size);
    default:
        return nv->read(nv->context, offset, bytes, size);
    }
}

/* The same call until it has an answer; `*busy`, unless null, counts how often it had none. */
static tumble_status_t patiently(const conformance_bench_t *bench, operation_t operation, uint32_t offset,
                                 uint8_t *bytes, uint32_t size, uint32_t *busy)
{
    const uint32_t pause_us = (bench->erase_us / WAITS) + 1U;
    tumble_status_t status = TUMBLE_E_PORT_BUSY;
    for (uint32_t waits = 0; waits < (PATIENCE * WAITS); waits++) {
        status = once(bench->a->nv, operation, offset, bytes, size);
        if (status != TUMBLE_E_PORT_BUSY) {
            return status;
        }
        if (busy != NULL) {
            (*busy)++;
        }
        bench->pass(bench->context, pause_us);
    }
    return status;
}

static const char *erase(const conformance_bench_t *bench, uint32_t offset)
{
    return (patiently(bench, ERASE, offset, NULL, 0, NULL) == TUMBLE_OK) ? NULL : "an erase does not end with OK";
}

/* Bytes that differ from place to place, and from series to series; no granule of them is blank. */
static uint8_t byte_of(uint32_t series, uint32_t offset)
{
    return (uint8_t)((offset * 7U) ^ (offset >> 8U) ^ (series * 0x55U)) & (((offset & 1U) == 0U) ? 0x7FU : 0xFFU);
}

static const char *program(const conformance_bench_t *bench, uint32_t series, uint32_t offset)
{
    uint8_t bytes[TUMBLE_NV_MAX_GRANULE];
    const uint32_t size = bench->a->nv->granule_bytes;
    for (uint32_t i = 0; i < size; i++) {
        bytes[i] = byte_of(series, offset + i);
    }
    const tumble_status_t status = patiently(bench, PROGRAM, offset, bytes, size, NULL);
    return (status == TUMBLE_OK) ? NULL : "programming an erased granule does not end with OK";
}

static const char *fill(const conformance_bench_t *bench, uint32_t series, uint32_t sector)
{
    const tumble_nv_t *nv = bench->a->nv;
    const char *fault = erase(bench, sector);
    for (uint32_t at = 0; (fault == NULL) && (at < nv->sector_bytes); at += nv->granule_bytes) {
        fault = program(bench, series, sector + at);
    }
    return fault;
}

/* Does the memory hold there what was programmed (series 0: what an erase leaves)? */
static const char *expect(const conformance_bench_t *bench, uint32_t series, uint32_t offset, uint32_t size)
{
    uint8_t bytes[MOST_READ];
    for (uint32_t done = 0; done < size;) {
        const uint32_t part = ((size - done) < MOST_READ) ? (size - done) : MOST_READ;
        (void)memset(bytes, (int)NEVER_WRITTEN, sizeof bytes);
        if (patiently(bench, READ, offset + done, bytes, part, NULL) != TUMBLE_OK) {
            return "a read does not end with OK";
        }
        for (uint32_t i = 0; i < part; i++) {
            const uint8_t wanted = (series == 0U) ? (uint8_t)ERASED : byte_of(series, offset + done + i);
            if (bytes[i] != wanted) {
                return (series == 0U) ? "an erased byte is not FFh" : "a byte is not what was programmed there";
            }
        }
        done += part;
    }
    return NULL;
}

static const char *expect_sector(const conformance_bench_t *bench, uint32_t series, uint32_t sector)
{
    return expect(bench, series, sector, bench->a->nv->sector_bytes);
}

/* The checks. `last`: the last sector. */

static uint32_t last_sector(const tumble_nv_t *nv)
{
    return nv->size_bytes - nv->sector_bytes;
}

static finding_t geometry_makes_sense(const conformance_bench_t *bench)
{
    const tumble_nv_t *nv = bench->a->nv;
    const uint32_t granule = nv->granule_bytes;
    if ((granule == 0U) || (granule > TUMBLE_NV_MAX_GRANULE) || ((granule & (granule - 1U)) != 0U)) {
        return wrong("a granule is not 1 to 32 bytes, a power of two");
    }
    if ((nv->sector_bytes == 0U) || ((nv->sector_bytes % granule) != 0U)) {
        return wrong("a sector is not made of whole granules");
    }
    if (((nv->size_bytes % nv->sector_bytes) != 0U) || (nv->size_bytes < (2U * nv->sector_bytes))) {
        return wrong("the memory is not made of whole sectors, two or more");
    }
    return GOOD;
}

/* Three sectors are full, the one in the middle is erased. */
static finding_t erase_is_of_one_sector(const conformance_bench_t *bench)
{
    const tumble_nv_t *nv = bench->a->nv;
    const uint32_t sectors = ((3U * nv->sector_bytes) <= nv->size_bytes) ? 3U : 2U;
    const char *fault = NULL;
    for (uint32_t i = 0; (fault == NULL) && (i < sectors); i++) {
        fault = fill(bench, 1U + i, i * nv->sector_bytes);
    }
    fault = (fault != NULL) ? fault : erase(bench, nv->sector_bytes);
    fault = (fault != NULL) ? fault : expect_sector(bench, 0, nv->sector_bytes);
    for (uint32_t i = 0; (fault == NULL) && (i < sectors); i += 2U) {
        fault = (expect_sector(bench, 1U + i, i * nv->sector_bytes) == NULL) ? NULL : "an erase changes another sector";
    }
    return wrong(fault);
}

/* Every granule by itself; before its turn it is erased, after it what was programmed. */
static finding_t every_granule(const conformance_bench_t *bench)
{
    const tumble_nv_t *nv = bench->a->nv;
    const uint32_t last = last_sector(nv);
    const char *fault = erase(bench, last);
    for (uint32_t at = last; (fault == NULL) && (at < nv->size_bytes); at += nv->granule_bytes) {
        fault = expect(bench, 0, at, nv->granule_bytes);
        fault = (fault != NULL) ? fault : program(bench, 4, at);
        fault = (fault != NULL) ? fault : expect(bench, 4, at, nv->granule_bytes);
    }
    return wrong((fault != NULL) ? fault : expect_sector(bench, 4, last));
}

static finding_t programming_changes_nothing_else(const conformance_bench_t *bench)
{
    const tumble_nv_t *nv = bench->a->nv;
    const uint32_t granule = nv->granule_bytes;
    const uint32_t middle = nv->sector_bytes + (((nv->sector_bytes / granule) / 2U) * granule);
    const char *fault = fill(bench, 5, 0);
    fault = (fault != NULL) ? fault : erase(bench, nv->sector_bytes);
    fault = (fault != NULL) ? fault : program(bench, 6, nv->sector_bytes);
    fault = (fault != NULL) ? fault : program(bench, 6, middle);
    fault = (fault != NULL) ? fault : expect(bench, 6, nv->sector_bytes, granule);
    fault = (fault != NULL) ? fault : expect(bench, 6, middle, granule);
    const char *other = expect_sector(bench, 5, 0);
    const uint32_t first_end = nv->sector_bytes + granule;
    other = (other != NULL) ? other : expect(bench, 0, first_end, middle - first_end);
    other = (other != NULL) ? other : expect(bench, 0, middle + granule, (2U * nv->sector_bytes) - middle - granule);
    return wrong(((fault == NULL) && (other != NULL)) ? "programming changes bytes that it was not given" : fault);
}

/* Several granules in one call, up to a whole sector. */
static finding_t long_programming(const conformance_bench_t *bench)
{
    uint8_t bytes[MOST_READ];
    const tumble_nv_t *nv = bench->a->nv;
    const uint32_t size = (nv->sector_bytes < MOST_READ) ? nv->sector_bytes : (MOST_READ - nv->granule_bytes);
    const uint32_t at = nv->sector_bytes - size; /* to the sector's end */
    for (uint32_t i = 0; i < size; i++) {
        bytes[i] = byte_of(7, at + i);
    }
    const char *fault = erase(bench, 0);
    if ((fault == NULL) && (patiently(bench, PROGRAM, at, bytes, size, NULL) != TUMBLE_OK)) {
        fault = "programming several granules does not end with OK";
    }
    fault = (fault != NULL) ? fault : expect(bench, 7, at, size);
    return wrong((fault != NULL) ? fault : expect(bench, 0, 0, at));
}

static finding_t any_bytes_can_be_read(const conformance_bench_t *bench)
{
    static const uint32_t SIZES[] = {1, 2, 3, 5, 31, 33, 100};
    const tumble_nv_t *nv = bench->a->nv;
    const char *fault = fill(bench, 8, 0);
    fault = (fault != NULL) ? fault : fill(bench, 8, nv->sector_bytes);
    for (uint32_t i = 0; (fault == NULL) && (i < (sizeof SIZES / sizeof SIZES[0])); i++) {
        for (uint32_t before = 0; (fault == NULL) && (before <= SIZES[i]); before++) { /* across two sectors */
            fault = expect(bench, 8, nv->sector_bytes - before, SIZES[i]);
        }
    }
    return wrong(fault);
}

static finding_t a_granule_is_programmed_once(const conformance_bench_t *bench)
{
    uint8_t other[TUMBLE_NV_MAX_GRANULE];
    const char *fault = erase(bench, 0);
    fault = (fault != NULL) ? fault : program(bench, 9, 0);
    for (uint32_t i = 0; i < sizeof other; i++) {
        other[i] = (uint8_t)(byte_of(9, i) ^ 0x3CU);
    }
    const tumble_status_t status = patiently(bench, PROGRAM, 0, other, bench->a->nv->granule_bytes, NULL);
    fault = (fault != NULL) ? fault : expect(bench, 9, 0, bench->a->nv->granule_bytes);
    fault = (fault != NULL) ? fault : ((status == TUMBLE_E_NV) ? NULL : "a granule can be programmed twice");
    fault = (fault != NULL) ? fault : erase(bench, 0);
    return wrong((fault != NULL) ? fault : program(bench, 9, 0)); /* after an erase it can again */
}

typedef struct {
    operation_t operation;
    uint32_t offset;
    uint32_t size;
} place_t;

/* Places that the memory does not have, or not for this operation. */
static finding_t other_places_are_refused(const conformance_bench_t *bench)
{
    uint8_t bytes[2U * TUMBLE_NV_MAX_GRANULE] = {0};
    const tumble_nv_t *nv = bench->a->nv;
    const uint32_t size = nv->size_bytes;
    const uint32_t sector = nv->sector_bytes;
    const uint32_t granule = nv->granule_bytes;
    const place_t places[] = {
        {ERASE, size, 0},
        {ERASE, UINT32_MAX, 0},
        {ERASE, 0U - sector, 0},
        {ERASE, sector / 2U, 0},
        {ERASE, sector - 1U, 0},
        {PROGRAM, size, granule},
        {PROGRAM, 0U - granule, granule},
        {PROGRAM, size - granule, 2U * granule},
        {PROGRAM, sector - granule, 2U * granule}, /* of two sectors */
        {PROGRAM, sector, granule - 1U},
        {READ, size, 1},
        {READ, size - 1U, 2},
        {READ, UINT32_MAX, 2},
        {PROGRAM, sector, granule + 1U}, /* from here on: not where a granule is a byte */
        {PROGRAM, sector + 1U, granule},
    };
    const uint32_t count = (sizeof places / sizeof places[0]) - ((granule == 1U) ? 2U : 0U);
    const char *fault = fill(bench, 10, 0);
    fault = (fault != NULL) ? fault : erase(bench, sector);
    fault = (fault != NULL) ? fault : erase(bench, last_sector(nv));
    for (uint32_t i = 0; (fault == NULL) && (i < count); i++) {
        const place_t *place = &places[i];
        if (patiently(bench, place->operation, place->offset, bytes, place->size, NULL) != TUMBLE_E_NV) {
            fault = "a place that there is not, or not for this, is not refused";
        }
    }
    fault = (fault != NULL) ? fault : expect_sector(bench, 10, 0);
    fault = (fault != NULL) ? fault : expect_sector(bench, 0, sector);
    return wrong((fault != NULL) ? fault : expect_sector(bench, 0, last_sector(nv)));
}

/* While an erase is under way nothing else is done, and asking again does not begin it anew. */
static finding_t busy_is_told_until_the_end(const conformance_bench_t *bench)
{
    uint8_t byte = 0;
    uint32_t busy = 0;
    const tumble_nv_t *nv = bench->a->nv;
    const char *fault = fill(bench, 11, 0);
    const tumble_status_t begun = nv->erase(nv->context, 0);
    if ((fault == NULL) && (begun == TUMBLE_OK)) {
        return skipped("an operation ends at once here");
    }
    if ((fault == NULL) && (begun != TUMBLE_E_PORT_BUSY)) {
        fault = "an erase gives neither OK nor BUSY";
    }
    const tumble_status_t meanwhile = nv->read(nv->context, 0, &byte, 1);
    if (patiently(bench, ERASE, 0, NULL, 0, &busy) != TUMBLE_OK) {
        fault = (fault != NULL) ? fault : "the memory stays BUSY";
    }
    if ((fault == NULL) && (busy > 0U) && (meanwhile != TUMBLE_E_PORT_BUSY)) {
        fault = "while it is busy, it can be read";
    }
    fault = (fault != NULL) ? fault : expect_sector(bench, 0, 0);
    return wrong((fault != NULL) ? fault : program(bench, 11, 0));
}

static finding_t it_outlives_power(const conformance_bench_t *bench)
{
    conformance_bench_t again = *bench;
    tumble_port_t port = *bench->a;
    if (bench->reopen == NULL) {
        return skipped("the memory cannot be opened anew here");
    }
    const char *fault = fill(bench, 12, 0);
    fault = (fault != NULL) ? fault : erase(bench, bench->a->nv->sector_bytes);
    fault = (fault != NULL) ? fault : program(bench, 13, bench->a->nv->sector_bytes);
    port.nv = bench->reopen(bench->context);
    if (port.nv == NULL) {
        return wrong("the memory is not there again");
    }
    again.a = &port;
    fault = (fault != NULL) ? fault : expect_sector(&again, 12, 0);
    fault = (fault != NULL) ? fault : expect(&again, 13, port.nv->sector_bytes, port.nv->granule_bytes);
    const uint32_t behind = port.nv->sector_bytes + port.nv->granule_bytes;
    return wrong((fault != NULL) ? fault : expect(&again, 0, behind, port.nv->sector_bytes - port.nv->granule_bytes));
}

#define GEOMETRY "nv: the geometry makes sense"

static const check_t CHECKS[] = {
    {"nv: an erase gives FFh, in its sector alone", erase_is_of_one_sector},
    {"nv: every granule is programmed and read back", every_granule},
    {"nv: programming changes nothing else", programming_changes_nothing_else},
    {"nv: several granules at one time", long_programming},
    {"nv: any bytes can be read", any_bytes_can_be_read},
    {"nv: a granule is programmed once", a_granule_is_programmed_once},
    {"nv: other places are refused", other_places_are_refused},
    {"nv: BUSY until the end", busy_is_told_until_the_end},
    {"nv: it outlives power", it_outlives_power},
};

/* Where the geometry makes no sense the other checks would go astray. */
uint32_t conformance_run_nv(const conformance_bench_t *bench)
{
    const finding_t lacking = skipped("the board has no such memory");
    const bool there = bench->a->nv != NULL;
    if (report_finding(bench, GEOMETRY, there ? geometry_makes_sense(bench) : lacking)) {
        return 1;
    }
    uint32_t failed = 0;
    for (size_t i = 0; i < (sizeof CHECKS / sizeof CHECKS[0]); i++) {
        const finding_t finding = there ? CHECKS[i].check(bench) : lacking;
        failed += report_finding(bench, CHECKS[i].name, finding) ? 1U : 0U;
    }
    return failed;
}
