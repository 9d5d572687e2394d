/* What must hold, held against the simulation's truth: of the table, of the computer's own counts, of the sets. */
#include "world/hostile.h"

#include "core/accumulator.h"
#include "core/bytes.h"
#include "navcomp/service.h"
#include "simulation/block_encode.h"

#include <math.h>
#include <string.h>

#define COMMAND_OBJECT 0x2002U
#define FIRST_SERVER 0x601U
#define SECOND_SERVER 0x401U
#define BLOCK_XY 0x683U
#define BLOCK_Z 0x693U
#define ABORT_WAS_REFUSED 0x08000022U
#define KEY_OBJECT 0x2006U

#define REST_US 6000000U
#define NOTICE_US 1000000U /* a stranger's set-point is noticed, and the table stops, by then */
#define HOMING_DEG 900.0   /* cable and a turn, braking, and what is turned until a homing that does not end is */
#define SPEED_EXCESS 1.02
#define TRUTH_COVERAGE 6.0
#define CABLE_TOLERANCE_DEG 5.0
#define PEACE_US 1000000U /* it has stood for so long: it rests */
#define PLACE_DEG 0.5     /* errors of the stand, and its swing */
#define LEVEL_US 60000000U
#define LATE_US 200000U /* the firmware looks at its clock every 100 ms at least */
#define TOLD_US 2000000U
#define DECIDED_US 5000000U /* what is decided is done by then */

/* What is noted for all invariants. */

void bench_watch_break(bench_life_t *life, life_broken_t kind, double value, uint32_t what)
{
    life_found_t *const found = life->found;
    if (found->kind == LIFE_BROKEN_NONE) {
        found->kind = kind;
        found->at_us = life->world->clock.now_us;
        found->value = value;
        found->what = what;
    }
}

void bench_watch_init(bench_life_t *life)
{
    life->watch = (bench_watch_t){.rest_us = SIM_NEVER,
                                  .peace = true,
                                  .still_us = SIM_NEVER,
                                  .told_by_us = SIM_NEVER,
                                  .open_us = SIM_NEVER,
                                  .fast_us = SIM_NEVER,
                                  .state = TUMBLE_STATE_IDLE};
}

void bench_watch_excuse(bench_life_t *life, life_excuse_t excuse)
{
    life->found->excuses |= 1U << excuse;
    if (excuse == LIFE_EXCUSE_COMMANDED) {
        life->watch.commanded_us = life->world->clock.now_us;
    }
}

static bool has_excuse(const bench_life_t *life, life_excuse_t excuse)
{
    return (life->found->excuses >> excuse & 1U) != 0U;
}

void bench_watch_commanded(bench_life_t *life)
{
    life->watch.rest_us = SIM_NEVER;
    life->watch.peace = false;
}

/* The table, and what a state shows. */

void bench_watch_ended(bench_life_t *life)
{
    if (life->watch.rest_us == SIM_NEVER && !life->watch.peace) {
        life->watch.rest_us = life->world->clock.now_us + REST_US;
        life->watch.still_us = SIM_NEVER; /* what is on its way to the drive may still set it in motion */
    }
}

/* The way in which the table comes to rest from its full speed. */
static double braking_deg(const sim_drive_config_t *drive)
{
    return drive->speed_deg_s * drive->speed_deg_s / (2.0 * drive->acceleration_deg_s2);
}

/* A stranger has commanded the drive so lately that the computer need not have noticed. */
static bool is_excusable(const bench_life_t *life)
{
    const bench_watch_t *const watch = &life->watch;
    return has_excuse(life, LIFE_EXCUSE_COMMANDED) && life->world->clock.now_us < watch->commanded_us + NOTICE_US;
}

static life_broken_t blamed(const bench_life_t *life, life_broken_t otherwise)
{
    return has_excuse(life, LIFE_EXCUSE_COMMANDED) ? LIFE_BROKEN_FOREIGN : otherwise;
}

