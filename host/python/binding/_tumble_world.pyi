"""The types of the extension of the simulated world (host/world/border.h): as those of the core's."""

from _tumble_core import ffi as ffi, lib as lib
