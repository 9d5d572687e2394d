#include "world/hostile.h"

#include "core/bytes.h"

#include <string.h>

#define COMMAND_OBJECT 0x2002U
#define FIRST_SERVER 0x601U
#define SECOND_SERVER 0x401U
#define BLOCK_XY 0x683U
#define BLOCK_Z 0x693U
#define ABORT_WAS_REFUSED 0x08000022U

/* What the world tells. */

static bool is_reached(const bench_life_t *life, const bench_moment_t *moment)
{
    const bool in_state = moment->states == 0U || (moment->states >> life->watch.state & 1U) != 0U;
    return in_state && (!moment->writing || life->nv.size != 0U);
}

static bool has_condition(const bench_moment_t *moment)
{
    return moment->states != 0U || moment->writing;
}

static void find_next(bench_life_t *life)
{
    life->next_us = SIM_NEVER;
    for (uint32_t i = 0; i < life->plan->count; i++) {
        life->next_us = (life->due_us[i] < life->next_us) ? life->due_us[i] : life->next_us;
    }
}

/* Events that wait for a state, or for the memory to be at work, may come now. */
static void look_at_waiting(bench_life_t *life)
{
    for (uint32_t i = 0; i < life->plan->count; i++) {
        const bench_moment_t *const moment = &life->plan->events[i].moment;
        if (life->waits[i] && is_reached(life, moment)) {
            life->waits[i] = false;
            life->waiting_for_writing -= moment->writing ? 1U : 0U;
            life->due_us[i] = life->world.clock.now_us + moment->delay_us;
        }
    }
    find_next(life);
}

static void on_change(void *context, const tumble_progress_t *progress)
{
    bench_life_t *const life = context;
    bench_watch_change(life, progress);
    bench_watch_means(life);
    bench_life_attend_to(life, progress);
    look_at_waiting(life);
    if (progress->state == TUMBLE_STATE_DONE) {
        bench_watch_read_all(life);
    }
}

static bool is_write(const tumble_can_frame_t *frame, uint16_t index, uint8_t subindex)
{
    return frame->length == 8U && (frame->data[0] & 0xE0U) == 0x20U && frame->data[1] == (index & 0xFFU) &&
           frame->data[2] == index >> 8 && frame->data[3] == subindex;
}

static void on_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    bench_watch_sample(context, taken, sample);
}

/* The computer answers a write: taken, or why not. */
static void note_answer(bench_life_t *life, const tumble_can_frame_t *frame)
{
    const uint16_t index = (uint16_t)(frame->data[1] | frame->data[2] << 8);
    const bool taken = frame->data[0] == 0x60U;
    const uint32_t code =
        (uint32_t)(frame->data[4] | frame->data[5] << 8 | frame->data[6] << 16) | (uint32_t)frame->data[7] << 24;
    if (index == COMMAND_OBJECT && frame->data[3] == 2U && life->abort_asked) {
        life->abort_asked = false;
        if (taken || (frame->data[0] == 0x80U && code == ABORT_WAS_REFUSED)) {
            bench_watch_ended(life);
        }
    }
    if (index == COMMAND_OBJECT && frame->data[3] == 2U && frame->data[0] == 0x80U) {
        bench_watch_decide(life, life->command_asked, true);
    }
    if (taken) {
        bench_watch_written(life, index, frame->data[3]);
    }
    if (taken && (index == 0x2050U || (index >= 0x2122U && index <= 0x2126U))) {
        bench_watch_excuse(life, BENCH_EXCUSE_RULES);
    }
}

