"""A ROS 2 parameter file of the joint's parameters."""

from __future__ import annotations

import yaml

from flex_ident.report.stored import StoredResult


def written(result: StoredResult) -> str:
    """All parameters by key, without an offset that the recording does not determine: it would push by itself."""
    values = {p.key: p.value for p in result.parameters if p.key != "offset" or p.identifiable}
    return yaml.safe_dump({"/**": {"ros__parameters": {"joint": result.joint, **values}}}, sort_keys=False).rstrip()
