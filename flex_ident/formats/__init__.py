"""Tables of other programs, CSV, MATLAB, HDF5, Parquet and LeRobot datasets, written as a bag."""

from flex_ident.formats.importing import Imported, imported

__all__ = ["Imported", "imported"]
