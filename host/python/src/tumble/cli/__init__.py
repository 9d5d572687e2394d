"""The command line `tumble COMMAND ...`, for `python -m tumble` and the program `tumble` alone.

    main          the parser, and an exit code and one line for whatever goes wrong
    commands      a module for every command
    options       options that several commands have in common
    output        what is said of a solution, in the words of `presentation`; on a terminal by `terminal`
    exports       coefficients in the formats of other tools

Nothing here is imported by any other room. What only one command needs is imported when that command runs.
"""
