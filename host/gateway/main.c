/* tumble-gateway: Modbus on one side, the navigation computer on a CAN interface of Linux on the other. */
#include "port_linux.h"
#include "server.h"

int main(int count, char *arguments[])
{
    static port_linux_t bus;
    tumble_port_t port;
    gateway_options_t options;
    const int wrong = gateway_options_read(&options, count, arguments);
    if (wrong != ARGUMENTS_WORK) {
        return wrong;
    }
    const can_socket_status_t status = port_linux_open(&bus, &port, options.can);
    if (status != CAN_SOCKET_OK) {
        return arguments_fail_bus(options.can, status);
    }
    const int code = gateway_serve(&options, &port, bus.can.fd);
    port_linux_close(&bus);
    return code;
}
