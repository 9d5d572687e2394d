#include "simulation/nv.h"

#include "nv/nv_rules.h"

#include <string.h>

static bool is_busy(const sim_nv_t *nv)
{
    return nv->size != 0U && nv->clock->now_us < nv->until_us;
}

/* The bytes change at the beginning: until the end nobody can read them. */
static tumble_status_t begin(sim_nv_t *nv, uint32_t offset, uint32_t size, uint32_t lasts_us)
{
    nv->offset = offset;
    nv->size = (lasts_us != 0U) ? size : 0U;
    nv->until_us = nv->clock->now_us + lasts_us;
    return (lasts_us != 0U) ? TUMBLE_E_PORT_BUSY : TUMBLE_OK;
}

/* Is it the call whose operation has just ended, made again? */
static bool has_ended(sim_nv_t *nv, uint32_t offset, uint32_t size)
{
    const bool same = nv->size == size && nv->offset == offset;
    nv->size = 0;
    return same;
}

static tumble_status_t erase(void *context, uint32_t offset)
{
    sim_nv_t *const nv = context;
    if (!nv_is_sector(&nv->nv, offset)) {
        return TUMBLE_E_NV;
    }
    if (is_busy(nv)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if (has_ended(nv, offset, SIM_NV_SECTOR) && nv_is_blank(&nv->bytes[offset], SIM_NV_SECTOR)) {
        return TUMBLE_OK;
    }
    memset(&nv->bytes[offset], NV_ERASED, SIM_NV_SECTOR);
    return begin(nv, offset, SIM_NV_SECTOR, nv->erase_us);
}

static tumble_status_t program(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    sim_nv_t *const nv = context;
    if (!nv_are_granules(&nv->nv, offset, size)) {
        return TUMBLE_E_NV;
    }
    if (is_busy(nv)) {
        return TUMBLE_E_PORT_BUSY;
    }
    if (has_ended(nv, offset, size) && memcmp(&nv->bytes[offset], bytes, size) == 0) {
        return TUMBLE_OK;
    }
    if (!nv_is_blank(&nv->bytes[offset], size)) {
        return TUMBLE_E_NV;
    }
    memcpy(&nv->bytes[offset], bytes, size);
    return begin(nv, offset, size, nv->program_us);
}

static tumble_status_t read(void *context, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    const sim_nv_t *const nv = context;
    if (!nv_are_there(&nv->nv, offset, size)) {
        return TUMBLE_E_NV;
    }
    if (is_busy(nv)) {
        return TUMBLE_E_PORT_BUSY;
    }
    memcpy(bytes, &nv->bytes[offset], size);
    return TUMBLE_OK;
}

void sim_nv_init(sim_nv_t *nv, const sim_clock_t *clock)
{
    *nv = (sim_nv_t){.nv = {.context = nv,
                            .size_bytes = SIM_NV_BYTES,
                            .sector_bytes = SIM_NV_SECTOR,
                            .granule_bytes = SIM_NV_GRANULE,
                            .erase = erase,
                            .program = program,
                            .read = read},
                     .clock = clock};
    memset(nv->bytes, NV_ERASED, sizeof nv->bytes);
}
