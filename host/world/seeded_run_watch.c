/* What must hold, held against the simulation's truth: of the table, of the computer's own counts, of the sets. */
#include "world/seeded_run.h"

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

void bench_watch_break(seeded_run_t *run, campaign_violation_t kind, double value, uint32_t what)
{
    campaign_found_t *const found = run->found;
    if (found->kind == CAMPAIGN_VIOLATION_NONE) {
        found->kind = kind;
        found->at_us = run->world->clock.now_us;
        found->value = value;
        found->what = what;
    }
}

void bench_watch_init(seeded_run_t *run)
{
    run->watch = (bench_watch_t){.rest_us = SIM_NEVER,
                                 .peace = true,
                                 .still_us = SIM_NEVER,
                                 .told_by_us = SIM_NEVER,
                                 .open_us = SIM_NEVER,
                                 .fast_us = SIM_NEVER,
                                 .state = TUMBLE_STATE_IDLE};
}

void bench_watch_excuse(seeded_run_t *run, campaign_excuse_t excuse)
{
    run->found->excuses |= 1U << excuse;
    if (excuse == CAMPAIGN_EXCUSE_COMMANDED) {
        run->watch.commanded_us = run->world->clock.now_us;
    }
}

static bool has_excuse(const seeded_run_t *run, campaign_excuse_t excuse)
{
    return (run->found->excuses >> excuse & 1U) != 0U;
}

void bench_watch_commanded(seeded_run_t *run)
{
    run->watch.rest_us = SIM_NEVER;
    run->watch.peace = false;
}

/* The table, and what a state shows. */

void bench_watch_ended(seeded_run_t *run)
{
    if (run->watch.rest_us == SIM_NEVER && !run->watch.peace) {
        run->watch.rest_us = run->world->clock.now_us + REST_US;
        run->watch.still_us = SIM_NEVER; /* what is on its way to the drive may still set it in motion */
    }
}

/* The way in which the table comes to rest from its full speed. */
static double braking_deg(const sim_drive_config_t *drive)
{
    return drive->speed_deg_s * drive->speed_deg_s / (2.0 * drive->acceleration_deg_s2);
}

/* A stranger has commanded the drive so lately that the computer need not have noticed. */
static bool is_excusable(const seeded_run_t *run)
{
    const bench_watch_t *const watch = &run->watch;
    return has_excuse(run, CAMPAIGN_EXCUSE_COMMANDED) && run->world->clock.now_us < watch->commanded_us + NOTICE_US;
}

static campaign_violation_t blamed(const seeded_run_t *run, campaign_violation_t otherwise)
{
    return has_excuse(run, CAMPAIGN_EXCUSE_COMMANDED) ? CAMPAIGN_VIOLATION_FOREIGN : otherwise;
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

static void check_rest(seeded_run_t *run, bool moves, double deg)
{
    bench_watch_t *const watch = &run->watch;
    const uint64_t now_us = run->world->clock.now_us;
    look_for_peace(watch, now_us, moves);
    if (!moves || is_excusable(run)) {
        return;
    }
    if (watch->rest_us != SIM_NEVER && now_us >= watch->rest_us) {
        bench_watch_break(run, blamed(run, CAMPAIGN_VIOLATION_REST), deg, (uint32_t)watch->state);
    } else if (watch->peace) {
        bench_watch_break(run, blamed(run, CAMPAIGN_VIOLATION_STAYS), deg, (uint32_t)watch->state);
    }
}

/* On the way back it may be beyond: after a stranger has taken it there. */
static void check_cable(seeded_run_t *run, bool moves, double deg)
{
    const bench_config_t *const config = run->config;
    const sim_drive_config_t *const drive = &config->scenario.drive;
    const double unseen_deg = drive->speed_deg_s * 1e-6 * drive->report_us; /* between two reports */
    const double tolerance_deg = CABLE_TOLERANCE_DEG + unseen_deg + braking_deg(drive);
    const double last_deg = run->watch.last_deg;
    const bool below = deg < config->procedure.cable_min_deg - tolerance_deg && deg < last_deg;
    const bool above = deg > config->procedure.cable_max_deg + tolerance_deg && deg > last_deg;
    if (moves && (below || above) && !is_excusable(run)) {
        bench_watch_break(run, blamed(run, CAMPAIGN_VIOLATION_CABLE), deg, (uint32_t)run->watch.state);
    }
}

static bool is_under_way(sim_homing_t homing)
{
    return homing == SIM_HOMING_SEARCH || homing == SIM_HOMING_APPROACH;
}

/* A homing that was broken off counts until the table rests. */
static void check_homing(seeded_run_t *run, bool moves, double deg)
{
    bench_watch_t *const watch = &run->watch;
    const sim_homing_t homing = run->world->drive.homing;
    if (is_under_way(homing) && !is_under_way(watch->homing)) {
        watch->searches = true;
        watch->from_deg = deg;
        run->found->homings++;
    } else if (!is_under_way(homing) && (!moves || homing == SIM_HOMING_ATTAINED)) {
        watch->searches = false;
    }
    watch->homing = homing;
    if (watch->searches && fabs(deg - watch->from_deg) > HOMING_DEG) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_HOMING, deg - watch->from_deg, (uint32_t)watch->state);
    }
}

