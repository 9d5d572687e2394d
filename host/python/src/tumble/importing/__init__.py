"""From a continuous recording to a run file: rests found, matched to a schedule by the direction of gravity.

recording, clock, novatel    files in, numbers out
can_bus                      CAN logs in: the block's samples (rests), signals of a DBC file (can_signals)
rests                        where the block was at rest
attitudes                    what gravity alone says of K and of the attitude at each rest
order, match                 which rest is which position, and whether anything else fits as well
labels                       recordings whose rows name their position in some way
report                       what was done, to be read and to be replayed
"""
