/* The rules by which results are judged: are they the board's? */
#include "sets/parts.h"

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

uint32_t tumble_sets_rules(const tumble_sets_t *sets)
{
    return fingerprint(&sets->settings.limits, &sets->run->gravity_limit_g);
}

uint32_t tumble_sets_rules_of_board(const tumble_sets_t *sets)
{
    return fingerprint(&sets->config->settings->limits, &sets->run->board_gravity_limit_g);
}

bool tumble_sets_rules_are_other(const tumble_sets_t *sets)
{
    return tumble_sets_rules(sets) != sets->rules;
}

/* Saved rules count as the board's as soon as they are in force or have been written. */

void tumble_sets_save_rules(tumble_sets_t *sets, bool save)
{
    sets->rules_written = save ? tumble_sets_rules(sets) : tumble_sets_rules_of_board(sets);
}

void tumble_sets_rules_saved(tumble_sets_t *sets)
{
    sets->rules = sets->rules_written;
}

void tumble_sets_rules_applied(tumble_sets_t *sets)
{
    sets->rules = tumble_sets_rules(sets);
}

uint16_t tumble_sets_rules_flag(const tumble_sets_t *sets)
{
    const bool other = tumble_sets_rules_are_other(sets) || sets->run->serviced;
    return other ? TUMBLE_SET_OTHER_RULES : 0U;
}
