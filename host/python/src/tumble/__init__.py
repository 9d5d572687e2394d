"""Calibrate a three-axis block of navigation accelerometers on a single-axis rotary stand, and prove how good it is.

    >>> import tumble
    >>> result = tumble.solve("examples/paper_stand.csv", stand="examples/paper_stand.toml")
    >>> result.passed
    True
    >>> a_g = result.apply([[0.0, 0.0, 2.0]])  # outputs in volts -> specific force in g, (samples, 3)

Public are the names of `__all__`, the exceptions in `tumble.errors`, `tumble.testing.virtual_bus` (the simulated bus
for python-can), `tumble.data` (examples, schemas), `tumble.client`, and the command line, `python -m tumble`. They
stay; all else may change with any version. It stands in rooms, each of which says what it offers:

    core, model         the firmware core, and the numpy model of a calibration, which knows nothing of it
    files               run files, stand files, schedule files
    documents           what is written as JSON, as types
    importing           continuous recordings made run files
    acquisition         runs made on anybody's stand, by instruments that speak lines of text
    workers             work cut into pieces, on this machine or a cluster
    solving             from a run to a stated result
    fixture, planning   what runs tell of a stand; what a stand is worth before any run
    world, store        simulated stands and real buses; the memory of a navigation computer
    testing             a simulated node and stand for the tests of scripts, as a pytest plugin
    comparison          two results of one block
    pictures            of results, comparisons, recordings, campaigns, and of the stand itself
    report              a result as a document for people
    history             calibrations of many blocks: trends, alarms, when the next one is due
    client, watch       a navigation computer over CAN or Modbus, for scripts; a run as it goes, for people who look on
    data                files that come with the package
    api, cli            what scripts call; the command line

Beside them is what all share:

    schedule, stand, estimators, terms, units, defaults     plain data
    arrays, distributions, poses    arrays as types; quantiles; where the block's axes point, in words
    firmware_tables     states of a run and nodes of the bus, as the firmware has them
    errors, messages, interruption      what goes wrong, how it is told, and how a command ends early
    prompts             what only a person at the stand can do, asked

tools/rooms.py checks which room knows which.
"""

from typing import TYPE_CHECKING, Any

from tumble import errors as errors
from tumble._version import __version__ as __version__

if TYPE_CHECKING:
    from tumble.api import schedules as schedules
    from tumble.api.acquiring import acquire as acquire
    from tumble.api.comparing import Comparison as Comparison, compare as compare
    from tumble.api.many import Calibrator as Calibrator, solve_many as solve_many
    from tumble.api.recording import Recording as Recording, read as read
    from tumble.api.result import Result as Result, load as load
    from tumble.api.solving import solve as solve
    from tumble.api.thermal import (
        ThermalResult as ThermalResult,
        load_thermal as load_thermal,
        solve_thermal as solve_thermal,
    )
    from tumble.errors import (
        BadInput as BadInput,
        Disagreement as Disagreement,
        NotInstalled as NotInstalled,
        TumbleError as TumbleError,
        UsageError as UsageError,
    )
    from tumble.files.stand_file import StandFile as StandFile, read_stand as read_stand
    from tumble.schedule import Mounting as Mounting, Position as Position, Schedule as Schedule
    from tumble.stand import Stand as Stand
    from tumble.world.world import World as World

__all__ = [
    "BadInput",
    "Calibrator",
    "Comparison",
    "Disagreement",
    "Mounting",
    "NotInstalled",
    "Position",
    "Recording",
    "Result",
    "Schedule",
    "Stand",
    "StandFile",
    "ThermalResult",
    "TumbleError",
    "UsageError",
    "World",
    "__version__",
    "acquire",
    "compare",
    "load",
    "load_thermal",
    "read",
    "read_stand",
    "schedules",
    "solve",
    "solve_many",
    "solve_thermal",
]


def __getattr__(name: str) -> Any:
    """Public names are loaded when they are asked for: the command line answers typing errors without numpy."""
    if name == "data":  # a room, and public
        import tumble.data

        return tumble.data
    if name not in __all__:
        raise AttributeError(f"module 'tumble' has no attribute {name!r}")
    if name == "World":
        from tumble.world.world import World

        return globals().setdefault(name, World)
    from tumble import schedule, stand
    from tumble.api import acquiring, comparing, many, recording, result, schedules, solving, thermal
    from tumble.files import stand_file

    if name == "schedules":
        return globals().setdefault(name, schedules)
    rooms = acquiring, comparing, recording, result, solving, many, thermal
    for module in (errors, schedule, stand, stand_file, *rooms):
        if hasattr(module, name):
            return globals().setdefault(name, getattr(module, name))
    raise AttributeError(name)  # pragma: no cover


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
