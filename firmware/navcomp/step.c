/* step.c - the computer's init, its step, its deadlines: the one file of navcomp that knows the others. None of them
 * calls it back: they leave what it must know in the object (restart, woken, more, due_us).
 *
 * A step has a short way and a long one, for most frames are halves of samples:
 *
 *     port --> drain_bus --+-- 683h, 693h --> block receiver --> take_sample --> procedure (gates, exact sums)
 *                          |                                                 `-> keeper (temperature)
 *                          |
 *                          `-- others ------> node (SDO, NMT, heartbeats, PDOs) --> advance: stand, procedure, node
 *
 *     only samples, no deadline over, state as before  --> return
 *     anything else                                    --> advance, keeper, next deadline
 *
 * What follows from a sample shows in the state of the procedure. A frame of another kind is followed up at once, so
 * the result does not depend on how many frames wait when a step begins, and a replay gives the same bits.
 */
#include "navcomp/navcomp_internal.h"

#include "core/arith.h"
#include "core/one_copy.h"
#include "navcomp/uncertainty.h"

#include <stddef.h>
#include <string.h>

#define US_PER_MS 1000U
#define RETRY_US 1000U /* after the port had no room or was off the bus */
#define MAX_NODE 127U
#define WATCH_MS 100U /* the bounds of a motion are looked at so often at least */
#define STATE_PDO 2U  /* the first two belong to the drive */

/* Getting ready. */

/* 0 stands for a node that is not there: nobody has that. */
static bool nodes_are_distinct(const tumble_navcomp_config_t *config)
{
    const uint8_t stand = config->stand_node;
    const uint8_t block = (config->source == NULL) ? config->block_node : 0U;
    return (stand != config->node) && (block != config->node) && ((stand != block) || (stand == 0U));
}

static bool is_node(uint8_t node)
{
    return (node >= 1U) && (node <= MAX_NODE);
}

/* The longest silence that is not yet a fault must be shorter than the longest gap that eight bits can tell from a step
 * back. It is noticed up to a heartbeat late, because samples alone do not make a step read the clock. */
static bool counter_outlasts_silence(const tumble_navcomp_config_t *config)
{
    const uint64_t silence_ms = (uint64_t)config->procedure->sample_timeout_ms + config->heartbeat_ms;
    return (silence_ms * US_PER_MS) <= ((uint64_t)TUMBLE_BLOCK_MAX_GAP * config->block_period_us);
}

/* The stand checks its own node number; but a kind that is never on the bus must have none. */
static bool has_stand(const tumble_navcomp_config_t *config)
{
    const tumble_stand_kind_t *kind = config->stand;
    return (kind != NULL) && (config->stand_memory != NULL) && (config->stand_bytes >= kind->bytes) &&
           ((config->stand_node == 0U) || (kind->heartbeat != NULL));
}

static bool is_usable(const tumble_navcomp_config_t *config)
{
    return (config != NULL) && (config->port != NULL) && (config->procedure != NULL) && has_stand(config) &&
           ((config->source != NULL) || (is_node(config->block_node) && counter_outlasts_silence(config))) &&
           nodes_are_distinct(config) && (config->heartbeat_ms != 0U) && (config->heartbeat_timeout_ms != 0U);
}

static tumble_status_t init_stand(tumble_navcomp_t *navcomp)
{
    const tumble_navcomp_config_t *config = navcomp->config;
    const tumble_stand_setup_t setup = {
        .profile = config->stand_profile,
        .node = &navcomp->node,
        .mirror = &navcomp->mirror,
        .cable_min_deg = config->procedure->cable_min_deg,
        .cable_max_deg = config->procedure->cable_max_deg,
        .stand_node = config->stand_node,
    };
    return navcomp->stand.kind->init(navcomp->stand.self, &setup);
}

/* All that a fresh node needs, at power-on and after an NMT reset. */
static tumble_status_t join_bus(tumble_navcomp_t *navcomp, uint64_t now_us)
{
    tumble_set_heartbeats(navcomp, now_us);
    tumble_node_set_state(&navcomp->node, TUMBLE_NMT_OPERATIONAL);
    tumble_block_receiver_restart(&navcomp->block);
    navcomp->block_start_us = 0;
    return init_stand(navcomp);
}

