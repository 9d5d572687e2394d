"""Runs made on anybody's stand: instruments that speak lines of text, and the run that turns, waits and samples."""
