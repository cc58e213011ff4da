"""Maximum likelihood by simulation, and how far to trust it: `estimation.identification.identify`."""