/* As it is delivered: whatever a fault has made of it. */
static void on_frame(void *context, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    bench_life_t *const life = context;
    (void)time_us;
    if (frame->id == FIRST_SERVER || frame->id == SECOND_SERVER) {
        bench_watch_request(life, frame);
    } else if (frame->id == BLOCK_XY || frame->id == BLOCK_Z) {
        bench_watch_block_frame(life, frame);
    } else if (frame->id == 0U && frame->length == 2U && (frame->data[0] == 0x81U || frame->data[0] == 0x82U) &&
               frame->data[1] <= 1U) {
        life->watch.level_until_us = 0; /* reset */
    }
    if (frame->id == FIRST_SERVER && sender != BENCH_BUS_NAVCOMP && is_write(frame, COMMAND_OBJECT, 2)) {
        life->command_asked = (tumble_command_t)frame->data[4];
        life->abort_asked = frame->data[4] == TUMBLE_COMMAND_ABORT;
        bench_watch_decide(life, life->command_asked, false);
        if (!life->abort_asked) {
            bench_watch_commanded(life);
        }
    } else if (sender == BENCH_BUS_NAVCOMP && (frame->id == 0x581U || frame->id == 0x381U) && frame->length == 8U) {
        note_answer(life, frame);
    } else if (sender == BENCH_BUS_NAVCOMP && frame->id == 0x081U && frame->length == 8U &&
               tumble_get_u16(frame->data) == TUMBLE_KEEPER_EMCY_DECAYED) {
        life->watch.told = true;
    }
}

/* The course. */

static void send_followers(bench_life_t *life)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < life->queued; i++) {
        if (life->queue[i].due_us <= life->world.clock.now_us) {
            (void)sim_bus_send(&life->world.bus, BENCH_BUS_GUEST, &life->queue[i].frame);
        } else {
            life->queue[kept++] = life->queue[i];
        }
    }
    life->queued = kept;
}

/* Its time has come: it happens, or begins to wait for what it waits for. */
static void act_on_due(bench_life_t *life)
{
    for (uint32_t i = 0; i < life->plan->count; i++) {
        const bench_event_t *const event = &life->plan->events[i];
        if (life->due_us[i] > life->world.clock.now_us) {
            continue;
        }
        life->due_us[i] = SIM_NEVER;
        if (has_condition(&event->moment) && !life->waited[i]) {
            life->waited[i] = true;
            life->waits[i] = true;
            life->waiting_for_writing += event->moment.writing ? 1U : 0U;
        } else {
            bench_life_act(life, event);
        }
    }
    look_at_waiting(life);
}

static uint64_t earliest(const bench_life_t *life)
{
    uint64_t first_us = (life->attend_us < life->next_us) ? life->attend_us : life->next_us;
    first_us = (life->power_us < first_us) ? life->power_us : first_us;
    for (uint32_t i = 0; i < life->queued; i++) {
        first_us = (life->queue[i].due_us < first_us) ? life->queue[i].due_us : first_us;
    }
    return first_us;
}

static void act(bench_life_t *life)
{
    const uint64_t now_us = life->world.clock.now_us;
    if (life->power_us <= now_us) {
        bench_life_power_on(life);
    }
    if (life->attend_us <= now_us) {
        bench_life_attend(life);
    }
    send_followers(life);
    if (life->next_us <= now_us) {
        act_on_due(life);
    }
}

/* Faults that have come to pass, for what they excuse, as long as they are in force. */
static void note_faults(bench_life_t *life)
{
    for (uint32_t i = 0; i < life->plan->config.scenario.fault_count; i++) {
        if (life->world.script.states[i].in_force) {
            bench_life_excuse_fault(life, &life->plan->config.scenario.faults[i]);
        }
    }
}

/* False: the life is over. */
static bool advance(bench_life_t *life)
{
    bench_world_t *const world = &life->world;
    const uint64_t mine_us = earliest(life);
    const uint64_t worlds_us = bench_world_next_us(world);
    if (mine_us > life->plan->lasts_us && worlds_us > life->plan->lasts_us) {
        return false;
    }
    if (mine_us <= worlds_us) {
        bench_world_pass(world, mine_us);
        act(life);
    } else if (!bench_world_advance(world)) {
        return false;
    }
    if (life->waiting_for_writing > 0U && life->nv.size != 0U) {
        look_at_waiting(life);
    }
    note_faults(life);
    bench_watch_look(life);
    return life->watch.violation.kind == BENCH_HOLDS;
}

/* The faults of the plan are the scenario's. */
static void take_faults(bench_plan_t *plan)
{
    sim_scenario_t *const scenario = &plan->config.scenario;
    scenario->fault_count = 0;
    for (uint32_t i = 0; i < plan->count && scenario->fault_count < SIM_MAX_FAULTS; i++) {
        if (plan->events[i].kind == BENCH_HOSTILE_FAULT) {
            scenario->faults[scenario->fault_count++] = plan->events[i].fault;
        }
    }
}

