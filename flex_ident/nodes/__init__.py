"""The ROS 2 nodes."""

import flex_ident.commands  # noqa: F401  (one thread for BLAS, before the messages load numpy)
