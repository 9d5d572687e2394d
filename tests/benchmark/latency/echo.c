/* echo.c - the least that answers a frame on a CAN interface: wait in read, write the same bytes with another identifier.
 *
 *   echo INTERFACE
 */
#define _GNU_SOURCE

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <sys/socket.h>
#include <unistd.h>

#define REQUEST 0x5F0U
#define ANSWER 0x5F1U

int main(int count, char **arguments)
{
    const int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    const struct sockaddr_can address = {.can_family = AF_CAN,
                                         .can_ifindex = (count == 2) ? (int)if_nametoindex(arguments[1]) : 0};
    struct can_frame frame;
    if (fd < 0 || address.can_ifindex == 0 || bind(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        perror("echo");
        return 2;
    }
    while (read(fd, &frame, sizeof frame) == (ssize_t)sizeof frame) {
        if (frame.can_id == REQUEST) {
            frame.can_id = ANSWER;
            if (write(fd, &frame, sizeof frame) != (ssize_t)sizeof frame) {
                break;
            }
        }
    }
    perror("echo");
    return 1;
}
