/* conformance-socketcan INTERFACE NV-FILE: the conformance suite on a CAN interface of Linux, two sockets of one process,
 * and on the file of a non-volatile memory.
 *
 * The interface must be one that nobody else uses, such as a virtual one; the file loses what is in it. Exit codes: 0 conforms, 1 does not, 2 no such
 * interface, 77 this kernel has no CAN. */
#define _POSIX_C_SOURCE 200809L

#include "conformance_print.h"
#include "nv_file.h"
#include "port_linux.h"

#include <time.h>

static void pass(void *context, uint32_t us)
{
    const struct timespec pause = {us / 1000000U, (long)(us % 1000000U) * 1000L};
    (void)context;
    (void)nanosleep(&pause, NULL);
}

static const char *nv_path;
static nv_file_t nv;

static const tumble_nv_t *reopen(void *context)
{
    (void)context;
    nv_file_close(&nv);
    return (nv_file_open(&nv, nv_path) == NULL) ? &nv.nv : NULL;
}

static int open_both(port_linux_t linux_ports[2], tumble_port_t ports[2], const char *interface, const char *path)
{
    for (int n = 0; n < 2; n++) {
        const can_socket_status_t status = port_linux_open(&linux_ports[n], &ports[n], interface);
        if (status != CAN_SOCKET_OK) {
            (void)printf("%s: %s\n", interface, can_socket_sentence(status));
            return (status == CAN_SOCKET_NO_CAN) ? 77 : 2;
        }
    }
    nv_path = path;
    const char *const wrong = nv_file_open(&nv, path);
    if (wrong != NULL) {
        (void)printf("%s: %s\n", path, wrong);
        return 2;
    }
    ports[0].nv = &nv.nv;
    return 0;
}

int main(int count, char *arguments[])
{
    static port_linux_t linux_ports[2];
    tumble_port_t ports[2];
    if (count != 3) {
        (void)fputs("usage: conformance-socketcan INTERFACE NV-FILE\n", stderr);
        return 2;
    }
    const int opened = open_both(linux_ports, ports, arguments[1], arguments[2]);
    if (opened != 0) {
        return opened;
    }
    const conformance_bench_t bench = {.a = &ports[0],
                                       .b = &ports[1],
                                       .pass = pass,
                                       .burst = 5000,   /* half of what the receive buffer is to hold */
                                       .send_limit = 0, /* a virtual interface takes whatever comes */
                                       .transit_us = 200,
                                       .set_off = NULL,    /* both ports would be off */
                                       .erase_us = 100000, /* a disk that is slow */
                                       .reopen = reopen,
                                       .report = conformance_print};
    const uint32_t failed = conformance_run(&bench);
    for (int n = 0; n < 2; n++) {
        (void)printf("port %d: sent %llu, received %llu, dropped by the kernel %llu\n", n,
                     (unsigned long long)linux_ports[n].can.counters.sent,
                     (unsigned long long)linux_ports[n].can.counters.received,
                     (unsigned long long)linux_ports[n].can.counters.dropped);
        port_linux_close(&linux_ports[n]);
    }
    nv_file_close(&nv);
    return (failed == 0U) ? 0 : 1;
}