/* A table that stands for a moment, say between the search for the mark and the way back to it, does not rest. */
static void look_for_peace(bench_watch_t *watch, uint64_t now_us, bool moves)
{
    watch->still_us = moves ? SIM_NEVER : (watch->still_us == SIM_NEVER) ? now_us : watch->still_us;
    if (watch->rest_us != SIM_NEVER && !moves && now_us - watch->still_us >= PEACE_US) {
        watch->rest_us = SIM_NEVER;
        watch->peace = true;
    }
}

static void look_at_rest(bench_life_t *life, bool moves, double deg)
{
    bench_watch_t *const watch = &life->watch;
    const uint64_t now_us = life->world->clock.now_us;
    look_for_peace(watch, now_us, moves);
    if (!moves || is_excusable(life)) {
        return;
    }
    if (watch->rest_us != SIM_NEVER && now_us >= watch->rest_us) {
        bench_watch_break(life, blamed(life, LIFE_BROKEN_REST), deg, (uint32_t)watch->state);
    } else if (watch->peace) {
        bench_watch_break(life, blamed(life, LIFE_BROKEN_STAYS), deg, (uint32_t)watch->state);
    }
}

/* On the way back it may be beyond: after a stranger has taken it there. */
static void look_at_cable(bench_life_t *life, bool moves, double deg)
{
    const bench_config_t *const config = life->config;
    const sim_drive_config_t *const drive = &config->scenario.drive;
    const double unseen_deg = drive->speed_deg_s * 1e-6 * drive->report_us; /* between two reports */
    const double tolerance_deg = CABLE_TOLERANCE_DEG + unseen_deg + braking_deg(drive);
    const double last_deg = life->watch.last_deg;
    const bool below = deg < config->procedure.cable_min_deg - tolerance_deg && deg < last_deg;
    const bool above = deg > config->procedure.cable_max_deg + tolerance_deg && deg > last_deg;
    if (moves && (below || above) && !is_excusable(life)) {
        bench_watch_break(life, blamed(life, LIFE_BROKEN_CABLE), deg, (uint32_t)life->watch.state);
    }
}

static bool is_under_way(sim_homing_t homing)
{
    return homing == SIM_HOMING_SEARCH || homing == SIM_HOMING_APPROACH;
}

/* A homing that was broken off counts until the table rests. */
static void look_at_homing(bench_life_t *life, bool moves, double deg)
{
    bench_watch_t *const watch = &life->watch;
    const sim_homing_t homing = life->world->drive.homing;
    if (is_under_way(homing) && !is_under_way(watch->homing)) {
        watch->searches = true;
        watch->from_deg = deg;
        life->found->homings++;
    } else if (!is_under_way(homing) && (!moves || homing == SIM_HOMING_ATTAINED)) {
        watch->searches = false;
    }
    watch->homing = homing;
    if (watch->searches && fabs(deg - watch->from_deg) > HOMING_DEG) {
        bench_watch_break(life, LIFE_BROKEN_HOMING, deg - watch->from_deg, (uint32_t)watch->state);
    }
}

/* What a stranger has changed is read back before a motion; what he changes on its way may count for its next leg. */
static void look_at_speed(bench_life_t *life, double velocity_deg_s, double deg)
{
    bench_watch_t *const watch = &life->watch;
    const uint64_t now_us = life->world->clock.now_us;
    const tumble_drive_profile_t *const profile = &life->config->profile;
    const double told_deg_s = is_under_way(watch->homing) ? profile->homing_fast_deg_s : profile->velocity_deg_s;
    if (fabs(velocity_deg_s) <= told_deg_s * SPEED_EXCESS) {
        watch->fast_us = SIM_NEVER;
    } else if (watch->fast_us == SIM_NEVER) {
        watch->fast_us = now_us;
    } else if (now_us - watch->fast_us > NOTICE_US) {
        bench_watch_break(life, LIFE_BROKEN_SPEED, deg, (uint32_t)watch->state);
    }
}

