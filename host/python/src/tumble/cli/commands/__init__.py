"""The commands of the command line: each module has `add_to(subparsers)` and `run(arguments) -> exit code`.

What only the run needs is imported in `run`, so that asking for help or making a typing error costs nothing. For the
same reason a module is loaded only when its command is named: what all of them are about stands here.
"""

ABOUT = {  # by name, in the order in which they are listed
    "solve": "solve a recorded run: K, U0, their uncertainties and a verdict",
    "import": "make a run file from continuous recordings: rests found and matched to a schedule",
    "apply": "calibrate data by a result: outputs in, acceleration out",
    "compare": "two results of one block: has it changed, or only its seat?",
    "bench": "calibrate on a simulated stand: the firmware itself, in virtual time",
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
ALIASES = {"bench": ["simulate"]}
MODULES = {"import": "import_recording"}  # whose name is another one than the command's
