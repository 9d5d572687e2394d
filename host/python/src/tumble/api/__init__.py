"""What scripts call: `tumble.read`, `tumble.solve`, `tumble.load` and what they return. The command line is made of it.

recording   runs as they were recorded, in files and in memory
solving     from a recording to a solution, and why it may not be what it claims
arguments   what callers say, looked at, and the words in which they are told
result      a result: its numbers, applied to data, saved and loaded
acquiring   a run on one's own stand
many        several runs to one table; a step for scikit-learn
thermal     runs at several temperatures to K(T) and U0(T)
schedules   the built-in ones, by name
comparing   two results held against each other
"""