static void look_at_table(bench_life_t *life)
{
    const bench_world_t *const world = life->world;
    const uint64_t now_us = world->clock.now_us;
    const bool moves = now_us < sim_axis_end_us(world->axis);
    double velocity_deg_s;
    if (has_excuse(life, LIFE_EXCUSE_REWRITTEN)) {
        return;
    }
    const double deg = sim_axis_commanded_deg(world->axis, now_us, &velocity_deg_s);
    look_at_rest(life, moves, deg);
    look_at_homing(life, moves, deg);
    look_at_speed(life, velocity_deg_s, deg);
    if (world->drive.homing == SIM_HOMING_ATTAINED && world->drive.powered) {
        look_at_cable(life, moves, deg);
    }
    life->watch.last_deg = deg;
}

/* The computer's own counts: service level, run number, samples of a mean. */

/* Service level: nothing but its key opens it, and what it protects is refused without it. */

static bool is_protected(uint16_t index, uint8_t subindex)
{
    static const uint16_t PROTECTED[] = {0x1010, 0x1011, 0x1016, 0x1017, 0x1029, 0x1400, 0x1401, 0x1600, 0x1601,
                                         0x1800, 0x1801, 0x1A00, 0x1A01, 0x2123, 0x2124, 0x2125, 0x2126};
    for (uint32_t i = 0; i < sizeof PROTECTED / sizeof PROTECTED[0]; i++) {
        if (index == PROTECTED[i]) {
            return true;
        }
    }
    return (index == 0x2050U && subindex == 5U) || (index == 0x2122U && subindex == 6U);
}

static void note_request(bench_life_t *life, const tumble_can_frame_t *frame)
{
    bench_watch_t *const watch = &life->watch;
    const uint64_t now_us = life->world->clock.now_us;
    const bool is_write = frame->length == 8U && (frame->data[0] & 0xE2U) == 0x22U; /* in this one frame */
    if (is_write && tumble_get_u16(&frame->data[1]) == KEY_OBJECT && frame->data[3] == 1U) {
        const uint32_t key = tumble_get_u32(&frame->data[4]);
        watch->level_until_us = (key == TUMBLE_SERVICE_KEY) ? now_us + LEVEL_US
                                : (key == 0U)               ? 0U
                                                            : watch->level_until_us;
    }
    watch->locked = is_write && now_us > watch->level_until_us + LATE_US;
}

static void note_written(bench_life_t *life, uint16_t index, uint8_t subindex)
{
    if (life->watch.locked && is_protected(index, subindex)) {
        bench_watch_break(life, LIFE_BROKEN_LEVEL, 0.0, (uint32_t)index << 8 | subindex);
    }
}

static void look_at_level(bench_life_t *life)
{
    bench_watch_t *const watch = &life->watch;
    const uint64_t now_us = life->world->clock.now_us;
    if (!tumble_service_is_open(&life->world->navcomp) || now_us <= watch->level_until_us) {
        watch->open_us = SIM_NEVER;
    } else if (watch->open_us == SIM_NEVER) {
        watch->open_us = now_us;
    } else if (now_us - watch->open_us > LATE_US) {
        bench_watch_break(life, LIFE_BROKEN_LEVEL, 0.0, (uint32_t)KEY_OBJECT << 8 | 2U);
    }
}

/* The run number: one more with each run that begins, and with nothing else. */

static void look_at_number(bench_life_t *life)
{
    const uint32_t runs = tumble_service_runs(&life->world->navcomp);
    if (runs < life->watch.runs || runs > life->watch.runs + 1U) {
        bench_watch_break(life, LIFE_BROKEN_RUN, (double)runs, life->watch.runs);
    }
}

static void count_run(bench_life_t *life, bool begins, bool may_begin)
{
    bench_watch_t *const watch = &life->watch;
    const uint32_t runs = tumble_service_runs(&life->world->navcomp);
    const uint32_t least = begins ? 1U : 0U;
    const uint32_t most = (begins || may_begin) ? 1U : 0U;
    if (runs < watch->runs + least || runs > watch->runs + most) {
        bench_watch_break(life, LIFE_BROKEN_RUN, (double)runs, watch->runs);
    }
    watch->runs = runs;
}

