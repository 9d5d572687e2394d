"""Calibrate a three-axis block of navigation accelerometers on a single-axis rotary stand, and prove how good it is.

Public are `tumble.__version__`, `tumble.canbus.TumbleBus` (the simulated bus for python-can), and the command line,
`python -m tumble`. All else may change with any version. It stands in rooms, each of which says what it offers:

    core, reference     the firmware core, and its numpy witness, which knows nothing of it
    files               run files, stand files, schedule files
    solving             from a run to a stated result
    fixture, planning   what runs tell of a stand; what a stand is worth before any run
    bench, store        simulated stands and real buses; the memory of a navigation computer
    cli                 the command line

Beside them is what all share: plain data (schedule, stand, estimators, units), errors, messages, interruption.
tools/rooms.py checks which room knows which.
"""

from tumble._version import __version__ as __version__
