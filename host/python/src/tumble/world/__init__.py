"""A calibration on the bench: the firmware calibrates in a simulated world of this process, or on a real bus; what it
found is confirmed by numpy, and becomes a result.

    world             tumble.World, for scripts
    setup             what a run is to be: the scenario, and the gain record of the optimal estimator
    border            the world in C
    in_process        a run in a world, to its end, and what it leaves
    campaigns         thousands of runs, of calibrations or of the fault campaign
    fault_campaign    a run of the fault campaign: drawn from a seed, run, and shrunk where it breaks a rule
    virtual_bus       a world as a bus of python-can
    progress          what a person is told while it goes on
    outcome, folder   what it found, confirmed; the run folder
    realbus           the same on a CAN interface in real time, by the firmware here or on the emulated board
    replay, emulator  a recorded bus log through the firmware again; the emulator of the board
    uml               user-mode Linux, where the kernel of this machine has no CAN
    programs          where the project's programs are
    console           a program of its own, run by its path beside stand and computer
"""
