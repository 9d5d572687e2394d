"""The commands of the command line: a row and a module each, which a reader understands alone.

A module has `describe(parser)`, which says to argparse what the command takes, and functions that run it and return an
exit code. What only the run needs is imported in these, so that asking for help or making a typing error costs nothing.
For the same reason a module is loaded only when its command is named.
"""

from __future__ import annotations

from typing import NamedTuple


class Command(NamedTuple):
    """What it is `about`; an example for it, or for each of its subjects, with which `--help` ends; other names of it,
    which people would type; its module in this folder, where that is not called as the command."""

    about: str
    examples: tuple[str, ...]
    aliases: tuple[str, ...] = ()
    module: str = ""


COMMANDS = {  # in the order in which they are listed
    "solve": Command(
        "solve a recorded run: K, U0, their uncertainties and a verdict",
        ("tumble solve run.csv --stand stand.toml --out result.json",),
    ),
    "import": Command(
        "make a run file from continuous recordings: rests found and matched to a schedule",
        ("tumble import recording.csv --rate 100 --unit m/s^2 --out run.csv",),
        module="import_recording",
    ),
    "apply": Command(
        "calibrate data by a result: outputs in, acceleration out",
        ("tumble apply result.json data.csv --uncertainty --out calibrated.csv",),
    ),
    "compare": Command(
        "compare two results of one block: has it changed, or only its seat?",
        ("tumble compare before.json after.json --stand stand.toml",),
    ),
    "bench": Command(
        "calibrate on a simulated stand: the firmware itself, in virtual time",
        ("tumble bench --stand stand.toml --seed 7 --out run",),
        aliases=("simulate",),
    ),
    "acquire": Command(
        "calibrate on your own stand: instruments through PyVISA or a serial port",
        ("tumble acquire bench.toml --out run",),
    ),
    "campaign": Command(
        "thousands of simulated runs, or the fault campaign, on many processors",
        (
            "tumble campaign runs scenario.txt --runs 1000 --workers 2 --summary",
            "tumble campaign lives --lives 100 --seed 1 -v",
        ),
    ),
    "watch": Command(
        "follow a run live, on the terminal or as a page for browsers",
        ("tumble watch can:can0 --http",),
    ),
    "replay": Command(
        "replay a recorded bus log through the firmware, here or on the emulated board",
        ("tumble replay run/bus.log",),
    ),
    "plan": Command(
        "judge a stand before a run: error budget, requirements, optimal weights",
        (
            "tumble plan budget --stand stand.toml --estimator refined",
            "tumble plan require --stand stand.toml --limit 3e-4",
            "tumble plan optimize --stand stand.toml",
            "tumble plan schedule --stand stand.toml --limit 3e-4 --mountings 3",
            "tumble plan validate --stand stand.toml --runs 10000",
            "tumble plan paper",
        ),
    ),
    "fixture": Command(
        "judge a stand by the runs made on it",
        (
            "tumble fixture check --stand stand.toml run.csv",
            "tumble fixture learn --stand old.toml a.csv b.csv c.csv --out new.toml",
        ),
    ),
    "draw": Command(
        "draw the stand, mountings, angles, the run or the bus, as SVG",
        (
            "tumble draw stand --out stand.svg",
            "tumble draw mountings --out mountings.svg",
            "tumble draw angles --out angles.svg",
            "tumble draw inclinations --schedule inclined --out inclinations.svg",
            "tumble draw states --out states.svg",
            "tumble draw wiring --out wiring.svg",
        ),
    ),
    "export": Command(
        "write the coefficients of a result for other programs: C, CSV, MATLAB, ROS, imucal, PX4, ArduPilot, DCC",
        ("tumble export result.json --format c --out calibration.h",),
    ),
    "report": Command(
        "write a calibration report on a result: HTML or PDF",
        ("tumble report result.json --out report.html",),
    ),
    "history": Command(
        "keep the calibrations of many blocks: trends, alarms, when the next one is due",
        (
            "tumble history add run/result.json",
            "tumble history show",
            "tumble history trend --serial TB-0001 --plot trend.svg",
            "tumble history due --limit 3e-4",
            "tumble history export --out history.parquet",
        ),
    ),
    "store": Command(
        "inspect the non-volatile memory of a navigation computer",
        ("tumble store dump memory.bin",),
    ),
    "uml": Command(
        "run any command inside user-mode Linux, with a CAN interface vcan0",
        ("tumble uml candump vcan0",),
    ),
}
