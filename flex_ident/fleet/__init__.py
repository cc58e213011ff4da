"""Adapter: many recordings into an archive of one row a result, on this machine or a Dask cluster."""
