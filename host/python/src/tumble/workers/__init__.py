"""Work cut into pieces by its seeds, and whoever does it: this process, processes of this machine, or a cluster.

over   the one loop that all campaigns are: results in the order of their pieces, whoever did them; what is done is kept
       as Parquet, to go on from
crews  who does pieces beside this process: executors of concurrent.futures, Dask's among them
"""
