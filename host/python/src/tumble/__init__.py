"""Calibrate a three-axis block of navigation accelerometers on a single-axis rotary stand, and prove how good it is."""

__version__ = "0.1.0"