/* What a stranger has changed is read back before a motion; what he changes on its way may count for its next leg. */
static void check_speed(seeded_run_t *run, double velocity_deg_s, double deg)
{
    bench_watch_t *const watch = &run->watch;
    const uint64_t now_us = run->world->clock.now_us;
    const tumble_drive_profile_t *const profile = &run->config->profile;
    const double told_deg_s = is_under_way(watch->homing) ? profile->homing_fast_deg_s : profile->velocity_deg_s;
    if (fabs(velocity_deg_s) <= told_deg_s * SPEED_EXCESS) {
        watch->fast_us = SIM_NEVER;
    } else if (watch->fast_us == SIM_NEVER) {
        watch->fast_us = now_us;
    } else if (now_us - watch->fast_us > NOTICE_US) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_SPEED, deg, (uint32_t)watch->state);
    }
}

static void check_table(seeded_run_t *run)
{
    const bench_world_t *const world = run->world;
    const uint64_t now_us = world->clock.now_us;
    const bool moves = now_us < sim_axis_end_us(world->axis);
    double velocity_deg_s;
    if (has_excuse(run, CAMPAIGN_EXCUSE_REWRITTEN)) {
        return;
    }
    const double deg = sim_axis_commanded_deg(world->axis, now_us, &velocity_deg_s);
    check_rest(run, moves, deg);
    check_homing(run, moves, deg);
    check_speed(run, velocity_deg_s, deg);
    if (world->drive.homing == SIM_HOMING_ATTAINED && world->drive.powered) {
        check_cable(run, moves, deg);
    }
    run->watch.last_deg = deg;
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

static void note_request(seeded_run_t *run, const tumble_can_frame_t *frame)
{
    bench_watch_t *const watch = &run->watch;
    const uint64_t now_us = run->world->clock.now_us;
    const bool is_write = frame->length == 8U && (frame->data[0] & 0xE2U) == 0x22U; /* in this one frame */
    if (is_write && tumble_get_u16(&frame->data[1]) == KEY_OBJECT && frame->data[3] == 1U) {
        const uint32_t key = tumble_get_u32(&frame->data[4]);
        watch->level_until_us = (key == TUMBLE_SERVICE_KEY) ? now_us + LEVEL_US
                                : (key == 0U)               ? 0U
                                                            : watch->level_until_us;
    }
    watch->locked = is_write && now_us > watch->level_until_us + LATE_US;
}

static void note_written(seeded_run_t *run, uint16_t index, uint8_t subindex)
{
    if (run->watch.locked && is_protected(index, subindex)) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_LEVEL, 0.0, (uint32_t)index << 8 | subindex);
    }
}

static void check_level(seeded_run_t *run)
{
    bench_watch_t *const watch = &run->watch;
    const uint64_t now_us = run->world->clock.now_us;
    if (!tumble_service_is_open(&run->world->navcomp) || now_us <= watch->level_until_us) {
        watch->open_us = SIM_NEVER;
    } else if (watch->open_us == SIM_NEVER) {
        watch->open_us = now_us;
    } else if (now_us - watch->open_us > LATE_US) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_LEVEL, 0.0, (uint32_t)KEY_OBJECT << 8 | 2U);
    }
}

/* The run number: one more with each run that begins, and with nothing else. */

