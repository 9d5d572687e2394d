/* The rules by which results are judged: are they the board's? */
#include "navcomp/keeper_internal.h"
#include "navcomp/navcomp_internal.h"

#include "core/crc32.h"

#include <assert.h>
#include <stddef.h>

#define NUMBERS_BYTES (offsetof(tumble_commit_limits_t, flags))

static_assert((offsetof(tumble_commit_limits_t, uncertainty) == 0U) &&
                  (NUMBERS_BYTES == (sizeof(float) * ((3U * TUMBLE_COEFFICIENTS) + 1U))),
              "the numbers of the limits are told by their bytes: nothing may lie between them");

/* Of all that the rules go by. Of this machine alone: it is never kept. */
static uint32_t fingerprint(const tumble_commit_limits_t *limits, const double *gravity_limit_g)
{
    uint32_t crc = tumble_crc32(0, (const uint8_t *)limits, (uint32_t)NUMBERS_BYTES);
    crc = tumble_crc32(crc, &limits->flags, 1U);
    return tumble_crc32(crc, (const uint8_t *)gravity_limit_g, (uint32_t)sizeof *gravity_limit_g);
}

uint32_t tumble_keeper_rules(const tumble_keeper_t *keeper)
{
    return fingerprint(&keeper->settings.limits, &keeper->navcomp->procedure_config.gravity_limit_g);
}

uint32_t tumble_keeper_rules_of_board(const tumble_keeper_t *keeper)
{
    return fingerprint(&keeper->config->settings->limits, &keeper->navcomp->config->procedure->gravity_limit_g);
}

bool tumble_keeper_rules_are_other(const tumble_keeper_t *keeper)
{
    return tumble_keeper_rules(keeper) != keeper->rules;
}

/* What was saved is the board's, too: from when it is in force, or has been written. */
void tumble_keeper_note_rules(tumble_keeper_t *keeper)
{
    const uint8_t event = keeper->parameters.event;
    keeper->parameters.event = TUMBLE_PARAMETERS_NOTHING;
    if (event == (uint8_t)TUMBLE_PARAMETERS_APPLIED) {
        keeper->rules = tumble_keeper_rules(keeper);
    } else if (event == (uint8_t)TUMBLE_PARAMETERS_WRITTEN) {
        keeper->rules = keeper->rules_written;
    } else {
        /* they are what they were */
    }
}

uint16_t tumble_keeper_rules_flag(const tumble_keeper_t *keeper)
{
    const bool other = tumble_keeper_rules_are_other(keeper) || tumble_service_is_open(keeper->navcomp);
    return other ? TUMBLE_SET_OTHER_RULES : 0U;
}

/* The proposal that was named, if it is there still. */
tumble_status_t tumble_keeper_accept(tumble_keeper_t *keeper)
{
    return (tumble_store_proposal(&keeper->store) == keeper->accepted)
               ? tumble_store_accept_as(&keeper->store, tumble_keeper_rules_flag(keeper))
               : TUMBLE_E_STATE;
}