static tumble_status_t init_procedure(tumble_navcomp_t *navcomp)
{
    navcomp->procedure_config = *navcomp->config->procedure;
    navcomp->objects = tumble_navcomp_objects_initial;
    if (navcomp->config->second_client != NULL) {
        navcomp->config->second_client->objects = tumble_navcomp_objects_initial;
    }
    const tumble_status_t status =
        tumble_procedure_init(&navcomp->procedure, &navcomp->procedure_config, &navcomp->stand);
    tumble_tell_block_alive(navcomp);
    return status;
}

TUMBLE_ONE_COPY static tumble_status_t init_node(tumble_navcomp_t *navcomp)
{
    const tumble_keeping_t *keeping = navcomp->config->keeping;
    navcomp->node_config = (tumble_node_config_t){
        .table = &tumble_navcomp_table,
        .extension = (keeping != NULL) ? keeping->objects : NULL,
        .defaults = &tumble_navcomp_defaults,
        .hooks = &tumble_navcomp_object_hooks,
        .events = &tumble_navcomp_node_events,
        .node = navcomp->config->node,
    };
    tumble_second_client_t *second = navcomp->config->second_client;
    if (second != NULL) {
        second->server.variables = &second->objects;
    }
    const tumble_node_binding_t binding = {
        .port = navcomp->config->port,
        .second = (second != NULL) ? &second->server : NULL,
        .variables = &navcomp->objects,
        .other = &navcomp->mirror,
        .context = navcomp,
    };
    return tumble_node_init(&navcomp->node, &navcomp->node_config, &binding);
}

tumble_status_t tumble_navcomp_init(tumble_navcomp_t *navcomp, const tumble_navcomp_config_t *config)
{
    if ((navcomp == NULL) || !is_usable(config)) {
        return TUMBLE_E_ARGUMENT;
    }
    *navcomp = (tumble_navcomp_t){.config = config, .stand = {config->stand, config->stand_memory}};
    (void)memset(config->stand_memory, 0, config->stand->bytes);
    if ((config->declared != NULL) && (config->declared->noise != NULL)) {
        *config->declared->noise = (tumble_run_noise_t){.looked = false};
    }
    tumble_status_t status = init_node(navcomp);
    if (status == TUMBLE_OK) {
        status = join_bus(navcomp, config->port->now_us(config->port->context));
    }
    if (status == TUMBLE_OK) {
        status = init_procedure(navcomp);
    }
    return ((status == TUMBLE_OK) && (config->keeping != NULL)) ? config->keeping->init(config->keeper, navcomp)
                                                                : status;
}

/* After an NMT reset, which has ended the run, bring the axis up again from the start. The reason of the run stays
 * readable. */
static void restart(tumble_navcomp_t *navcomp, uint64_t now_us)
{
    const bool application = (navcomp->restart == RESTART_APPLICATION);
    const bool aborted = (navcomp->procedure.state == TUMBLE_STATE_ABORT);
    navcomp->restart = RESTART_NONE;
    (void)join_bus(navcomp, now_us); /* as it passed at power-on */
    if (application) {
        (void)init_procedure(navcomp);
        navcomp->procedure.reason = aborted ? TUMBLE_REASON_COMMAND : TUMBLE_REASON_NONE;
        if (navcomp->config->keeping != NULL) {
            navcomp->config->keeping->reset(navcomp->config->keeper);
        }
    }
}

/* The step. */

/* The state PDO goes when one of these has changed, and by its event timer. */
static void show_state(tumble_navcomp_t *navcomp)
{
    const uint32_t shown = tumble_procedure_mark(&navcomp->procedure);
    if (shown != navcomp->shown) {
        navcomp->shown = shown;
        tumble_pdo_trigger(&navcomp->node.pdos, STATE_PDO);
    }
}

static uint32_t motion_margin_ms(const tumble_navcomp_t *navcomp)
{
    const uint32_t ms = navcomp->procedure_config.motion_margin_ms;
    return (ms != 0U) ? ms : TUMBLE_MOTION_MARGIN_MS;
}

static void advance(tumble_navcomp_t *navcomp, uint64_t now_us)
{
    tumble_stand_step(&navcomp->stand, now_us, motion_margin_ms(navcomp));
    tumble_procedure_step(&navcomp->procedure, now_us);
    show_state(navcomp);
    tumble_node_step(&navcomp->node, now_us);
}

