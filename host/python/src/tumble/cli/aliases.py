"""Other names of commands, which people would type. Apart from what commands need, so that naming one loads none."""

ALIASES = {"bench": ["simulate"]}
