"""Names of the formats, each with the module here that writes it; apart, so that `--help` need not load them."""

FORMATS = {"urdf": "urdf", "mujoco": "mujoco", "yaml": "ros_yaml", "csv": "csv_table"}
