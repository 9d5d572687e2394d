/* Who stands at the bench: he mounts the block and confirms, mends faults, and goes on after a loss of power. */
#include "world/hostile_state.h"

#include "world/fault_script.h"
#include "world/person.h"

#define US_PER_S 1e6

void bench_life_attend_to(bench_life_t *life, const tumble_progress_t *progress)
{
    const bench_attendant_t *const attendant = &life->plan->attendant;
    double after_s = -1.0;
    if (progress->state == TUMBLE_STATE_WAIT_MOUNTING) {
        after_s = attendant->mount_s;
    } else if (progress->state == TUMBLE_STATE_FAULT && life->mended < attendant->mends) {
        after_s = attendant->mend_s;
    }
    life->attend_us = (after_s >= 0.0) ? life->world.clock.now_us + (uint64_t)(after_s * US_PER_S) : SIM_NEVER;
}

static void lay(bench_life_t *life, uint8_t number)
{
    if (life->lies != number) {
        life->lies = number;
        bench_world_mount(&life->world, (uint8_t)(number - 1U));
    }
}

static void mount(bench_life_t *life, uint8_t asked)
{
    const bool errs = life->plan->attendant.errs && !life->erred && asked == 2U;
    life->erred = life->erred || errs;
    lay(life, errs ? 1U : asked);
    (void)bench_life_command(life, TUMBLE_COMMAND_CONFIRM_MOUNTING, asked);
}

static void mend(bench_life_t *life, const tumble_progress_t *progress)
{
    life->mended++;
    bench_fault_script_mend(&life->world);
    if (bench_person_must_mount(progress->reason)) {
        mount(life, progress->mounting);
    } else {
        (void)bench_life_command(life, TUMBLE_COMMAND_RESUME, 0);
    }
}

/* After a loss of power a run that was on goes on, or begins anew. */
static void go_on(bench_life_t *life)
{
    tumble_sets_state_t state;
    tumble_sets_state(&life->keeper.sets, &state);
    const bool resumes = life->plan->attendant.resumes && state.resumable > 0U;
    life->run_was_on = false;
    (void)bench_life_command(life, resumes ? TUMBLE_COMMAND_RESUME : TUMBLE_COMMAND_START, 0);
}

void bench_life_attend(bench_life_t *life)
{
    const tumble_progress_t progress = life->world.progress;
    life->attend_us = SIM_NEVER;
    if (life->world.off) {
        return;
    }
    if (progress.state == TUMBLE_STATE_WAIT_MOUNTING) {
        mount(life, progress.mounting);
        bench_life_attend_to(life, &progress); /* again, should it be refused */
    } else if (progress.state == TUMBLE_STATE_FAULT) {
        mend(life, &progress);
    } else if (progress.state == TUMBLE_STATE_IDLE && life->run_was_on) {
        go_on(life);
    }
}
