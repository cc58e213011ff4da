"""`parameters.yaml`: the identified model as a ROS 2 parameter file, which `simulated_joint` takes as it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from flex_ident.parameters import JointModel


def write_ros_parameters(model: JointModel, path: Path) -> None:
    """Write the model's base parameters by key and its effects below `effects`."""
    content: dict[str, Any] = {"joint": model.joint, **dict(model.parameters)}
    if model.effects:
        content["effects"] = {name: dict(p) for name, p in model.effects.items()}
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": content}}, sort_keys=False), encoding="utf-8")
