"""What scripts call: `tumble.read`, `tumble.solve`, `tumble.load` and what they return. The command line is made of it.

recording   runs as they were recorded, in files and in memory
solving     from a recording to a solution
arguments   what callers say, looked at, and the words in which they are told
complaints  why a solution may not be what it claims
result      a result: its numbers, applied to data (applying), saved and loaded
"""
