"""The version of the package. Written by tools/objects/generate from the file VERSION; not to be edited."""

__version__ = "0.2.0"