static void take_sample(tumble_navcomp_t *navcomp, const tumble_block_sample_t *sample)
{
    const tumble_navcomp_hooks_t *hooks = navcomp->config->hooks;
    const tumble_declared_t *declared = navcomp->config->declared;
    const tumble_keeping_t *keeping = navcomp->config->keeping;
    tumble_taken_t taken;
    navcomp->temperature_half_c = sample->temperature_half_c;
    const bool averaged = tumble_procedure_sample(&navcomp->procedure, sample, &taken);
    if (averaged && (hooks != NULL) && (hooks->on_sample_averaged != NULL)) {
        hooks->on_sample_averaged(hooks->context, taken, sample);
    }
    if (averaged && (declared != NULL) && (declared->take != NULL)) {
        declared->take(navcomp, taken, sample);
    }
    if (keeping != NULL) {
        keeping->sample(navcomp->config->keeper, sample, averaged);
    }
}

/* False: the frame is not the block's. Not inlined, here and in drain_source, so that the sample does not lie on the
 * stack below everything that other frames set going. */
TUMBLE_ONE_COPY static bool take_block_frame(tumble_navcomp_t *navcomp, const tumble_can_frame_t *frame)
{
    const uint32_t lost_before = navcomp->block.counters.lost;
    tumble_block_sample_t sample;
    const tumble_block_event_t event = tumble_block_receive(&navcomp->block, frame, &sample);
    if (event == TUMBLE_BLOCK_SAMPLE) {
        const uint32_t lost = navcomp->block.counters.lost - lost_before;
        if (lost != 0U) {
            tumble_procedure_sample_faults(&navcomp->procedure, 0, (uint16_t)lost);
        }
        take_sample(navcomp, &sample);
    } else if (event == TUMBLE_BLOCK_CORRUPTED) {
        tumble_procedure_sample_faults(&navcomp->procedure, 1, 0);
    } else {
        /* half a sample, or one that came before: counted by the receiver */
    }
    return event != TUMBLE_BLOCK_OTHER;
}

/* There is an axis that must be stopped if need be. */
static bool has_axis(const tumble_navcomp_t *navcomp)
{
    return tumble_is_on_bus(navcomp) && navcomp->stand.kind->is_present(navcomp->stand.self);
}

static void take_other_frame(tumble_navcomp_t *navcomp, const tumble_can_frame_t *frame, uint64_t now_us)
{
    navcomp->woken = true;
    navcomp->node.server.held = tumble_run_is_on(navcomp) || has_axis(navcomp);
    navcomp->node.server.service = tumble_service_is_open(navcomp);
    if (!tumble_node_receive(&navcomp->node, frame, now_us)) {
        tumble_count(&navcomp->events.frames_ignored);
        if (!tumble_notice_foreign(navcomp, frame)) {
            return;
        }
    }
    if (navcomp->restart != RESTART_NONE) {
        restart(navcomp, now_us);
    }
    advance(navcomp, now_us);
}

static void drain_bus(tumble_navcomp_t *navcomp, uint64_t now_us)
{
    tumble_can_frame_t frame;
    for (int taken = 0; taken < TUMBLE_NAVCOMP_MAX_FRAMES_PER_STEP; taken++) {
        const tumble_status_t status = tumble_link_receive(&navcomp->node.link, &frame);
        if ((status != TUMBLE_OK) && (status != TUMBLE_E_FRAME)) {
            return;
        }
        if ((status == TUMBLE_OK) && !((navcomp->config->source == NULL) && take_block_frame(navcomp, &frame))) {
            take_other_frame(navcomp, &frame, now_us);
        }
    }
    navcomp->more = true;
}

TUMBLE_ONE_COPY static void drain_source(tumble_navcomp_t *navcomp)
{
    const tumble_sample_source_t *source = navcomp->config->source;
    tumble_block_sample_t sample;
    for (int taken = 0; taken < TUMBLE_NAVCOMP_MAX_FRAMES_PER_STEP; taken++) {
        const tumble_status_t status = source->take(source->context, &sample);
        if (status == TUMBLE_OK) {
            take_sample(navcomp, &sample);
        } else if ((status == TUMBLE_E_CRC) || (status == TUMBLE_E_FRAME)) {
            tumble_count(&navcomp->events.source_corrupted);
            tumble_procedure_sample_faults(&navcomp->procedure, 1, 0);
        } else {
            if (status != TUMBLE_E_PORT_EMPTY) {
                tumble_count(&navcomp->events.source_faults);
            }
            return;
        }
    }
    navcomp->more = true;
}

