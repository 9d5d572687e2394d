"""Calibrate a three-axis block of navigation accelerometers on a single-axis rotary stand, and prove how good it is."""

from tumble._version import __version__ as __version__
