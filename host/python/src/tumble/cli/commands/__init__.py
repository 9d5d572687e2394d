"""The commands of the command line: each module has `add_to(subparsers, about)` and `run(arguments) -> exit code`.

What only the run needs is imported in `run`, so that asking for help or making a typing error costs nothing. For the
same reason a module is loaded only when its command is named: what all of them are about stands here.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

ABOUT = {  # by name, in the order in which they are listed
    "solve": "solve a recorded run: K, U0, their uncertainties and a verdict",
    "import": "make a run file from continuous recordings: rests found and matched to a schedule",
    "apply": "calibrate data by a result: outputs in, acceleration out",
    "compare": "two results of one block: has it changed, or only its seat?",
    "bench": "calibrate on a simulated stand: the firmware itself, in virtual time",
    "campaign": "thousands of simulated runs, or of hostile lives, on many processors",
    "watch": "show a run as it goes, on the terminal or as a page for browsers",
    "replay": "a recorded bus log through the firmware again, here or on the emulated board",
    "plan": "what a stand is worth before a run: error budget, requirements, optimal weights",
    "fixture": "judge a stand by the runs made on it",
    "draw": "draw the stand, mountings, angles, the run or the bus, as SVG",
    "export": "write the coefficients of a result for other programs: C, CSV, MATLAB, ROS, imucal",
    "report": "write a calibration report on a result: HTML or PDF",
    "store": "look into the non-volatile memory of a navigation computer",
    "uml": "run any command inside user-mode Linux, with a CAN interface vcan0",
}


_MODULES = {"import": "import_recording"}  # where it isn't the command's name

EXAMPLES = {  # by command and subject: what `--help` ends with
    "solve": "tumble solve run.csv --stand stand.toml --out result.json",
    "import": "tumble import recording.csv --rate 100 --unit m/s^2 --out run.csv",
    "apply": "tumble apply result.json data.csv --uncertainty --out calibrated.csv",
    "compare": "tumble compare before.json after.json --stand stand.toml",
    "bench": "tumble bench --stand stand.toml --seed 7 --out run",
    "campaign runs": "tumble campaign runs scenario.txt --runs 1000 --workers 2 --summary",
    "campaign lives": "tumble campaign lives --lives 100 --seed 1 -v",
    "watch": "tumble watch can:can0 --http",
    "replay": "tumble replay run/bus.log",
    "plan budget": "tumble plan budget --stand stand.toml --estimator refined",
    "plan require": "tumble plan require --stand stand.toml --limit 3e-4",
    "plan optimize": "tumble plan optimize --stand stand.toml",
    "plan schedule": "tumble plan schedule --stand stand.toml --limit 3e-4 --mountings 3",
    "plan validate": "tumble plan validate --stand stand.toml --runs 10000",
    "plan paper": "tumble plan paper",
    "fixture check": "tumble fixture check --stand stand.toml run.csv",
    "draw stand": "tumble draw stand --out stand.svg",
    "draw mountings": "tumble draw mountings --out mountings.svg",
    "draw angles": "tumble draw angles --out angles.svg",
    "draw states": "tumble draw states --out states.svg",
    "draw wiring": "tumble draw wiring --out wiring.svg",
    "export": "tumble export result.json --format c --out calibration.h",
    "report": "tumble report result.json --out report.html",
    "store dump": "tumble store dump memory.bin",
    "uml": "tumble uml candump vcan0",
}


def adder_of(name: str) -> Callable[[Any, str], None]:
    """What describes a command to argparse. Loads the command's module, and no other."""
    module = import_module(f"tumble.cli.commands.{_MODULES.get(name, name)}")
    found: Callable[[Any, str], None] = module.add_to
    return found
