"""Files of the user's: run files, stand files, schedule files, read strictly; and whole files read and written.

For every room from here up. A complaint is one line with file, row and column (errors.BadInput).

    run_file       a recorded run: one mean a position; its rows by position, and what is known of each
    run_layout     how CSV is laid out: header, delimiter, decimal mark, columns, unit
    rows           rows of CSV as numbers, for run files, recordings and measured data; their temperatures
    run_rows       rows that no block at rest gives
    frames         tables of other formats, in memory and in files
    calibrated     measured data with calibrated columns behind their own
    stand_file     stand files, and files of a [block] alone
    schedule_file  schedule files
    can_log        frames in the log of a CAN bus
    containers     binary recordings: TDMS, HDF5, ULog, DataFlash, ROS bags, MCAP and others
    toml           TOML with every key and every value checked, for files of other kinds too
    disk           bytes of a file, as a whole or in blocks, decompressed; files written as a whole or not at all
"""
