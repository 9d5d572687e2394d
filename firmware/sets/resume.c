/* How a run that lost power goes on. */
#include "sets/parts.h"

#include <stddef.h>

uint32_t tumble_sets_fingerprint(const tumble_sets_t *sets)
{
    return sets->owner->fingerprint(sets->owner->self, tumble_store_sequence(&sets->store));
}

uint8_t tumble_sets_positions(const tumble_sets_t *sets)
{
    return sets->run->schedule->position_count;
}

static bool is_fit(const tumble_sets_t *sets, uint8_t index)
{
    return tumble_checkpoint_has(&sets->checkpoint, index) && ((sets->unfit & tumble_sets_bit(index)) == 0U);
}

/* One that is about to be cleared holds none. */
void tumble_sets_count_resumable(tumble_sets_t *sets)
{
    const bool idle = sets->run->idle && ((sets->wants & WANT_CLEAR) == 0U);
    sets->resumable = 0;
    if (idle && tumble_checkpoint_matches(&sets->checkpoint, tumble_sets_fingerprint(sets))) {
        for (uint8_t p = 0; p < tumble_sets_positions(sets); p++) {
            sets->resumable = (uint8_t)(sets->resumable + (is_fit(sets, p) ? 1U : 0U));
        }
    }
}

static tumble_status_t refuse(tumble_sets_t *sets)
{
    tumble_count(&sets->counters.not_resumed);
    return TUMBLE_E_STATE;
}

tumble_status_t tumble_sets_resume(tumble_sets_t *sets)
{
    if ((sets->task != (uint8_t)TASK_NONE) || sets->stale || tumble_sets_busy(sets)) {
        return refuse(sets);
    }
    sets->unfit = 0; /* a command tries all of them again */
    tumble_sets_count_resumable(sets);
    if (sets->resumable == 0U) {
        return refuse(sets);
    }
    sets->fingerprint = tumble_sets_fingerprint(sets);
    sets->saved = 0;
    sets->lost = 0;
    tumble_sets_forget_margins(sets); /* each mean brings its own along */
    sets->task = TASK_RESTORE;
    sets->at = 0;
    return TUMBLE_OK;
}

void tumble_sets_run_goes_on(tumble_sets_t *sets, bool done)
{
    if (!done) {
        (void)refuse(sets);
        tumble_sets_count_resumable(sets); /* for what cannot be put back nothing waits */
        return;
    }
    tumble_count(&sets->counters.resumed);
    sets->has_checkpoint = true;
    sets->run_was_on = true;
    sets->run_resumed = true;
    sets->warmth_half_c = 0;
    sets->warm_samples = 0;
    sets->resumable = 0;
}

/* All kept means have been put back. Only the configuration can have changed since the command: check it again. */
static void end_restoring(tumble_sets_t *sets, tumble_sets_event_t *event)
{
    sets->task = TASK_NONE;
    if ((sets->fingerprint == tumble_sets_fingerprint(sets)) && !tumble_sets_is_inhibited(sets)) {
        event->wish = TUMBLE_SETS_RESUME;
    } else {
        tumble_sets_run_goes_on(sets, false);
    }
}

void tumble_sets_restored(tumble_sets_t *sets, uint8_t index, bool done)
{
    uint64_t *const means = done ? &sets->saved : &sets->unfit;
    *means |= tumble_sets_bit(index);
}

void tumble_sets_restore(tumble_sets_t *sets, tumble_sets_event_t *event)
{
    while ((sets->at < tumble_sets_positions(sets)) && !tumble_checkpoint_has(&sets->checkpoint, sets->at)) {
        sets->at++;
    }
    if (sets->at == tumble_sets_positions(sets)) {
        end_restoring(sets, event);
        return;
    }
    const tumble_status_t status = tumble_checkpoint_read(&sets->checkpoint, sets->at, &event->mean);
    if (status == TUMBLE_E_PORT_BUSY) {
        return;
    }
    if (status == TUMBLE_OK) {
        event->wish = TUMBLE_SETS_RESTORE;
        event->index = sets->at;
    } else {
        tumble_sets_restored(sets, sets->at, false);
    }
    sets->at++;
}
