"""Node 1 behind tumble-gateway as a test plays it: the harness answers the gateway, and a thread decides what becomes
of what is written."""

import threading


class PlayedBehindGateway(threading.Thread):
    """`gateway`: of gateway_bench.py. A write is answered when `take` has returned, so all objects are by then as it
    makes them."""

    def __init__(self, gateway):
        super().__init__(daemon=True)
        self.gateway = gateway

    def begin(self):
        """Once the objects are as they are at first."""
        self.gateway.tell("boot")
        self.gateway.tell("play 1")
        self.start()

    def set(self, index, sub, data):
        """An object has these bytes, or none; the node has not booted for that."""
        self.gateway.set(index, sub, data, boot=False)

    def run(self):
        """Until the gateway has ended."""
        while line := self.gateway.written.get():
            _, index, sub, *data = line.split()
            self.take((int(index, 16), int(sub)), bytes.fromhex("".join(data)))
            self.gateway.tell("played")

    def take(self, entry, data):
        """What somebody wrote: (index, subindex), bytes."""
        raise NotImplementedError
