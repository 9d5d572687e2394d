"""A Modbus server that looks like tumble-gateway, and whose answers a test spoils."""

import socket
import struct
import threading
from contextlib import suppress

from tumble.client.link import read_map

READ_INPUT = 4


class FalseGateway:
    """It has a new snapshot at every look, with every value valid; all that is not in `values`, by name, is 0. `spoil`:
    makes another answer of (function, words), None: none; it may be changed at any time. `asked`: how many requests."""

    def __init__(self, spoil=lambda function, words: (function, words), **values):
        self.spoil, self.asked = spoil, 0
        self.values = {"Magic word": 0x54554D42, "Known number": 123456.0, "Link state": 1, **values}
        self._server = socket.create_server(("127.0.0.1", 0))
        self.link = f"modbus:127.0.0.1:{self._server.getsockname()[1]}"
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        with suppress(OSError):
            while True:
                threading.Thread(target=self._talk, args=self._server.accept()[:1], daemon=True).start()

    def _talk(self, client):
        with client, client.makefile("rb") as stream, suppress(OSError):
            while len(head := stream.read(7)) == 7:
                transaction, _, length, unit = struct.unpack(">HHHB", head)
                function, at, count = struct.unpack_from(">BHH", stream.read(length - 1))
                self.asked += 1
                answer = self.spoil(function, self._words(at, count))
                if answer is None:
                    return
                pdu = struct.pack(f">BB{len(answer[1])}H", answer[0], 2 * len(answer[1]), *answer[1])
                client.sendall(struct.pack(">HHHB", transaction, 0, len(pdu) + 1, unit) + pdu)

    def _words(self, at, count):
        image = dict.fromkeys(range(at, at + count), 0)
        values = {"Snapshot number": self.asked, **self.values}
        for name, registers in read_map().input.items():
            for one in registers:
                if one.valid is not None and one.valid[0] in image:
                    image[one.valid[0]] |= 1 << one.valid[1]
                if name in values and one.type != "text":
                    image |= {one.at + place: word for place, word in enumerate(one.pack(values[name]))}
        return [image[at + place] for place in range(count)]

    def close(self):
        """Nobody can connect any more."""
        self._server.close()