static void begin(bench_life_t *life, bench_plan_t *plan)
{
    memset(life, 0, sizeof *life);
    take_faults(plan);
    life->plan = plan;
    life->lies = 1;
    life->attend_us = SIM_NEVER;
    life->power_us = SIM_NEVER;
    for (uint32_t i = 0; i < plan->count; i++) {
        const bool is_fault = plan->events[i].kind == BENCH_HOSTILE_FAULT; /* its script has it */
        life->due_us[i] = is_fault ? SIM_NEVER : plan->events[i].moment.at_us;
    }
    find_next(life);
    bench_watch_init(life);
    life->watcher =
        (bench_watcher_t){.context = life, .on_change = on_change, .on_sample = on_sample, .on_frame = on_frame};
}

static void compose(bench_life_t *life)
{
    const bench_config_t *const config = &life->plan->config;
    bench_world_t *const world = &life->world;
    life->keeper_config = (tumble_keeper_config_t){
        .sets = {.serial = config->keeping.serial, .settings = &config->keeping.settings},
        .uncertainty = tumble_navcomp_uncertainty,
        .norm = tumble_navcomp_norm,
        .stand_view = tumble_stand_view,
        .stand_memory = &life->stand_memory,
    };
    bench_life_prepare_memory(life);
    life->watch.has_set = life->plan->has_set;
    life->watch.counter = life->plan->has_set ? 1U : 0U;
    world->port.nv = &life->nv.nv;
    world->navcomp_config.keeping = &tumble_keeper_calls;
    world->navcomp_config.keeper = &life->keeper;
    bench_life_boot(life);
}

/* What came to pass of the faults; and what there was at the end. */
static void sum_up(bench_life_t *life)
{
    for (uint32_t i = 0; i < life->plan->config.scenario.fault_count; i++) {
        const uint32_t times = life->world.script.states[i].times;
        life->counts.faults[life->plan->config.scenario.faults[i].kind] += times;
        life->counts.events[BENCH_HOSTILE_FAULT] += times;
    }
    if (!life->world.off) {
        life->counts.held += tumble_sets_counters(&life->keeper.sets)->held;
        bench_watch_read_all(life);
    }
}

void bench_life_run(bench_life_t *life, bench_plan_t *plan)
{
    begin(life, plan);
    if (bench_world_init(&life->world, &plan->config, plan->seed, &life->watcher) != TUMBLE_OK) {
        bench_watch_break(life, BENCH_BROKEN_BENCH, 0.0, 0);
        return;
    }
    compose(life);
    while (advance(life)) {
    }
    sum_up(life);
}

/* The fewest events that are enough. */

static void take_out(bench_plan_t *plan, uint32_t first, uint32_t count)
{
    memmove(&plan->events[first], &plan->events[first + count], (plan->count - first - count) * sizeof plan->events[0]);
    plan->count -= count;
}

static bool breaks(bench_plan_t *plan, bench_life_t *life, bench_broken_t kind)
{
    bench_life_run(life, plan);
    return life->watch.violation.kind == kind;
}

/* One round with pieces of this size. True: something went. */
static bool one_round(bench_plan_t *plan, bench_life_t *life, bench_broken_t kind, uint32_t size)
{
    static bench_event_t kept[BENCH_PLAN_EVENTS];
    bool shrunk = false;
    uint32_t at = 0;
    while (at < plan->count) {
        const uint32_t before = plan->count;
        const uint32_t piece = (size < before - at) ? size : before - at;
        memcpy(kept, plan->events, sizeof kept);
        take_out(plan, at, piece);
        if (breaks(plan, life, kind)) {
            shrunk = true;
        } else {
            memcpy(plan->events, kept, sizeof kept);
            plan->count = before;
            at += piece;
        }
    }
    return shrunk;
}

void bench_plan_shrink(bench_plan_t *plan, bench_life_t *life, bench_broken_t kind)
{
    for (uint32_t size = (plan->count + 1U) / 2U; size > 1U; size = (size + 1U) / 2U) {
        (void)one_round(plan, life, kind, size);
    }
    while (one_round(plan, life, kind, 1)) {
    }
    (void)breaks(plan, life, kind);
}
