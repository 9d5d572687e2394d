"""A calibration on the bench: what is to be simulated goes to the program tumble-bench, where the firmware calibrates;
what it found comes back, is confirmed by numpy, and becomes a result.
"""
