"""What a navigation computer keeps in its non-volatile memory: coefficient sets, their history, an unfinished run.

Laid down in docs/store.md, and written here from that page: shares no code with the firmware.
"""