static void check_number(seeded_run_t *run)
{
    const uint32_t runs = tumble_service_runs(&run->world->navcomp);
    if (runs < run->watch.runs || runs > run->watch.runs + 1U) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_RUN, (double)runs, run->watch.runs);
    }
}

static void count_run(seeded_run_t *run, bool begins, bool may_begin)
{
    bench_watch_t *const watch = &run->watch;
    const uint32_t runs = tumble_service_runs(&run->world->navcomp);
    const uint32_t least = begins ? 1U : 0U;
    const uint32_t most = (begins || may_begin) ? 1U : 0U;
    if (runs < watch->runs + least || runs > watch->runs + most) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_RUN, (double)runs, watch->runs);
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
static bool is_there(const seeded_run_t *run, uint8_t index)
{
    static const uint32_t EXCUSES =
        1U << CAMPAIGN_EXCUSE_REWRITTEN | 1U << CAMPAIGN_EXCUSE_SLIP | 1U << CAMPAIGN_EXCUSE_SHORT;
    const bench_config_t *const config = run->config;
    const double wanted_deg = config->scenario.schedule.positions[index].angle.deg;
    const double deg = sim_axis_actual_deg(run->world->axis, run->world->clock.now_us);
    return (run->found->excuses & EXCUSES) != 0U ||
           fabs(remainder(deg - wanted_deg, 360.0)) <= config->procedure.position_tolerance_deg + PLACE_DEG;
}

void bench_watch_sample(seeded_run_t *run, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    bench_collected_t *const collected = &run->watch.collected;
    sim_block_frames_t frames;
    if (taken.ordinal == 1U) {
        collected->index = taken.index;
        collected->count = 0;
        memset(collected->sum, 0, sizeof collected->sum);
    }
    sim_block_encode(sample, &frames);
    const bool good = taken.index == collected->index && taken.ordinal == collected->count + 1U &&
                      is_new(collected, sample->raw.counter) && has_come(collected, &frames.xy) &&
                      has_come(collected, &frames.z) && is_there(run, taken.index);
    if (!good) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_MEAN, (double)taken.ordinal, taken.index);
    }
    collected->counters[collected->count % BENCH_COUNTERS] = sample->raw.counter;
    collected->count++;
    for (int c = 0; c < TUMBLE_CHANNELS; c++) {
        collected->sum[c] += sample->raw.counts[c];
    }
}

static bool is_collected(const seeded_run_t *run, uint8_t index, const tumble_average_t *average)
{
    const bench_collected_t *const collected = &run->watch.collected;
    return collected->index == index && collected->count == average->samples &&
           (average->samples == run->config->procedure.samples || has_excuse(run, CAMPAIGN_EXCUSE_RULES)) &&
           memcmp(collected->sum, average->sum_counts, sizeof collected->sum) == 0;
}

/* A mean that is there is the one just collected, or one that was there before: back after a loss of power. */
static void check_mean(seeded_run_t *run, uint8_t index, const tumble_average_t *average)
{
    bench_known_t *const known = &run->watch.known[index];
    for (uint32_t i = 0; i < BENCH_KNOWN; i++) {
        const tumble_average_t *const other = &known->means[i];
        if (other->samples == average->samples &&
            memcmp(other->sum_counts, average->sum_counts, sizeof other->sum_counts) == 0 &&
            memcmp(other->scatter_counts, average->scatter_counts, sizeof other->scatter_counts) == 0) {
            return;
        }
    }
    if (!is_collected(run, index, average)) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_MEAN, (double)average->samples, index);
        return;
    }
    known->means[known->next++ % BENCH_KNOWN] = *average;
}

static void check_means(seeded_run_t *run)
{
    const tumble_averaging_t *const averages =
        tumble_procedure_averages(tumble_navcomp_procedure(&run->world->navcomp));
    for (uint8_t i = 0; i < run->config->scenario.schedule.position_count; i++) {
        if (tumble_averaging_has_mean(averages, i)) {
            check_mean(run, i, &averages->averages[i]);
        }
    }
}

/* The coefficient sets, and what can be read. */

