"""How much flash, RAM and stack a linked part of the firmware takes."""
