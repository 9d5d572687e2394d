/* notify.h - tell the manager of services (systemd, Type=notify), where one wants to know. */
#ifndef TUMBLE_GATEWAY_NOTIFY_H
#define TUMBLE_GATEWAY_NOTIFY_H

/* Send a state such as "READY=1" to the socket that NOTIFY_SOCKET names; without one do nothing. */
void notify_manager(const char *state);

#endif