/* What excuses coefficients that are off. */
static bool is_excused(const seeded_run_t *run)
{
    static const uint32_t EXCUSES = 1U << CAMPAIGN_EXCUSE_REWRITTEN | 1U << CAMPAIGN_EXCUSE_STEP |
                                    1U << CAMPAIGN_EXCUSE_SLIP | 1U << CAMPAIGN_EXCUSE_SHORT |
                                    1U << CAMPAIGN_EXCUSE_CHANNEL | 1U << CAMPAIGN_EXCUSE_SAMPLE |
                                    1U << CAMPAIGN_EXCUSE_RULES;
    return (run->found->excuses & EXCUSES) != 0U;
}

static void compare_with_truth(seeded_run_t *run, const tumble_set_t *set)
{
    const tumble_coefficients_t *const truth = &run->world->truth.block;
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
        bench_watch_break(run, CAMPAIGN_VIOLATION_TRUTH, worst, where);
    }
}

/* Another set is active. */
static void check_new(seeded_run_t *run)
{
    tumble_set_t set;
    if (tumble_store_read(&run->memory->keeper.store, TUMBLE_SET_ACTIVE, &set) != TUMBLE_OK ||
        set.origin != TUMBLE_ORIGIN_COMMITTED) {
        return;
    }
    run->found->committed++;
    if (!is_excused(run)) {
        run->found->judged++;
        compare_with_truth(run, &set);
    }
}

/* A flipped bit may have hit it. */
static void bear_decay(seeded_run_t *run, campaign_violation_t kind, double value)
{
    if (!has_excuse(run, CAMPAIGN_EXCUSE_FLIPPED)) {
        bench_watch_break(run, kind, value, run->watch.counter);
    } else if (run->watch.told_by_us == SIM_NEVER) {
        run->watch.told_by_us = run->world->clock.now_us + TOLD_US;
    }
}

static void look_whether_told(seeded_run_t *run)
{
    bench_watch_t *const watch = &run->watch;
    if (watch->told_by_us == SIM_NEVER) {
        return;
    }
    tumble_sets_state_t state;
    tumble_keeper_state(&run->memory->keeper, &state);
    const bool lacks = !watch->has_set && (state.due & TUMBLE_DUE_NO_SET) != 0; /* which says it */
    if (watch->told || lacks || (state.due & TUMBLE_DUE_DECAYED) != 0) {
        watch->told_by_us = SIM_NEVER;
    } else if (run->world->clock.now_us >= watch->told_by_us) {
        watch->told_by_us = SIM_NEVER;
        if (run->found->flipped_bits == 1U) {
            bench_watch_break(run, CAMPAIGN_VIOLATION_COUNTER, (double)watch->counter, watch->counter);
        }
    }
}

/* Have bits of the proposal flipped? */
static bool was_hit(const seeded_run_t *run)
{
    bool hit = false;
    for (uint32_t i = 0; i < run->flipped_count; i++) {
        hit = hit || run->flipped[i].offset == TUMBLE_REGION_PROPOSAL * SIM_NV_SECTOR;
    }
    return hit;
}

/* A proposal stays until somebody decides, or another result takes its place. */
static void check_proposal(seeded_run_t *run)
{
    bench_watch_t *const watch = &run->watch;
    const uint32_t proposal = tumble_store_proposal(&run->memory->keeper.store);
    if (proposal == watch->proposal) {
        return;
    }
    if (watch->proposal != 0U && run->world->clock.now_us > watch->decided_us && !was_hit(run)) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_PROPOSAL, (double)proposal, watch->proposal);
    }
    watch->proposal = proposal;
    watch->decided_us = 0;
}

static void may_go(seeded_run_t *run, bool may)
{
    run->watch.decided_us = may ? run->world->clock.now_us + DECIDED_US : 0U;
}

void bench_watch_decide(seeded_run_t *run, tumble_command_t command, bool refused)
{
    if (command == TUMBLE_COMMAND_ACCEPT || command == TUMBLE_COMMAND_DISCARD || command == TUMBLE_COMMAND_ROLLBACK) {
        may_go(run, !refused);
    }
}

static bool counts_as_valid(const seeded_run_t *run, uint32_t offset)
{
    const tumble_keeper_t *const keeper = &run->memory->keeper;
    const uint32_t region = offset / SIM_NV_SECTOR;
    if (region <= TUMBLE_REGION_PROPOSAL) {
        return keeper->store.places[region].stamp.origin != 0U;
    }
    const uint32_t cell = offset % SIM_NV_SECTOR / TUMBLE_HISTORY_BYTES;
    return !tumble_history_busy(&keeper->history) &&
           (keeper->history.valid[region - TUMBLE_REGION_HISTORY] >> cell & 1U) != 0U;
}

