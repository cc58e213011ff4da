"""Columns by their names: of which joint, and what they hold."""

from math import pi

import pytest

from flex_ident.errors import FlexIdentError, SignalError, UsageError
from flex_ident.formats.columns import Choice, chosen_columns, unit_scale

Joints = dict[str, dict[str, str]]


def chosen(names: str, timed: bool = True, **given: str) -> Choice:
    lists = {role: text.split(",") for role, text in given.items()}
    return chosen_columns(names.split("|"), lists, source="a.csv", timed=timed)


def joints(choice: Choice) -> Joints:
    return {joint.joint: dict(joint.names) for joint in choice.joints}


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("time|position|effort", {"joint": {"position": "position", "effort": "effort"}}),
        ("t|q|tau", {"joint": {"position": "q", "effort": "tau"}}),
        ("Time [s]|Motor Position [rad]|Motor-Torque (Nm)",
         {"joint": {"position": "Motor Position [rad]", "effort": "Motor-Torque (Nm)"}}),
        ("stamp|q_1|tau_1", {"joint_1": {"position": "q_1", "effort": "tau_1"}}),
        ("t|q1|q2|dq1|tau1|tau2", {"joint_1": {"position": "q1", "velocity": "dq1", "effort": "tau1"},
                                   "joint_2": {"position": "q2", "effort": "tau2"}}),
        ("timestamp|actual_q_0|actual_qd_0|target_q_0|tau_0|actual_current_0",
         {"joint_0": {"position": "actual_q_0", "velocity": "actual_qd_0", "effort": "tau_0",
                      "reference": "target_q_0"}}),
        ("t|fr3_joint4_position|fr3_joint4_effort|fr3_joint5_position",
         {"fr3_joint4": {"position": "fr3_joint4_position", "effort": "fr3_joint4_effort"},
          "fr3_joint5": {"position": "fr3_joint5_position"}}),
        ("timestamp|observation.state.elbow_flex.pos|action.elbow_flex.pos|observation.effort.elbow_flex.effort",
         {"elbow_flex": {"position": "observation.state.elbow_flex.pos", "reference": "action.elbow_flex.pos",
                         "effort": "observation.effort.elbow_flex.effort"}}),
        ("log.time|log.q.0|log.tau.0|log.q_des.0",
         {"joint_0": {"position": "log.q.0", "effort": "log.tau.0", "reference": "log.q_des.0"}}),
        ("t|observations.qpos.3|observations.effort.3|action.3",
         {"joint_3": {"position": "observations.qpos.3", "effort": "observations.effort.3", "reference": "action.3"}}),
        ("t|tau_des|tau|q|q_cmd|ql", {"joint": {"position": "q", "effort": "tau", "reference": "q_cmd",
                                                "link_position": "ql"}}),
        ("t|position|q|effort", {"joint": {"position": "position", "effort": "effort"}}),
        ("t|motorPosition|motorTorque", {"joint": {"position": "motorPosition", "effort": "motorTorque"}}),
        ("t|q.0|tau_measured.0|tau_command.0|tau_feedback.0|q_cmd.0",
         {"joint_0": {"position": "q.0", "effort": "tau_measured.0", "reference": "q_cmd.0"}}),
        ("t|Joint1_Pos|Joint1_Force", {"Joint1": {"position": "Joint1_Pos", "effort": "Joint1_Force"}}),
        ("time [s]|a1 torque cmd [Nm]|a1 position [rad]|a1 torque [Nm]|a1 q-axis [A]",
         {"a1": {"position": "a1 position [rad]", "effort": "a1 torque [Nm]"}}),
        ("t|tool_acc|q|tau|pressure", {"joint": {"position": "q", "effort": "tau"}}),
        ("t|theta_m|i_q|tau_meas", {"joint": {"position": "theta_m", "effort": "tau_meas"}}),
    ],
)  # fmt: skip
def test_names_tell(names: str, expected: Joints) -> None:
    choice = chosen(names)
    assert joints(choice) == expected
    assert "time" in choice.guessed
    assert choice.time == names.split("|")[0]


def test_what_is_said_wins() -> None:
    choice = chosen("millis|a|b|c|d", time="millis", position="a,b", effort="c,d", joints="left,right")
    assert choice.guessed == ()
    assert joints(choice) == {"left": {"position": "a", "effort": "c"}, "right": {"position": "b", "effort": "d"}}
    assert joints(chosen("t|q.0|q.1|tau.0|tau.1", position="q[1]")) == {
        "joint_1": {"position": "q.1", "effort": "tau.1"}
    }
    assert joints(chosen("t|q|i|tau", effort="i")) == {"joint": {"position": "q", "effort": "i"}}


@pytest.mark.parametrize(
    ("names", "given", "error", "said"),
    [
        ("q|tau", {}, SignalError, r"no column for time among q, tau: name it with --time, or give .* --rate"),
        ("t|a|tau", {}, SignalError, "no column for position among t, a, tau: name it with --position"),
        ("t|q|b", {}, SignalError, "no column for effort among t, q, b: name it with --effort"),
        ("t|q1|tau2", {}, SignalError, r"no column for effort among t, q1, tau2"),
        ("t|q|tau", {"position": "Q"}, SignalError, "no column 'Q' for position"),
        ("t|q1|q2|tau1", {"effort": "tau1"}, UsageError, "--effort names 1 columns for 2 joints"),
        ("t|q1|q2|tau1", {"joints": "a"}, UsageError, "--joints names 1 joints, and there are 2"),
        ("t|q1|q2|tau1", {"joints": "a,a"}, UsageError, "called alike"),
    ],
)  # fmt: skip
def test_what_is_missing_is_asked_for_in_one_line(
    names: str, given: dict[str, str], error: type[FlexIdentError], said: str
) -> None:
    with pytest.raises(error, match=said):
        chosen(names, **given)


@pytest.mark.parametrize(
    ("name", "scale"),
    [("q [deg]", pi / 180), ("q (°)", pi / 180), ("t [ms]", 1e-3), ("tau [N m]", 1.0), ("tau (mN·m)", 1e-3), ("q", 1.0),
     ("speed [rpm]", pi / 30), ("t[3]", 1.0), ("position [mrad]", 1e-3)],
)  # fmt: skip
def test_units_in_brackets(name: str, scale: float) -> None:
    assert unit_scale(name) == pytest.approx(scale)
