"""Names of the formats that `flex_ident export` writes; apart, so that `--help` need not load the exporter."""

FORMATS = ("urdf", "mujoco", "yaml", "csv")
