"""Every file of config/ is accepted by the commands, and says what the effort is."""

from pathlib import Path

import pytest

from flex_ident.commands.common import KNOWN_KEYS
from flex_ident.commands.flex_ident import SIGNAL_SETTINGS
from flex_ident.configuration import GAP_SETTINGS, IDENTIFY_SETTINGS, IMPORT_SETTINGS, read_settings
from flex_ident.configuration.files import parameters_in
from flex_ident.errors import UsageError
from flex_ident.jobs.options import gap_options, identify_options
from flex_ident.jobs.signals import signal_selection
from flex_ident.parameters.effort_kinds import EFFORT_KINDS

CONFIG = Path(__file__).resolve().parents[2] / "config"
ROBOTS = {
    "franka": "joint_sensor", "gen3": "joint_sensor", "iiwa": "joint_sensor", "ros2_control": "auto",
    "so101": "unsigned", "ur": "gravity_compensated", "xarm": "motor",
}  # fmt: skip
"""What the effort is, by the drivers of today."""
DEFAULTS = {s.key: s.default for s in (*IDENTIFY_SETTINGS, *GAP_SETTINGS)}


def test_every_robot_is_looked_at() -> None:
    others = {"chirp_exciter", "identifier", "simulated_joint"}
    assert {p.stem for p in CONFIG.glob("*.yaml")} == {*ROBOTS, *others}


@pytest.mark.parametrize("robot", [*ROBOTS, "identifier"])
def test_commands_accept_the_file(robot: str) -> None:
    for command, settings in (
        ("identify_bag", IDENTIFY_SETTINGS), ("explain_gap", (*IDENTIFY_SETTINGS, *GAP_SETTINGS)),
        ("flex_ident", SIGNAL_SETTINGS), ("flex_ident", IMPORT_SETTINGS),
    ):  # fmt: skip
        given = read_settings(
            CONFIG / f"{robot}.yaml", settings, node="identifier", others=KNOWN_KEYS, command=command
        )  # fmt: skip
        if settings is IDENTIFY_SETTINGS:
            kind = given["effort_kind"]
            assert kind in EFFORT_KINDS
            assert kind == ROBOTS.get(robot, "auto")
            values = {**DEFAULTS, **given}
            signal_selection(values)
            if kind == "unsigned":
                with pytest.raises(UsageError, match="does not tell inertia from friction"):
                    identify_options(values)
            else:
                identify_options(values)
                gap_options(values)


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_joint_is_among_those_commanded(robot: str) -> None:
    given = parameters_in(CONFIG / f"{robot}.yaml", ("chirp_exciter",))
    joints = given.get("command.joints", [given["joint"]])
    assert given["joint"] in joints
    assert given["chirp.end_frequency_hz"] <= 0.1 * given["rate_hz"]
    assert given["limits.require_urdf"] is True
