#include "stand_log.h"

#include "core/bytes.h"
#include "event_log.h"

#include <inttypes.h>
#include <unistd.h>

void stand_log_ready(const stand_options_t *options)
{
    event_log_start("tumble-stand", STDERR_FILENO);
    event_log_tell(EVENT_LOG_NOTICE, "ready",
                   EVENT_FIELDS(EVENT_TEXT("interface", options->interface), EVENT_WHOLE("seed", options->seed)),
                   "drive (node 2) and block (node 3) on %s, seed %" PRIu64, options->interface, options->seed);
}

/* The operator. */

void stand_log_answer(const stand_operator_t *before, const stand_operator_t *now, const tumble_can_frame_t *frame)
{
    const char *const name = tumble_command_name((tumble_command_t)before->command);
    if (now->answers != before->answers) {
        event_log_tell(EVENT_LOG_INFO, "command",
                       EVENT_FIELDS(EVENT_TEXT("command", name), EVENT_WHOLE("command_number", before->command),
                                    EVENT_WHOLE("argument", before->argument)),
                       "node 1 took %s (%u), argument %u", name, (unsigned)before->command, (unsigned)before->argument);
    } else if (now->refusals != before->refusals) {
        const uint32_t code = tumble_get_u32(&frame->data[4]);
        event_log_tell(EVENT_LOG_WARNING, "refused",
                       EVENT_FIELDS(EVENT_TEXT("command", name), EVENT_WHOLE("command_number", before->command),
                                    EVENT_WHOLE("abort_code", code)),
                       "node 1 refused %s (%u): abort code %08" PRIX32 "h", name, (unsigned)before->command, code);
    }
}

static void log_operator(stand_log_t *log, const bench_world_t *world)
{
    const tumble_schedule_t *const schedule = &world->config->scenario.schedule;
    for (uint32_t i = 0; i < schedule->mounting_count; i++) {
        const unsigned number = schedule->mountings[i].number;
        if (world->operator.mounted[i] != log->mounted[i]) {
            const bool inclined = world->operator.inclined;
            event_log_tell(EVENT_LOG_NOTICE, inclined ? "inclined" : "mounted",
                           EVENT_FIELDS(EVENT_WHOLE("mounting", number)),
                           inclined ? "the stand is inclined as mounting %u has it, the block still bolted on"
                                    : "the block is on the table in mounting %u",
                           number);
        }
        log->mounted[i] = world->operator.mounted[i];
    }
    if (world->operator.mended != log->mended) {
        event_log_tell(EVENT_LOG_NOTICE, "mended", NULL, "what was broken is mended");
    }
    log->mended = world->operator.mended;
}

/* What breaks. */

static void log_faults(stand_log_t *log, const bench_world_t *world)
{
    for (uint32_t i = 0; i < world->config->scenario.fault_count; i++) {
        if (world->script.states[i].times != log->faults[i]) {
            const char *const word = sim_fault_word(world->config->scenario.faults[i].kind);
            event_log_tell(EVENT_LOG_WARNING, "fault", EVENT_FIELDS(EVENT_TEXT("kind", word)),
                           "the fault %s of the scenario begins", word);
        }
        log->faults[i] = world->script.states[i].times;
    }
}

void stand_log_update(stand_log_t *log, const bench_world_t *world, const can_socket_t *can)
{
    if (!event_log_is_on()) {
        return;
    }
    log_operator(log, world);
    log_faults(log, world);
    link_log_update(&log->link, can);
}

void stand_log_end(const bench_world_t *world, int code)
{
    const bool rests = bench_world_is_at_rest(world);
    const double angle_deg = sim_axis_actual_deg(world->axis, world->clock.now_us);
    event_log_end(rests ? EVENT_LOG_NOTICE : EVENT_LOG_WARNING,
                  EVENT_FIELDS(EVENT_WHOLE("exit", (uint64_t)code), EVENT_WHOLE("at_rest", rests ? 1U : 0U)),
                  "ends with exit code %d, the table %s at %.5f deg", code, rests ? "at rest" : "still turning",
                  angle_deg);
}
