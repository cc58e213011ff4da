"""A virtual robot joint: the plant, its drive, its encoders."""
