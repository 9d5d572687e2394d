"""How tests that compile C of their own find the firmware's headers."""

INCLUDES = ["-Ifirmware", "-Ifirmware/include"]  # for a compiler that is called in the root of the repo
