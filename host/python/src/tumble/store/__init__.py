"""What a navigation computer keeps in its non-volatile memory: coefficient sets, their history, an unfinished run.

Specified in docs/embedding.md and written from that page: shares no code with the firmware.

    codec       the records as bytes: sets, entries of the history, positions of a run
    factory     a factory set from a calibration over temperature
    image       an image of the memory, read as the firmware would
    document    what an image holds, schema tumble.store/1
"""