/* The block is known to be there and does not stream. */
static bool block_waits(const tumble_navcomp_t *navcomp)
{
    const tumble_nmt_state_t state = tumble_nmt_state_of(&navcomp->node.nmt, navcomp->config->block_node);
    return tumble_has_block(navcomp) && (state != TUMBLE_NMT_UNKNOWN) && (state != TUMBLE_NMT_OPERATIONAL);
}

/* The duties of the NMT master: itself and the block Operational (the stand brings up its drive). */
static void keep_operational(tumble_navcomp_t *navcomp, uint64_t now_us)
{
    const tumble_nmt_state_t own = tumble_node_state(&navcomp->node);
    if ((own != TUMBLE_NMT_INITIALISING) && (own != TUMBLE_NMT_OPERATIONAL)) {
        tumble_node_set_state(&navcomp->node, TUMBLE_NMT_OPERATIONAL);
    }
    if (block_waits(navcomp) && (now_us >= navcomp->block_start_us)) {
        (void)tumble_nmt_command(&navcomp->node.nmt, navcomp->config->block_node, TUMBLE_NMT_START);
        tumble_count(&navcomp->events.starts);
        navcomp->block_start_us = now_us + ((uint64_t)navcomp->config->heartbeat_timeout_ms * US_PER_MS);
    }
}

/* The keeper's step, which may set all others going, and when the next one of all is due. */
static uint64_t end_step(tumble_navcomp_t *navcomp)
{
    const tumble_keeping_t *keeping = navcomp->config->keeping;
    const uint32_t most_ms = (navcomp->config->heartbeat_ms < WATCH_MS) ? navcomp->config->heartbeat_ms : WATCH_MS;
    uint64_t due_us = navcomp->stepped_us + ((uint64_t)most_ms * US_PER_MS);
    if (keeping != NULL) {
        due_us = tumble_earlier(due_us, keeping->step(navcomp->config->keeper, navcomp->stepped_us));
    }
    const tumble_status_t last = navcomp->node.link.last;
    const bool is_bus_off = (last == TUMBLE_E_PORT_DOWN); /* now by what was sent as well */
    tumble_procedure_set_bus_up(&navcomp->procedure, !is_bus_off);
    navcomp->more = navcomp->more || is_bus_off;
    due_us = tumble_earlier(due_us, tumble_node_next_us(&navcomp->node));
    due_us = tumble_earlier(due_us, tumble_procedure_next_us(&navcomp->procedure));
    due_us = tumble_earlier(due_us, navcomp->stand.kind->next_us(navcomp->stand.self));
    if (block_waits(navcomp)) {
        due_us = tumble_earlier(due_us, navcomp->block_start_us);
    }
    if (navcomp->more) {
        due_us = 0;
    }
    const bool refused = is_bus_off || (last == TUMBLE_E_PORT_BUSY);
    const uint64_t retry_us = navcomp->stepped_us + RETRY_US;
    return (refused && (due_us < retry_us)) ? retry_us : due_us;
}

/* The bus is off when the port says so in receiving, or in sending at the end of a step, where frames that it did not
 * take are offered again. While the bus is off every step takes the long way, until it is back. */
void tumble_navcomp_step(tumble_navcomp_t *navcomp)
{
    const tumble_port_t *port = navcomp->config->port;
    const tumble_state_t before = navcomp->procedure.state;
    const uint64_t read_us = port->now_us(port->context);
    const uint64_t now_us = (read_us > navcomp->stepped_us) ? read_us : navcomp->stepped_us;
    navcomp->stepped_us = now_us;
    navcomp->more = false;
    navcomp->woken = (now_us >= navcomp->due_us);
    if ((navcomp->service_until_us != 0U) && (now_us >= navcomp->service_until_us)) {
        (void)tumble_service_unlock(navcomp, 0);
        navcomp->woken = true;
    }
    drain_bus(navcomp, now_us);
    if (navcomp->config->source != NULL) {
        drain_source(navcomp);
    }
    const bool is_bus_off = (navcomp->node.link.last == TUMBLE_E_PORT_DOWN);
    if (!navcomp->woken && !navcomp->more && !is_bus_off && (navcomp->procedure.state == before)) {
        return; /* nothing but samples, and they changed nothing: so it is with most steps */
    }
    if (is_bus_off) {
        tumble_procedure_set_bus_up(&navcomp->procedure, false);
    }
    keep_operational(navcomp, now_us);
    advance(navcomp, now_us);
    navcomp->due_us = end_step(navcomp);
}

uint64_t tumble_navcomp_next_deadline_us(const tumble_navcomp_t *navcomp)
{
    return navcomp->due_us;
}
