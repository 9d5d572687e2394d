"""The bus of a simulated world for the tests of scripts (docs/client.md): as in tumble.world."""

from tumble.world.virtual_bus import VirtualBus, time_of

__all__ = ["VirtualBus", "time_of"]
