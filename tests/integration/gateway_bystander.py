"""A well-behaved client of tumble-gateway, in a process of its own: asks every 2 ms, checks every answer, notes how
long it took. `gateway_bystander.py PORT`: prints "ready" after the first answer (who has asked nothing has no claim to
its place), and when its input ends p95, maximum (ms) and number as JSON; exit 1 at a wrong answer, which it prints."""

import json
import select
import socket
import struct
import sys
import time

REQUEST = struct.pack(">HHHBBHH", 7, 0, 6, 1, 4, 0, 2)
ANSWER = struct.pack(">HHHBBBHH", 7, 0, 7, 1, 4, 4, 0x5455, 0x4D42)


def main(port):
    client, times = socket.create_connection(("127.0.0.1", port), timeout=10), []
    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    while not (times and select.select([sys.stdin], [], [], 0.002)[0]):
        began = time.perf_counter()
        client.sendall(REQUEST)
        answer = client.recv(len(ANSWER), socket.MSG_WAITALL)
        times.append(1e3 * (time.perf_counter() - began))
        if answer != ANSWER:
            print(answer)
            return 1
        if len(times) == 1:
            print("ready", flush=True)
    times.sort()
    print(json.dumps([times[int(0.95 * (len(times) - 1))], times[-1], len(times)]))
    return 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
