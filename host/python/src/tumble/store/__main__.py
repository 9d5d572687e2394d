"""`python -m tumble.store dump IMAGE`: what an image of a navigation computer's non-volatile memory holds."""

from __future__ import annotations

import argparse
import sys

from tumble.errors import TumbleError, UsageError
from tumble.files.disk import read_bytes
from tumble.store.image import MIN_SECTOR, describe, read_image


class _Parser(argparse.ArgumentParser):
    def error(self, message: str):
        raise UsageError(f"{message} (see {self.prog} --help)")


def main(arguments: list[str] | None = None) -> int:
    """Exit code: 0, or 2 with one line on stderr."""
    parser = _Parser(prog="python -m tumble.store", description="What an image of the non-volatile memory holds.",
                     allow_abbrev=False)
    parser.add_argument("command", choices=["dump"])
    parser.add_argument("image", metavar="IMAGE", help="the bytes of the memory, from its first sector on")
    parser.add_argument("--sector", type=int, default=MIN_SECTOR, metavar="BYTES", help="default: %(default)s")
    try:
        options = parser.parse_args(arguments)
        lines = describe(read_image(read_bytes(options.image), options.sector, options.image))
    except TumbleError as error:
        print("tumble.store: " + str(error).replace("\n", "\\n").replace("\r", "\\r"), file=sys.stderr)
        return error.exit_code
    print("\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
