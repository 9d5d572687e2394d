"""The page of the command line: what --help of `tumble` and of all its commands prints."""

import argparse
import os

INTRODUCTION = """\
# Command line

What `tumble --help` and `tumble COMMAND --help` print. Files, formats and exit codes are explained in
[Files, options, exit codes](../files.md).
"""


def page():
    """Markdown of the page, on a terminal of 80 columns without colours."""
    from tumble.cli.main import _parser

    os.environ.update(COLUMNS="80", NO_COLOR="1")
    sections = [f"## {parser.prog}\n\n```text\n{parser.format_help()}```\n" for parser in all_parsers(_parser())]
    return "\n".join([INTRODUCTION, *sections])


def all_parsers(parser):
    """A parser, and those of its commands, each once: another name of a command has no section of its own."""
    found = [parser]
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in dict.fromkeys(action.choices.values()):
                found += all_parsers(command)
    return found
