/* tumble-gateway: Modbus on one side, the navigation computer on a CAN interface of Linux on the other. */
#include "port_linux.h"
#include "server.h"

#include <stdio.h>

static int refuse(const char *interface, can_socket_status_t status)
{
    (void)fprintf(stderr, "tumble-gateway: %s: %s\n", interface, can_socket_sentence(status));
    if (status == CAN_SOCKET_NO_CAN) {
        return GATEWAY_EXIT_SKIPPED;
    }
    return (status == CAN_SOCKET_NO_INTERFACE) ? GATEWAY_EXIT_USAGE : GATEWAY_EXIT_FAULT;
}

int main(int count, char *arguments[])
{
    static port_linux_t bus;
    tumble_port_t port;
    gateway_options_t options;
    if (!gateway_options_read(&options, count, arguments)) {
        return GATEWAY_EXIT_USAGE;
    }
    if (options.asks != BENCH_ASKS_WORK) {
        return bench_tell("tumble-gateway", options.asks, gateway_options_help) ? GATEWAY_EXIT_TOLD
                                                                                : GATEWAY_EXIT_FAULT;
    }
    const can_socket_status_t status = port_linux_open(&bus, &port, options.can);
    if (status != CAN_SOCKET_OK) {
        return refuse(options.can, status);
    }
    const int code = gateway_serve(&options, &port, bus.can.fd);
    port_linux_close(&bus);
    return code;
}
