"""The commands of the command line: each module has `add_to(subparsers, about)` and `run(arguments) -> exit code`.

What only the run needs is imported in `run`, so that asking for help or making a typing error costs nothing. For the
same reason a module is loaded only when its command is named: what all of them are about stands here.
"""

from __future__ import annotations

from collections.abc import Callable
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


def adder_of(name: str) -> Callable[[Any, str], None]:
    """What describes a command to argparse. Loads the command's module, and no other: each import is spelt out, so that
    tools/rooms.py sees it."""
    if name == "solve":
        from tumble.cli.commands import solve

        return solve.add_to
    if name == "import":
        from tumble.cli.commands import import_recording

        return import_recording.add_to
    if name == "apply":
        from tumble.cli.commands import apply

        return apply.add_to
    if name == "compare":
        from tumble.cli.commands import compare

        return compare.add_to
    if name == "bench":
        from tumble.cli.commands import bench

        return bench.add_to
    if name == "campaign":
        from tumble.cli.commands import campaign

        return campaign.add_to
    if name == "watch":
        from tumble.cli.commands import watch

        return watch.add_to
    if name == "replay":
        from tumble.cli.commands import replay

        return replay.add_to
    if name == "plan":
        from tumble.cli.commands import plan

        return plan.add_to
    if name == "fixture":
        from tumble.cli.commands import fixture

        return fixture.add_to
    if name == "draw":
        from tumble.cli.commands import draw

        return draw.add_to
    if name == "export":
        from tumble.cli.commands import export

        return export.add_to
    if name == "report":
        from tumble.cli.commands import report

        return report.add_to
    if name == "store":
        from tumble.cli.commands import store

        return store.add_to
    if name == "uml":
        from tumble.cli.commands import uml

        return uml.add_to
    raise KeyError(name)