/* Means: of so many samples as are configured, all different, all of frames that came, at this position of the table. */

static bool has_come(const bench_collected_t *collected, const tumble_can_frame_t *frame)
{
    for (uint32_t i = 0; i < BENCH_RECENT; i++) {
        if (collected->frames[i].id == frame->id && memcmp(collected->frames[i].data, frame->data, 8) == 0) {
            return true;
        }
    }
    return false;
}

static bool is_new(const bench_collected_t *collected, uint16_t counter)
{
    const uint32_t kept = (collected->count < BENCH_COUNTERS) ? collected->count : BENCH_COUNTERS;
    for (uint32_t i = 0; i < kept; i++) {
        if (collected->counters[i] == counter) {
            return false;
        }
    }
    return true;
}

/* Of the true table; a slip, and a stop too short to be refused, are excused. */
static bool is_there(const bench_life_t *life, uint8_t index)
{
    static const uint32_t EXCUSES = 1U << LIFE_EXCUSE_REWRITTEN | 1U << LIFE_EXCUSE_SLIP | 1U << LIFE_EXCUSE_SHORT;
    const bench_config_t *const config = life->config;
    const double wanted_deg = config->scenario.schedule.positions[index].angle.deg;
    const double deg = sim_axis_actual_deg(life->world->axis, life->world->clock.now_us);
    return (life->found->excuses & EXCUSES) != 0U ||
           fabs(remainder(deg - wanted_deg, 360.0)) <= config->procedure.position_tolerance_deg + PLACE_DEG;
}

void bench_watch_sample(bench_life_t *life, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    bench_collected_t *const collected = &life->watch.collected;
    sim_block_frames_t frames;
    if (taken.ordinal == 1U) {
        collected->index = taken.index;
        collected->count = 0;
        memset(collected->sum, 0, sizeof collected->sum);
    }
    sim_block_encode(sample, &frames);
    const bool good = taken.index == collected->index && taken.ordinal == collected->count + 1U &&
                      is_new(collected, sample->raw.counter) && has_come(collected, &frames.xy) &&
                      has_come(collected, &frames.z) && is_there(life, taken.index);
    if (!good) {
        bench_watch_break(life, LIFE_BROKEN_MEAN, (double)taken.ordinal, taken.index);
    }
    collected->counters[collected->count % BENCH_COUNTERS] = sample->raw.counter;
    collected->count++;
    for (int c = 0; c < TUMBLE_CHANNELS; c++) {
        collected->sum[c] += sample->raw.counts[c];
    }
}

static bool is_collected(const bench_life_t *life, uint8_t index, const tumble_average_t *average)
{
    const bench_collected_t *const collected = &life->watch.collected;
    return collected->index == index && collected->count == average->samples &&
           (average->samples == life->config->procedure.samples || has_excuse(life, LIFE_EXCUSE_RULES)) &&
           memcmp(collected->sum, average->sum_counts, sizeof collected->sum) == 0;
}

/* A mean that is there is the one just collected, or one that was there before: back after a loss of power. */
static void look_at_mean(bench_life_t *life, uint8_t index, const tumble_average_t *average)
{
    bench_known_t *const known = &life->watch.known[index];
    for (uint32_t i = 0; i < BENCH_KNOWN; i++) {
        const tumble_average_t *const other = &known->means[i];
        if (other->samples == average->samples &&
            memcmp(other->sum_counts, average->sum_counts, sizeof other->sum_counts) == 0 &&
            memcmp(other->scatter_counts, average->scatter_counts, sizeof other->scatter_counts) == 0) {
            return;
        }
    }
    if (!is_collected(life, index, average)) {
        bench_watch_break(life, LIFE_BROKEN_MEAN, (double)average->samples, index);
        return;
    }
    known->means[known->next++ % BENCH_KNOWN] = *average;
}

