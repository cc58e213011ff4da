"""Three joints of different size to try things on."""

from __future__ import annotations

from flex_ident.parameters import JointModel

PAPER_JOINT = JointModel(
    {"Jm": 174.8, "K": 20341.0, "JL": 47.45, "FVm": 235.9, "FSm": 41.4, "FV": 83.15, "FS": 8.46, "MX": -0.724,
     "MY": -53.4},
    joint="paper",
)  # fmt: skip
"""The prototype of Pham, Gautier and Poignet (2001), Table 1."""

COBOT_JOINT = JointModel(
    {"Jm": 1.0, "K": 1.0e4, "JL": 1.0, "FVm": 8.0, "FSm": 4.0, "FV": 2.0, "FS": 1.0, "MX": 0.5, "MY": 3.0},
    joint="cobot",
)

SERIES_ELASTIC_JOINT = JointModel(
    {"Jm": 0.1, "K": 300.0, "JL": 0.1, "FVm": 0.5, "FSm": 0.3, "FV": 0.05, "FS": 0.05, "MX": 0.02, "MY": 0.2},
    joint="series_elastic",
)

JOINTS: dict[str, JointModel] = {j.joint: j for j in (PAPER_JOINT, COBOT_JOINT, SERIES_ELASTIC_JOINT)}
