"""Messages of any type, zeros and empty but for what is given."""

from __future__ import annotations

from typing import Any

import numpy as np


def filled(store: Any, kind: str, **given: Any) -> Any:
    """A message whose fields are zeros and empty, but for those that are given."""
    values = {}
    for name, (node, detail) in store.fielddefs[kind][1]:
        if name in given:
            values[name] = given[name]
        elif node.name == "NAME":
            values[name] = filled(store, detail)
        elif node.name == "BASE":
            values[name] = "" if detail[0] == "string" else 0
        elif node.name == "ARRAY":
            values[name] = np.zeros(detail[1], bool if detail[0][1][0] == "bool" else np.float64)
        else:
            values[name] = [] if detail[0][1][0] in ("string",) or detail[0][0].name == "NAME" else np.zeros(0)
    return store.types[kind](**values)
