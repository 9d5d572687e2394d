"""`tumble store dump`: what an image of a navigation computer's non-volatile memory holds."""

from __future__ import annotations

import argparse
import sys

from tumble.cli import options
from tumble.errors import EXIT_PASS

_LARGEST_SECTOR = 1 << 24


def describe(parser: argparse.ArgumentParser) -> None:
    subjects = parser.add_subparsers(metavar="SUBJECT", required=True)
    subject = subjects.add_parser(
        "dump",
        help="what an image of the memory holds",
        description="Print the active set of coefficients in an image of the memory, other records, and torn ones.",
        epilog="Exit codes: 0 done, 2 bad input, 130 interrupted.",
    )
    subject.add_argument("image", metavar="IMAGE", help="the memory's bytes from its first sector on")
    subject.add_argument("--sector", metavar="BYTES", help="size of a sector; default: 4096, the least")
    options.add(subject, "--json")
    subject.set_defaults(run_command=dump)


def dump(arguments: argparse.Namespace) -> int:
    """Read and print. Returns the exit code; raises TumbleError."""
    from tumble.documents.base import to_json
    from tumble.files.disk import read_bytes
    from tumble.store.document import document
    from tumble.store.image import MIN_SECTOR, describe, read_image

    sector = MIN_SECTOR
    if arguments.sector is not None:
        sector = options.parse_whole(arguments.sector, "--sector", MIN_SECTOR, _LARGEST_SECTOR)
    found = read_image(read_bytes(arguments.image), sector, arguments.image)
    sys.stdout.write(to_json(document(found)) if arguments.json else "\n".join([*describe(found), ""]))
    return EXIT_PASS