static void check_flipped(seeded_run_t *run)
{
    for (uint32_t i = 0; i < run->flipped_count; i++) {
        const bench_flipped_t *const flipped = &run->flipped[i];
        if (counts_as_valid(run, flipped->offset) && seeded_run_is_flipped(run, flipped)) {
            bench_watch_break(run, CAMPAIGN_VIOLATION_DECAYED, 0.0, flipped->offset);
        }
    }
}

static void check_sets(seeded_run_t *run)
{
    bench_watch_t *const watch = &run->watch;
    const tumble_store_t *const store = &run->memory->keeper.store;
    if (!store->cells.booted || tumble_store_busy(store)) {
        return;
    }
    const bool has_set = tumble_store_has(store, TUMBLE_SET_ACTIVE);
    const uint32_t counter = tumble_store_sequence(store);
    if (watch->has_set && !has_set) {
        bear_decay(run, CAMPAIGN_VIOLATION_LOST, 0.0);
    } else if (counter < watch->counter) {
        bear_decay(run, CAMPAIGN_VIOLATION_COUNTER, (double)counter);
    } else if (counter > watch->counter) {
        check_new(run);
    }
    watch->has_set = has_set;
    watch->counter = counter;
    look_whether_told(run);
    check_proposal(run);
    check_flipped(run);
}

void bench_watch_power_on(seeded_run_t *run)
{
    run->watch.told = false;
    may_go(run, run->watch.decided_us == SIM_NEVER);
    run->watch.level_until_us = 0;
    run->watch.open_us = SIM_NEVER;
    run->watch.runs = 0;
}

/* What can be read. */

static bool is_finite(const tumble_entry_t *entry, const uint8_t *bytes)
{
    return (entry->type == TUMBLE_TYPE_REAL32) ? isfinite(tumble_get_f32(bytes)) : isfinite(tumble_get_f64(bytes));
}

static void read_row(seeded_run_t *run, const tumble_entry_t *row)
{
    tumble_node_t *const node = &run->world->navcomp.node;
    for (uint32_t object = 0; object <= row->more_objects; object++) {
        for (uint32_t sub = 0; sub <= row->more_subindices; sub++) {
            uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
            uint8_t size = 0;
            const uint16_t index = (uint16_t)(row->index + object);
            const uint8_t subindex = (uint8_t)(row->subindex + sub);
            if (tumble_node_read(node, index, subindex, bytes, &size) == TUMBLE_ABORT_NONE && !is_finite(row, bytes)) {
                bench_watch_break(run, CAMPAIGN_VIOLATION_FINITE, 0.0, (uint32_t)index << 8 | subindex);
            }
        }
    }
}

static void read_table(seeded_run_t *run, const tumble_object_table_t *table)
{
    for (uint32_t i = 0; i < table->count; i++) {
        const tumble_entry_t *const row = &table->entries[i];
        const bool real = row->type == TUMBLE_TYPE_REAL32 || row->type == TUMBLE_TYPE_REAL64;
        if (real && (row->access & TUMBLE_ACCESS_READ) != 0U) {
            read_row(run, row);
        }
    }
}

void bench_watch_read_all(seeded_run_t *run)
{
    const tumble_dictionary_t *const dictionary = &run->world->navcomp.node.dictionary;
    read_table(run, dictionary->table);
    if (dictionary->extension != NULL) {
        read_table(run, dictionary->extension->table);
    }
}

/* What happens. */

static bool is_of_a_run(tumble_state_t state)
{
    return state != TUMBLE_STATE_IDLE && state != TUMBLE_STATE_DONE && state != TUMBLE_STATE_ABORT &&
           state != TUMBLE_STATE_FAULT;
}

