#include "link_log.h"

#include "event_log.h"

void link_log_look(link_log_t *told, const can_socket_t *can)
{
    if (can->counters.downs != told->downs) {
        event_log_tell(EVENT_LOG_WARNING, "link", EVENT_FIELDS(EVENT_TEXT("link", "down")), "the interface %s is down",
                       can->name);
        told->is_down = true;
    }
    told->downs = can->counters.downs;
    if (told->is_down && !can->is_down) {
        event_log_tell(EVENT_LOG_NOTICE, "link", EVENT_FIELDS(EVENT_TEXT("link", "up")), "the interface %s is up again",
                       can->name);
        told->is_down = false;
    }
}
