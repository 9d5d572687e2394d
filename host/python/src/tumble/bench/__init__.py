"""A calibration on the bench: what is to be simulated goes to the program tumble-bench, where the firmware calibrates;
what it found comes back, is confirmed by numpy, and becomes a result. For the command line.

    setup, gains      what a run is to be: the scenario, and the gain record of the optimal estimator
    program           tumble-bench, run to its end; told to a person by progress, on a terminal by live
    outcome, folder   what it found, confirmed; the run folder
    realbus, board    the same on a CAN interface in real time, by the firmware here or on the emulated board
    replay, emulator  a recorded bus log through the firmware again; the emulator of the board
    uml, uml_command  user-mode Linux, where the kernel of this machine has no CAN
    programs          where the project's programs are
    console           a program of its own, run by its path inside user-mode Linux
"""
