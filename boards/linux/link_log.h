/* link_log.h - the event "link" of a program that has a CAN interface (event_log.h): the interface goes, and comes back. */
#ifndef TUMBLE_LINUX_LINK_LOG_H
#define TUMBLE_LINUX_LINK_LOG_H

#include "can_socket.h"

/* What was told last; begun as all zero. */
typedef struct {
    uint64_t downs;
    bool is_down;
} link_log_t;

/* After every step, and only while the log is on. An interface that went and is back by now is told as both. */
void link_log_look(link_log_t *told, const can_socket_t *can);

#endif
