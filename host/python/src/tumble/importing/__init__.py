"""From a continuous recording to a run file: rests found, matched to a schedule by the direction of gravity.

pipeline     all steps of it
recording    files in, numbers out: tables, their clocks, RAWIMU logs
clocks       seconds from numbers, dates and times of day, or from a rate
repairs      counts without their sign, stretches in which nothing was measured
can_bus      of CAN logs
rests        where the block was at rest
attitudes    what gravity alone says of K and of the attitude at each rest
match        which rest is which position, and whether anything else fits as well
labels       recordings whose rows name their position in some way
any_pose     rests of unknown directions, each a pose of its own
remedies     the command that imports what was refused, found by trying
report       what was done, to be read and to be replayed
"""
