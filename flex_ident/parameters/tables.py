"""Numbered parameters as lists, where a file is read by people: `torque_1`, `torque_2`, … is `torque: [..]` there."""

from __future__ import annotations

from collections.abc import Mapping

import yaml


class _Dumper(yaml.SafeDumper):
    """PyYAML's safe dumper with each list of numbers on lines of its own, many to a line."""


_Dumper.add_representer(list, lambda dumper, row: dumper.represent_sequence("tag:yaml.org,2002:seq", row, True))


def yaml_text(content: object) -> str:
    """Content as YAML, its keys in their order."""
    return yaml.dump(content, Dumper=_Dumper, sort_keys=False, default_flow_style=False, width=110)


def as_lists(parameters: Mapping[str, float]) -> dict[str, float | list[float]]:
    """The parameters, those that are numbered from 1 without a gap as one list each."""
    found: dict[str, float | list[float]] = {}
    for name in parameters:
        stem, _, number = name.rpartition("_")
        if stem and number == "1" and f"{stem}_2" in parameters and stem not in parameters:
            found[stem] = _row(parameters, stem)
    listed = {f"{stem}_{n + 1}" for stem, row in found.items() if isinstance(row, list) for n in range(len(row))}
    return {**{k: v for k, v in parameters.items() if k not in listed}, **{k: found[k] for k in sorted(found)}}


def _row(parameters: Mapping[str, float], stem: str) -> list[float]:
    row: list[float] = []
    while f"{stem}_{len(row) + 1}" in parameters:
        row.append(parameters[f"{stem}_{len(row) + 1}"])
    return row


def numbered(name: str, row: list[object]) -> dict[str, object]:
    """The items of a list under their numbered names."""
    return {f"{name}_{n + 1}": item for n, item in enumerate(row)}
