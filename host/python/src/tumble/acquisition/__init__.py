"""Runs made on anybody's stand: instruments that speak lines of text, and the run that turns, waits and samples.

run          turn, wait until the block is at rest, sample, keep what there is
instruments  tables and blocks by PyVISA or a serial port, and the file that describes them
"""
