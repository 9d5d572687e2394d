/* tumble-gateway: Modbus on one side, the navigation computer on a CAN interface of Linux on the other. */
#include "port_linux.h"
#include "server.h"

#include <stdio.h>

int main(int count, char *arguments[])
{
    static port_linux_t bus;
    tumble_port_t port;
    gateway_options_t options;
    if (!gateway_options_read(&options, count, arguments)) {
        return BENCH_EXIT_USAGE;
    }
    if (options.asks != BENCH_ASKS_WORK) {
        return bench_tell("tumble-gateway", options.asks, gateway_options_help) ? BENCH_EXIT_PASS : BENCH_EXIT_FAULT;
    }
    const can_socket_status_t status = port_linux_open(&bus, &port, options.can);
    if (status != CAN_SOCKET_OK) {
        return can_socket_refuse(options.can, status);
    }
    const int code = gateway_serve(&options, &port, bus.can.fd);
    port_linux_close(&bus);
    return code;
}
