/* The memory of a life: what it begins with, and what a loss of power leaves in it. */
#include "world/hostile.h"

#include "tumble/sets.h"

#include <string.h>

#define RELATIVE_U 1e-4

static void settle(tumble_store_t *store)
{
    while (tumble_store_step(store) == TUMBLE_E_PORT_BUSY) {
    }
}

/* An active set, true to this block, as an earlier calibration would have left it. */
static void write_set(bench_life_t *life)
{
    static tumble_store_t store;
    const bench_plan_t *const plan = life->plan;
    tumble_set_t set = {.estimator = (uint8_t)plan->config.procedure.estimate,
                        .flags = TUMBLE_SET_HAS_UNCERTAINTY,
                        .coefficients = life->world.truth.block};
    memcpy(set.block_serial, plan->config.keeping.serial, strlen(plan->config.keeping.serial));
    set.date_utc_s = (plan->utc_s != 0U) ? plan->utc_s - 86400U : 0U;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            set.uncertainty.k_v_per_g[i][j] = RELATIVE_U;
        }
        set.uncertainty.u0_v[i] = RELATIVE_U;
    }
    (void)tumble_store_init(&store, &life->nv.nv);
    settle(&store);
    (void)tumble_store_commit(&store, &set);
    settle(&store);
}

void bench_life_prepare_memory(bench_life_t *life)
{
    sim_nv_init(&life->nv, &life->world.clock);
    if (life->plan->has_set) {
        write_set(life);
    }
    life->nv.erase_us = life->plan->erase_us;
    life->nv.program_us = life->plan->program_us;
}

/* Each granule is as it was to be, or holds anything: half programmed bits, or nothing that makes sense. */
void bench_life_tear_memory(bench_life_t *life, sim_random_t *stream)
{
    sim_nv_t *const nv = &life->nv;
    if (nv->size == 0U || life->world.clock.now_us >= nv->until_us) {
        return;
    }
    const double share = sim_random_unit(stream);
    for (uint32_t i = 0; i < nv->size; i += SIM_NV_GRANULE) {
        if (!bench_chance(stream, share)) {
            continue;
        }
        const uint64_t garbage = sim_random_u64(stream);
        for (uint32_t b = 0; b < SIM_NV_GRANULE; b++) {
            nv->bytes[nv->offset + i + b] |= (uint8_t)(garbage >> 8 * b);
        }
        if (bench_chance(stream, 0.5)) {
            memcpy(&nv->bytes[nv->offset + i], &garbage, SIM_NV_GRANULE);
        }
    }
}

static uint64_t hash(const uint8_t *bytes, uint32_t size)
{
    uint64_t found = 14695981039346656037U; /* FNV-1a */
    for (uint32_t i = 0; i < size; i++) {
        found = (found ^ bytes[i]) * 1099511628211U;
    }
    return found;
}

bool bench_life_is_flipped(const bench_life_t *life, const bench_flipped_t *flipped)
{
    return hash(&life->nv.bytes[flipped->offset], flipped->size) == flipped->hash;
}

/* The set with its mark, or the entry of the history, that this byte belongs to: as it is before the flip. */
static void note_flip(bench_life_t *life, uint32_t first, uint32_t at)
{
    const uint32_t region = at / SIM_NV_SECTOR;
    const bool of_history = region == TUMBLE_REGION_HISTORY || region == TUMBLE_REGION_HISTORY + 1U;
    const bool of_set = region >= TUMBLE_REGION_SLOT_A && region <= TUMBLE_REGION_PROPOSAL;
    const uint32_t size = of_history ? TUMBLE_HISTORY_BYTES : TUMBLE_SET_PLACE_BYTES;
    const uint32_t offset = of_history ? at - at % size : region * SIM_NV_SECTOR;
    if (!of_history && !(of_set && at < offset + size)) {
        return;
    }
    bench_flipped_t flipped = {.offset = offset, .size = size, .sound = hash(&life->nv.bytes[offset], size)};
    for (uint32_t i = 0; i < life->flipped_count; i++) {
        if (life->flipped[i].offset == offset && i >= first) {
            return;
        }
        if (life->flipped[i].offset == offset && life->flipped[i].hash == flipped.sound) {
            flipped.sound = life->flipped[i].sound; /* nobody has written it since */
        }
    }
    if (life->flipped_count < BENCH_FLIPPED) {
        life->flipped[life->flipped_count++] = flipped;
    }
}

/* Their content from now on. What a second flip has put right is none. */
static void take_flipped(bench_life_t *life, uint32_t first)
{
    uint32_t kept = first;
    for (uint32_t i = first; i < life->flipped_count; i++) {
        bench_flipped_t flipped = life->flipped[i];
        flipped.hash = hash(&life->nv.bytes[flipped.offset], flipped.size);
        life->flipped[kept] = flipped;
        kept += (flipped.hash != flipped.sound) ? 1U : 0U;
    }
    life->flipped_count = kept;
}

/* Anywhere, or as often in a mark, which is small and decides. */
static uint32_t draw_place(sim_random_t *stream)
{
    const uint32_t region = TUMBLE_REGION_SLOT_A + bench_pick(stream, 3);
    return bench_chance(stream, 0.5) ? bench_pick(stream, SIM_NV_BYTES)
                                     : region * SIM_NV_SECTOR + TUMBLE_SET_BYTES + bench_pick(stream, 8);
}

/* Where something is written: an erased byte means nothing to anyone. */
void bench_life_flip_bits(bench_life_t *life, sim_random_t *stream, uint32_t count)
{
    const uint32_t first = life->flipped_count;
    for (uint32_t flipped = 0, tries = 0; flipped < count && tries < 20000U; tries++) {
        const uint32_t at = draw_place(stream);
        if (life->nv.bytes[at] != 0xFFU) {
            note_flip(life, first, at);
            life->nv.bytes[at] ^= (uint8_t)(1U << bench_pick(stream, 8));
            life->counts.flips++;
            flipped++;
        }
    }
    take_flipped(life, first);
}
