/* What all parts of the life need. */
#include "sets/parts.h"

#include "core/one_copy.h"

/* A shift of 64 bits is six instructions on 32. */
TUMBLE_ONE_COPY uint64_t tumble_sets_bit(uint8_t position)
{
    return UINT64_C(1) << position;
}

void tumble_sets_forget_margins(tumble_sets_t *sets)
{
    sets->checkpoint.margins = (tumble_margins_t){UINT8_MAX, UINT8_MAX};
}

void tumble_sets_fail(tumble_sets_t *sets, tumble_status_t status)
{
    sets->status = (uint8_t)status;
    tumble_count(&sets->counters.failures);
}

bool tumble_sets_memory_busy(const tumble_sets_t *sets)
{
    return tumble_store_busy(&sets->store) || tumble_history_busy(&sets->history) ||
           tumble_checkpoint_busy(&sets->checkpoint);
}

bool tumble_sets_busy(const tumble_sets_t *sets)
{
    return tumble_sets_memory_busy(sets) || sets->run->memory_taken;
}

bool tumble_sets_has_work(const tumble_sets_t *sets)
{
    return tumble_sets_busy(sets) || sets->stale || (sets->task != (uint8_t)TASK_NONE) || (sets->wants != 0U);
}

TUMBLE_ONE_COPY bool tumble_sets_computes(const tumble_sets_t *sets)
{
    return (sets->task == (uint8_t)TASK_WHOLE_MODEL) && !tumble_sets_busy(sets);
}

void tumble_sets_begin_job(tumble_sets_t *sets, uint8_t job, tumble_status_t status)
{
    if (status == TUMBLE_OK) {
        sets->job = job;
        sets->verdict = TUMBLE_VERDICT_WORKING;
    } else {
        sets->verdict = TUMBLE_VERDICT_FAILED;
        tumble_sets_fail(sets, status);
    }
}
