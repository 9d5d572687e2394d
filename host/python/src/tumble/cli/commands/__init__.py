"""The commands of the command line: each module has `add_to(subparsers)` and `run(arguments) -> exit code`.

What only the run needs is imported in `run`, so that asking for help or making a typing error costs nothing.
"""
