"""The version, in C and in Python. Its one place is the file VERSION; CMake reads that."""

from __future__ import annotations

BY = "Written by tools/objects/generate from the file VERSION; not to be edited."


def header(number: str) -> str:
    return f"""/* tumble/version.h - the version of firmware and programs.
 *
 * {BY}
 */
#ifndef TUMBLE_VERSION_H
#define TUMBLE_VERSION_H

#define TUMBLE_VERSION "{number}"

#endif
"""


def module(number: str) -> str:
    return f'''"""The version of the package. {BY}"""

__version__ = "{number}"
'''