static void check_means(bench_life_t *life)
{
    const tumble_averaging_t *const averages =
        tumble_procedure_averages(tumble_navcomp_procedure(&life->world->navcomp));
    for (uint8_t i = 0; i < life->config->scenario.schedule.position_count; i++) {
        if (tumble_averaging_has_mean(averages, i)) {
            look_at_mean(life, i, &averages->averages[i]);
        }
    }
}

/* The coefficient sets, and what can be read. */

/* What excuses coefficients that are off. */
static bool is_excused(const bench_life_t *life)
{
    static const uint32_t EXCUSES = 1U << LIFE_EXCUSE_REWRITTEN | 1U << LIFE_EXCUSE_STEP | 1U << LIFE_EXCUSE_SLIP |
                                    1U << LIFE_EXCUSE_SHORT | 1U << LIFE_EXCUSE_CHANNEL | 1U << LIFE_EXCUSE_SAMPLE |
                                    1U << LIFE_EXCUSE_RULES;
    return (life->found->excuses & EXCUSES) != 0U;
}

static void compare_with_truth(bench_life_t *life, const tumble_set_t *set)
{
    const tumble_coefficients_t *const truth = &life->world->truth.block;
    double worst = 0.0;
    uint32_t where = 0;
    for (uint32_t c = 0; c < TUMBLE_COEFFICIENTS; c++) {
        const uint32_t row = (c < 9U) ? c / 3U : c - 9U;
        const double off = (c < 9U) ? set->coefficients.k_v_per_g[row][c % 3U] - truth->k_v_per_g[row][c % 3U]
                                    : set->coefficients.u0_v[row] - truth->u0_v[row];
        const double u = (c < 9U) ? set->uncertainty.k_v_per_g[row][c % 3U] : set->uncertainty.u0_v[row];
        const double ratio = fabs(off) / u;
        if (!(ratio <= worst)) {
            worst = ratio;
            where = c;
        }
    }
    if (!(worst <= TRUTH_COVERAGE)) {
        bench_watch_break(life, LIFE_BROKEN_TRUTH, worst, where);
    }
}

/* Another set is active. */
static void look_at_new(bench_life_t *life)
{
    tumble_set_t set;
    if (tumble_store_read(&life->memory->keeper.store, TUMBLE_SET_ACTIVE, &set) != TUMBLE_OK ||
        set.origin != TUMBLE_ORIGIN_COMMITTED) {
        return;
    }
    life->found->committed++;
    if (!is_excused(life)) {
        life->found->judged++;
        compare_with_truth(life, &set);
    }
}

/* A flipped bit may have hit it. */
static void bear_decay(bench_life_t *life, life_broken_t kind, double value)
{
    if (!has_excuse(life, LIFE_EXCUSE_FLIPPED)) {
        bench_watch_break(life, kind, value, life->watch.counter);
    } else if (life->watch.told_by_us == SIM_NEVER) {
        life->watch.told_by_us = life->world->clock.now_us + TOLD_US;
    }
}

static void look_whether_told(bench_life_t *life)
{
    bench_watch_t *const watch = &life->watch;
    if (watch->told_by_us == SIM_NEVER) {
        return;
    }
    tumble_sets_state_t state;
    tumble_keeper_state(&life->memory->keeper, &state);
    const bool lacks = !watch->has_set && (state.due & TUMBLE_DUE_NO_SET) != 0; /* which says it */
    if (watch->told || lacks || (state.due & TUMBLE_DUE_DECAYED) != 0) {
        watch->told_by_us = SIM_NEVER;
    } else if (life->world->clock.now_us >= watch->told_by_us) {
        watch->told_by_us = SIM_NEVER;
        if (life->found->flipped_bits == 1U) {
            bench_watch_break(life, LIFE_BROKEN_COUNTER, (double)watch->counter, watch->counter);
        }
    }
}

/* Have bits of the proposal flipped? */
static bool was_hit(const bench_life_t *life)
{
    bool hit = false;
    for (uint32_t i = 0; i < life->flipped_count; i++) {
        hit = hit || life->flipped[i].offset == TUMBLE_REGION_PROPOSAL * SIM_NV_SECTOR;
    }
    return hit;
}

