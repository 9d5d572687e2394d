/* navcomp_internal.h - what the files of navcomp share (private to it).
 *
 *     step.c             init, the step, deadlines
 *     navcomp_events.c   what the node tells: heartbeats, emergencies, process data, resets; who watches whom
 *     navcomp_objects.c  the object dictionary's values
 *     navcomp_report.c   commands and the readable side
 *     service.c          the service level, and how many runs there were
 */
#ifndef TUMBLE_NAVCOMP_NAVCOMP_INTERNAL_H
#define TUMBLE_NAVCOMP_NAVCOMP_INTERNAL_H

#include "stand/bounds.h"
#include "tumble/navcomp.h"

/* tumble_navcomp_t.restart */
enum { RESTART_NONE = 0, RESTART_COMMUNICATION, RESTART_APPLICATION };

extern const tumble_node_events_t tumble_navcomp_node_events;
extern const tumble_object_hooks_t tumble_navcomp_object_hooks;

static inline bool tumble_is_on_bus(const tumble_navcomp_t *navcomp)
{
    return navcomp->config->stand_node != 0U;
}

static inline bool tumble_has_block(const tumble_navcomp_t *navcomp)
{
    return navcomp->config->source == NULL;
}

static inline tumble_state_t tumble_run_state(const tumble_navcomp_t *navcomp)
{
    return navcomp->procedure.state;
}

/* A run is on, or could go on: then nobody may change what it depends on. */
static inline bool tumble_run_is_on(const tumble_navcomp_t *navcomp)
{
    const tumble_state_t state = tumble_run_state(navcomp);
    return (state != TUMBLE_STATE_IDLE) && (state != TUMBLE_STATE_DONE) && (state != TUMBLE_STATE_ABORT);
}

/* Read an entry of the dictionary: its source tells the struct, its offset the place of the member there. */
tumble_abort_t tumble_show_member(const void *structure, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size);

/* The arguments of commands as the SDO client that is served now has staged them; else those of the first. */
static inline tumble_navcomp_objects_t *tumble_staged(const tumble_navcomp_t *navcomp)
{
    return navcomp->node.dictionary.variables;
}

/* Obey a command that the keeper has not taken. Returns as tumble_navcomp_command. */
tumble_status_t tumble_navcomp_obey(tumble_navcomp_t *navcomp, tumble_command_t command, uint8_t argument);

/* Set 1016h and 1017h as configured, instead of the dictionary's power-on values. */
void tumble_set_heartbeats(tumble_navcomp_t *navcomp, uint64_t now_us);

/* Are 1016h and 1017h such that stand and block are watched, and hear us, as configured? */
bool tumble_is_supervised(const tumble_navcomp_t *navcomp);

/* A frame came that is no service of this node. True: nobody but this node may send it (set-points for the stand, by
 * process data or by SDO, and the heartbeat of its number); the stand has been told. */
bool tumble_notice_foreign(tumble_navcomp_t *navcomp, const tumble_can_frame_t *frame);

/* Tell the procedure whether the block is alive: it streams, or samples come from another source. */
void tumble_tell_block_alive(tumble_navcomp_t *navcomp);

#endif
