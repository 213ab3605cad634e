"""What computes tasks: this process, worker processes, or the machines of a Dask cluster."""
