#include "store_power.h"

#include <stdio.h>

static nv_memory_t power_memory;
static uint8_t power_image[NV_MAX_BYTES];

static void power_bad(campaign_t *campaign, const char *what)
{
    if (campaign->bad == 0U) {
        const nv_fault_t *f = campaign->faults;
        (void)snprintf(campaign->first, sizeof campaign->first,
                       "%s: %s (granule %u, sector %u, faults %u/%d/%d %u/%d/%d)", campaign->scenario, what,
                       (unsigned)campaign->granule, (unsigned)campaign->sector, (unsigned)f[0].at, (int)f[0].done,
                       (int)f[0].then, (unsigned)f[1].at, (int)f[1].done, (int)f[1].then);
    }
    campaign->bad++;
}

/* What is seen now, and what is seen after power has been off: the same, where it was not lost just now. */
static state_t power_look(campaign_t *campaign, const scenario_t *scenario, state_t least)
{
    nv_memory_t *memory = &power_memory;
    state_t live = STATE_BAD;
    const bool was_on = !memory->is_off;
    if (was_on) {
        live = scenario->look();
    }
    nv_arm(memory, nv_no_fault);
    if (!scenario->boot(memory)) {
        power_bad(campaign, "start-up does not end");
        return STATE_BAD;
    }
    const state_t state = scenario->look();
    if (state == STATE_BAD) {
        power_bad(campaign, "a state that must never be found");
    } else if (was_on && live != state) {
        power_bad(campaign, "what is answered is not what power-on finds");
    } else if (state < least) {
        power_bad(campaign, "what was done is undone");
    } else if (memory->violations != 0U) {
        power_bad(campaign, "a call that the memory forbids");
    } else {
        return state;
    }
    return STATE_BAD;
}

/* Do the job with one fault armed. Returns the state, and in `hit` whether the fault came to pass. */
static state_t power_once(campaign_t *campaign, const scenario_t *scenario, nv_fault_t fault, state_t least, bool *hit)
{
    nv_memory_t *memory = &power_memory;
    nv_arm(memory, fault);
    tumble_status_t status = TUMBLE_E_STATE;
    if (!scenario->boot(memory)) {
        power_bad(campaign, "start-up does not end");
        return STATE_BAD;
    }
    const bool begun = !memory->is_off && (scenario->look() != STATE_AFTER);
    if (begun) {
        status = scenario->job();
    }
    const bool ended = begun && !memory->is_off;
    *hit = memory->operations > fault.at;
    const state_t state = power_look(campaign, scenario, least);
    if (ended && status == TUMBLE_OK && state != STATE_AFTER && state != STATE_BAD) {
        power_bad(campaign, "the job says that it is done, and it is not");
        return STATE_BAD;
    }
    return state;
}

static void power_case(campaign_t *campaign, const scenario_t *scenario, const nv_fault_t *second, bool hits[NV_FAULTS])
{
    nv_memory_t *memory = &power_memory;
    bool ignored;
    memcpy(memory->bytes, power_image, memory->nv.size_bytes);
    memory->violations = 0;
    memory->random = 12345U + (uint32_t)campaign->cases;
    campaign->cases++;
    state_t state = power_once(campaign, scenario, campaign->faults[0], STATE_BEFORE, &hits[0]);
    if (state != STATE_BAD && second != NULL) {
        state = power_once(campaign, scenario, *second, state, &hits[1]);
    }
    if (state != STATE_BAD && power_once(campaign, scenario, nv_no_fault, state, &ignored) != STATE_AFTER) {
        power_bad(campaign, "undisturbed, the job does not succeed");
    }
}

static void power_seconds(campaign_t *campaign, const scenario_t *scenario, const fault_list_t *list)
{
    bool hits[NV_FAULTS] = {true, true};
    nv_fault_t *second = &campaign->faults[1];
    for (second->at = 0; hits[1]; second->at++) {
        for (unsigned kind = 0; kind < list->done_count * (unsigned)THEN_KINDS; kind++) {
            second->done = list->done[kind / (unsigned)THEN_KINDS];
            second->then = (then_t)(kind % (unsigned)THEN_KINDS);
            power_case(campaign, scenario, second, hits);
        }
    }
}

void power_scenario(campaign_t *campaign, const scenario_t *scenario, const fault_list_t *list, bool twice)
{
    bool hits[NV_FAULTS] = {true, true};
    nv_fault_t *first = &campaign->faults[0];
    nv_make(&power_memory, campaign->sectors, campaign->granule, campaign->sector);
    scenario->prepare(&power_memory, &scenario->start);
    memcpy(power_image, power_memory.bytes, sizeof power_image);
    campaign->scenario = scenario->name;
    for (first->at = 0; hits[0] && campaign->bad == 0U; first->at++) {
        for (unsigned kind = 0; kind < list->done_count * (unsigned)THEN_KINDS; kind++) {
            first->done = list->done[kind / (unsigned)THEN_KINDS];
            first->then = (then_t)(kind % (unsigned)THEN_KINDS);
            campaign->faults[1] = nv_no_fault;
            power_case(campaign, scenario, NULL, hits);
            if (twice && hits[0]) {
                power_seconds(campaign, scenario, list);
            }
        }
    }
}
