"""The command line `tumble COMMAND ...`, for `python -m tumble` and the program `tumble` alone.

    main          the parser, and an exit code and one line for whatever goes wrong
    commands      the table of commands, and a module for each
    options       options that several commands have in common
    prior         `solve --prior`: its options, and the calibration that they name
    thermal       `solve --temperature`: its options, and what is said of it
    output        what is said of a solution, as plain text and on a terminal

Nothing here is imported by any other room. What only one command needs is imported when that command runs.
"""
