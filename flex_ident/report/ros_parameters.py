"""`parameters.yaml`: the identified model as a ROS 2 parameter file, which `simulated_joint` takes as it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flex_ident.parameters import JointModel
from flex_ident.parameters.tables import as_lists, yaml_text


def write_ros_parameters(model: JointModel, path: Path) -> None:
    """Write the model's base parameters by key and its effects below `effects`."""
    content: dict[str, Any] = {"joint": model.joint, **dict(model.parameters)}
    if model.effects:
        content["effects"] = {name: as_lists(p) for name, p in model.effects.items()}
    path.write_text(yaml_text({"/**": {"ros__parameters": content}}), encoding="utf-8")