/* A proposal stays until somebody decides, or another result takes its place. */
static void look_at_proposal(bench_life_t *life)
{
    bench_watch_t *const watch = &life->watch;
    const uint32_t proposal = tumble_store_proposal(&life->memory->keeper.store);
    if (proposal == watch->proposal) {
        return;
    }
    if (watch->proposal != 0U && life->world->clock.now_us > watch->decided_us && !was_hit(life)) {
        bench_watch_break(life, LIFE_BROKEN_PROPOSAL, (double)proposal, watch->proposal);
    }
    watch->proposal = proposal;
    watch->decided_us = 0;
}

static void may_go(bench_life_t *life, bool may)
{
    life->watch.decided_us = may ? life->world->clock.now_us + DECIDED_US : 0U;
}

void bench_watch_decide(bench_life_t *life, tumble_command_t command, bool refused)
{
    if (command == TUMBLE_COMMAND_ACCEPT || command == TUMBLE_COMMAND_DISCARD || command == TUMBLE_COMMAND_ROLLBACK) {
        may_go(life, !refused);
    }
}

static bool counts_as_valid(const bench_life_t *life, uint32_t offset)
{
    const tumble_keeper_t *const keeper = &life->memory->keeper;
    const uint32_t region = offset / SIM_NV_SECTOR;
    if (region <= TUMBLE_REGION_PROPOSAL) {
        return keeper->store.places[region].valid;
    }
    const uint32_t cell = offset % SIM_NV_SECTOR / TUMBLE_HISTORY_BYTES;
    return !tumble_history_busy(&keeper->history) &&
           (keeper->history.valid[region - TUMBLE_REGION_HISTORY] >> cell & 1U) != 0U;
}

static void look_at_flipped(bench_life_t *life)
{
    for (uint32_t i = 0; i < life->flipped_count; i++) {
        const bench_flipped_t *const flipped = &life->flipped[i];
        if (counts_as_valid(life, flipped->offset) && bench_life_is_flipped(life, flipped)) {
            bench_watch_break(life, LIFE_BROKEN_DECAYED, 0.0, flipped->offset);
        }
    }
}

static void look_at_sets(bench_life_t *life)
{
    bench_watch_t *const watch = &life->watch;
    const tumble_store_t *const store = &life->memory->keeper.store;
    if (!store->cells.booted || tumble_store_busy(store)) {
        return;
    }
    const bool has_set = tumble_store_has(store, TUMBLE_SET_ACTIVE);
    const uint32_t counter = tumble_store_sequence(store);
    if (watch->has_set && !has_set) {
        bear_decay(life, LIFE_BROKEN_LOST, 0.0);
    } else if (counter < watch->counter) {
        bear_decay(life, LIFE_BROKEN_COUNTER, (double)counter);
    } else if (counter > watch->counter) {
        look_at_new(life);
    }
    watch->has_set = has_set;
    watch->counter = counter;
    look_whether_told(life);
    look_at_proposal(life);
    look_at_flipped(life);
}

void bench_watch_power_on(bench_life_t *life)
{
    life->watch.told = false;
    may_go(life, life->watch.decided_us == SIM_NEVER);
    life->watch.level_until_us = 0;
    life->watch.open_us = SIM_NEVER;
    life->watch.runs = 0;
}

/* What can be read. */

static bool is_finite(const tumble_entry_t *entry, const uint8_t *bytes)
{
    return (entry->type == TUMBLE_TYPE_REAL32) ? isfinite(tumble_get_f32(bytes)) : isfinite(tumble_get_f64(bytes));
}