void bench_watch_change(seeded_run_t *run, const tumble_progress_t *progress)
{
    const bool was_on = is_of_a_run(run->watch.state);
    const tumble_state_t state = progress->state;
    const bool changed = state != run->watch.state;
    const bool waited = !was_on && run->watch.state != TUMBLE_STATE_FAULT;
    const bool may_begin = !was_on && (changed || state == TUMBLE_STATE_ABORT); /* and failed or aborted at once */
    count_run(run, waited && is_of_a_run(state), may_begin);
    run->watch.state = state;
    if (is_of_a_run(state)) {
        run->watch.level_until_us = 0; /* it ends with the beginning of a run */
    } else if (state == TUMBLE_STATE_DONE && changed) {
        may_go(run, true); /* the new result takes its place */
    }
    if ((state == TUMBLE_STATE_FAULT || state == TUMBLE_STATE_ABORT) && progress->reason == TUMBLE_REASON_NONE) {
        bench_watch_break(run, CAMPAIGN_VIOLATION_REASON, 0.0, (uint32_t)state);
    }
    if (changed && !is_of_a_run(state) && (was_on || state != TUMBLE_STATE_IDLE)) {
        bench_watch_ended(run);
        run->found->ends[state][progress->reason]++;
    }
    check_means(run);
    if (state == TUMBLE_STATE_DONE) {
        bench_watch_read_all(run);
    }
}

static bool is_write(const tumble_can_frame_t *frame, uint16_t index, uint8_t subindex)
{
    return frame->length == 8U && (frame->data[0] & 0xE0U) == 0x20U && frame->data[1] == (index & 0xFFU) &&
           frame->data[2] == index >> 8 && frame->data[3] == subindex;
}

/* The computer answers a write: taken, or why not. */
static void note_answer(seeded_run_t *run, const tumble_can_frame_t *frame)
{
    const uint16_t index = (uint16_t)(frame->data[1] | frame->data[2] << 8);
    const bool taken = frame->data[0] == 0x60U;
    const uint32_t code =
        (uint32_t)(frame->data[4] | frame->data[5] << 8 | frame->data[6] << 16) | (uint32_t)frame->data[7] << 24;
    if (index == COMMAND_OBJECT && frame->data[3] == 2U && run->abort_asked) {
        run->abort_asked = false;
        if (taken || (frame->data[0] == 0x80U && code == ABORT_WAS_REFUSED)) {
            bench_watch_ended(run);
        }
    }
    if (index == COMMAND_OBJECT && frame->data[3] == 2U && frame->data[0] == 0x80U) {
        bench_watch_decide(run, run->command_asked, true);
    }
    if (taken) {
        note_written(run, index, frame->data[3]);
    }
    if (taken && (index == 0x2050U || (index >= 0x2122U && index <= 0x2126U))) {
        bench_watch_excuse(run, CAMPAIGN_EXCUSE_RULES);
    }
}

void bench_watch_frame(seeded_run_t *run, uint8_t sender, const tumble_can_frame_t *frame)
{
    if (frame->id == FIRST_SERVER || frame->id == SECOND_SERVER) {
        note_request(run, frame);
    } else if (frame->id == BLOCK_XY || frame->id == BLOCK_Z) {
        run->watch.collected.frames[run->watch.collected.next++ % BENCH_RECENT] = *frame;
    } else if (frame->id == 0U && frame->length == 2U && (frame->data[0] == 0x81U || frame->data[0] == 0x82U) &&
               frame->data[1] <= 1U) {
        run->watch.level_until_us = 0; /* reset */
    }
    if (frame->id == FIRST_SERVER && sender != BENCH_BUS_NAVCOMP && is_write(frame, COMMAND_OBJECT, 2)) {
        run->command_asked = (tumble_command_t)frame->data[4];
        run->abort_asked = frame->data[4] == TUMBLE_COMMAND_ABORT;
        bench_watch_decide(run, run->command_asked, false);
        if (!run->abort_asked) {
            bench_watch_commanded(run);
        }
    } else if (sender == BENCH_BUS_NAVCOMP && (frame->id == 0x581U || frame->id == 0x381U) && frame->length == 8U) {
        note_answer(run, frame);
    } else if (sender == BENCH_BUS_NAVCOMP && frame->id == 0x081U && frame->length == 8U &&
               tumble_get_u16(frame->data) == TUMBLE_KEEPER_EMCY_DECAYED) {
        run->watch.told = true;
    }
}

void bench_watch_check(seeded_run_t *run)
{
    check_table(run);
    if (!run->world->off) {
        check_level(run);
        check_number(run);
        check_sets(run);
    }
}
