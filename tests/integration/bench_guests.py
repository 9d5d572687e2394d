"""python-canopen as a guest on the bus of tumble-bench."""

import contextlib

import can
import canopen


class _Patient(can.Listener):
    """The bench ends when it has finished, and the receiving thread then has nothing to complain of."""

    def on_message_received(self, msg):
        """Not for us."""

    def on_error(self, exc):
        """Nor is this."""


def connected(bus):
    """A network on a bus."""
    network = canopen.Network(bus)
    network.NOTIFIER_CYCLE = 0.01
    network.listeners.append(_Patient())
    network.connect()
    return network


def disconnect(network):
    """Leave, whether or not the bench has ended before."""
    with contextlib.suppress(can.CanOperationError):
        network.disconnect()
    if network.bus is not None:
        network.bus.shutdown()