static void read_row(bench_life_t *life, const tumble_entry_t *row)
{
    tumble_node_t *const node = &life->world->navcomp.node;
    for (uint32_t object = 0; object <= row->more_objects; object++) {
        for (uint32_t sub = 0; sub <= row->more_subindices; sub++) {
            uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
            uint8_t size = 0;
            const uint16_t index = (uint16_t)(row->index + object);
            const uint8_t subindex = (uint8_t)(row->subindex + sub);
            if (tumble_node_read(node, index, subindex, bytes, &size) == TUMBLE_ABORT_NONE && !is_finite(row, bytes)) {
                bench_watch_break(life, LIFE_BROKEN_FINITE, 0.0, (uint32_t)index << 8 | subindex);
            }
        }
    }
}

static void read_table(bench_life_t *life, const tumble_object_table_t *table)
{
    for (uint32_t i = 0; i < table->count; i++) {
        const tumble_entry_t *const row = &table->entries[i];
        const bool real = row->type == TUMBLE_TYPE_REAL32 || row->type == TUMBLE_TYPE_REAL64;
        if (real && (row->access & TUMBLE_ACCESS_READ) != 0U) {
            read_row(life, row);
        }
    }
}

void bench_watch_read_all(bench_life_t *life)
{
    const tumble_dictionary_t *const dictionary = &life->world->navcomp.node.dictionary;
    read_table(life, dictionary->table);
    if (dictionary->extension != NULL) {
        read_table(life, dictionary->extension->table);
    }
}

/* What happens. */

static bool is_of_a_run(tumble_state_t state)
{
    return state != TUMBLE_STATE_IDLE && state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT &&
           state != TUMBLE_STATE_FAULT;
}

void bench_watch_change(bench_life_t *life, const tumble_progress_t *progress)
{
    const bool was_on = is_of_a_run(life->watch.state);
    const tumble_state_t state = progress->state;
    const bool changed = state != life->watch.state;
    const bool waited = !was_on && life->watch.state != TUMBLE_STATE_FAULT;
    const bool may_begin = !was_on && (changed || state == TUMBLE_STATE_ABORT); /* and failed or aborted at once */
    count_run(life, waited && is_of_a_run(state), may_begin);
    life->watch.state = state;
    if (is_of_a_run(state)) {
        life->watch.level_until_us = 0; /* it ends with the beginning of a run */
    } else if (state == TUMBLE_STATE_DONE && changed) {
        may_go(life, true); /* the new result takes its place */
    }
    if ((state == TUMBLE_STATE_FAULT || state == TUMBLE_STATE_ABORT) && progress->reason == TUMBLE_REASON_NONE) {
        bench_watch_break(life, LIFE_BROKEN_REASON, 0.0, (uint32_t)state);
    }
    if (changed && !is_of_a_run(state) && (was_on || state != TUMBLE_STATE_IDLE)) {
        bench_watch_ended(life);
        life->found->ends[state][progress->reason]++;
    }
    check_means(life);
    if (state == TUMBLE_STATE_DONE) {
        bench_watch_read_all(life);
    }
}

static bool is_write(const tumble_can_frame_t *frame, uint16_t index, uint8_t subindex)
{
    return frame->length == 8U && (frame->data[0] & 0xE0U) == 0x20U && frame->data[1] == (index & 0xFFU) &&
           frame->data[2] == index >> 8 && frame->data[3] == subindex;
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
        note_written(life, index, frame->data[3]);
    }
    if (taken && (index == 0x2050U || (index >= 0x2122U && index <= 0x2126U))) {
        bench_watch_excuse(life, LIFE_EXCUSE_RULES);
    }
}

void bench_watch_frame(bench_life_t *life, uint8_t sender, const tumble_can_frame_t *frame)
{
    if (frame->id == FIRST_SERVER || frame->id == SECOND_SERVER) {
        note_request(life, frame);
    } else if (frame->id == BLOCK_XY || frame->id == BLOCK_Z) {
        life->watch.collected.frames[life->watch.collected.next++ % BENCH_RECENT] = *frame;
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

void bench_watch_look(bench_life_t *life)
{
    look_at_table(life);
    if (!life->world->off) {
        look_at_level(life);
        look_at_number(life);
        look_at_sets(life);
    }
}
