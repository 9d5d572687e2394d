"""The simulated bus of tumble-bench as a bus of python-can: so python-can, python-canopen and cantools take part in it.

    tumble-bench --listen /tmp/bench.socket &
    with TumbleBus("/tmp/bench.socket") as bus: ...

or, where the package is installed, `can.Bus(interface="tumble", channel="/tmp/bench.socket")`. Needs python-can. The
records that go through the local socket are described in host/bench/guests.h.
"""

from __future__ import annotations

import select
import socket
import struct
import threading
import time
from typing import Any

import can

_RECORD = struct.Struct("<IB3x8s")
_TURN = 0x80000000
_UNITS_PER_DEG = 1e5


class TumbleBus(can.BusABC):
    """One guest on the bus. `channel`: path of the socket; `patience_s`: how long to wait until somebody listens there.

    Classic data frames with 11-bit identifiers only. Raises can.CanInitializationError, can.CanOperationError.
    """

    def __init__(self, channel: str, patience_s: float = 5.0, **options: Any):
        self._socket = _connect(str(channel), patience_s)
        self._rest = b""
        self._sending = threading.Lock()
        self.channel_info = f"tumble-bench at {channel}"
        super().__init__(channel=channel, **options)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Put a frame on the bus; it takes part in arbitration."""
        if msg.is_extended_id or msg.is_remote_frame or msg.is_fd or msg.is_error_frame:
            raise can.CanOperationError("only classic data frames with 11-bit identifiers can be sent")
        self._send(msg.arbitration_id, bytes(msg.data))

    def turn_table(self, angle_deg: float, speed_deg_s: float) -> None:
        """Turn the table of the stand, for a drive that runs outside (present.drive = no). No frame of the bus."""
        units = round(angle_deg * _UNITS_PER_DEG), max(1, round(speed_deg_s * _UNITS_PER_DEG))
        self._send(_TURN, struct.pack("<iI", *units))

    def _send(self, identifier: int, data: bytes) -> None:
        try:
            with self._sending:
                self._socket.sendall(_RECORD.pack(identifier, len(data), data))
        except OSError as error:
            raise can.CanOperationError(f"the bench is gone: {error.strerror}") from error

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        end = None if timeout is None else time.monotonic() + timeout
        while len(self._rest) < _RECORD.size:
            left = None if end is None else max(0.0, end - time.monotonic())
            if not select.select([self._socket], [], [], left)[0]:
                return None, False
            try:
                received = self._socket.recv(4096)
            except OSError as error:
                raise can.CanOperationError(f"the bench is gone: {error.strerror}") from error
            if not received:
                raise can.CanOperationError("the bench has ended")
            self._rest += received
        identifier, length, data = _RECORD.unpack_from(self._rest)
        self._rest = self._rest[_RECORD.size :]
        message = can.Message(
            timestamp=time.time(),
            arbitration_id=identifier,
            is_extended_id=False,
            data=data[:length],
            channel=self.channel_info,
        )
        return message, False

    def fileno(self) -> int:
        """For those who wait for several things at once."""
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Leave the bus."""
        super().shutdown()
        self._socket.close()


def _connect(path: str, patience_s: float) -> socket.socket:
    end = time.monotonic() + patience_s
    while True:
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            connection.connect(path)
            return connection
        except OSError as error:
            connection.close()
            if time.monotonic() > end or not isinstance(error, (FileNotFoundError, ConnectionRefusedError)):
                raise can.CanInitializationError(f"{path}: {error.strerror}") from error
            time.sleep(0.02)
