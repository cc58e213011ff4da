"""Signals in message types of others: joints by name, fields by path, types that the bag does not define."""

import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_writer import LATENCY_NS, RATE_HZ, STORE, Message, data_file, effort, header, ns, position, swing
from filled_messages import filled
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from flex_ident.bags.known_types import KNOWN_TYPES
from flex_ident.bags.layouts import MessageLayouts
from flex_ident.bags.messages import Topic, block_of
from flex_ident.bags.motions import joint_motions
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.errors import FlexIdentError, SignalError, UsageError
from flex_ident.recording import Recording

SAMPLES = 1500
TIME = np.arange(SAMPLES) / RATE_HZ
Q, U = position(TIME), effort(TIME)
JOINTS = ["joint_1", "joint_2"]
DYNAMIC = "control_msgs/msg/DynamicJointState"
TRAJECTORY = "control_msgs/msg/JointTrajectoryControllerState"
ROBOT = "franka_msgs/msg/FrankaRobotState"
ODRIVE = "odrive_can/msg/ControllerStatus"


def store_with(kind: str, version: int = 0) -> Any:
    """A typestore that knows one of the types of drivers."""
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(KNOWN_TYPES[kind][version], kind))
    return store


def bag_of(
    folder: Path, messages: Sequence[Message], store: Any, storage: StoragePlugin = StoragePlugin.MCAP
) -> Path:  # fmt: skip
    writer = Writer(folder / "bag", version=9, storage_plugin=storage)
    with writer:
        connections: dict[str, Any] = {}
        for topic, received, kind, content in sorted(messages, key=lambda m: m.received_ns):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], received, bytes(store.serialize_cdr(content, kind)))
    return folder / "bag"


def without_definitions(bag: Path) -> Path:
    """The sqlite3 bag as ROS 2 Humble leaves it: no message definitions."""
    with sqlite3.connect(data_file(bag)) as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    return bag


def assert_true(recording: Recording) -> None:
    time = recording.time + recording.start_time_s - ns(0.0) * 1e-9
    np.testing.assert_allclose(recording.motor_position, position(time), atol=1e-5)
    np.testing.assert_allclose(recording.motor_torque, effort(time), atol=1e-3)


def dynamic(i: int, store: Any, *, reverse: bool = False) -> Message:
    value = store.types["control_msgs/msg/InterfaceValue"]
    own = value(interface_names=["position", "torque", "effort"], values=np.array([Q[i], 2.0 * U[i], U[i]]))
    held = value(interface_names=["position", "effort"], values=np.array([0.5, 0.0]))
    names, values = (JOINTS[::-1], [own, held]) if reverse else (JOINTS, [held, own])
    content = store.types[DYNAMIC](header(ns(TIME[i])), names, values)
    return Message("/dynamic_joint_states", ns(TIME[i]) + LATENCY_NS, DYNAMIC, content)


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_dynamic_joint_states_alone_are_joint_states(tmp_path: Path, storage: StoragePlugin) -> None:
    store = store_with(DYNAMIC)
    bag = bag_of(tmp_path, [dynamic(i, store, reverse=i % 3 == 0) for i in range(SAMPLES)], store, storage)
    if storage is StoragePlugin.SQLITE3:
        without_definitions(bag)
    assert {(m.name, m.moves) for m in joint_motions(bag)} == {("joint_1", False), ("joint_2", True)}
    recording = read_recording(bag)
    assert recording.joint == "joint_2"
    assert_true(recording)


def test_any_interface_of_dynamic_joint_states(tmp_path: Path) -> None:
    store = store_with(DYNAMIC)
    messages = [m for i, s in enumerate(swing(SAMPLES)) for m in (s, dynamic(i, store))]
    bag = bag_of(tmp_path, messages, store)
    assert {m.topic for m in joint_motions(bag)} == {"/joint_states"}
    for text in ("/dynamic_joint_states:joint_2.torque", "dynamic_joint_states:joint_2.torque"):
        recording = read_recording(bag, SignalSelection(effort=text, effort_scale=0.5))
        assert_true(recording)
        assert recording.sampling[1].source == "/dynamic_joint_states:joint_2.torque"
    assert_true(read_recording(bag, SignalSelection(effort="/dynamic_joint_states")))


def test_a_relative_topic_may_stand_in_a_namespace(tmp_path: Path) -> None:
    messages = [m._replace(topic="/left/arm/joint_states") for m in swing(SAMPLES)]
    bag = bag_of(tmp_path, messages, STORE)
    for text in ("joint_states", "arm/joint_states", "/left/arm/joint_states", "left/arm/joint_states:joint_2"):
        assert_true(read_recording(bag, SignalSelection(motor_position=text, effort=text, joint="joint_2")))
    with pytest.raises(SignalError, match="no topic '/joint_states' in the recording: it has /left/arm/joint_states"):
        read_recording(bag, SignalSelection(motor_position="/joint_states"))


def test_a_relative_topic_that_may_be_several_is_asked_for(tmp_path: Path) -> None:
    messages = [m._replace(topic=f"/{side}/joint_states") for m in swing(SAMPLES) for side in ("left", "right")]
    bag = bag_of(tmp_path, messages, STORE)
    with pytest.raises(SignalError, match="'joint_states' may be /left/joint_states or /right/joint_states"):
        read_recording(bag, SignalSelection(motor_position="joint_states"))


def test_joints_of_joint_states_by_number(tmp_path: Path) -> None:
    bag = bag_of(tmp_path, swing(SAMPLES), STORE)
    given = SignalSelection(joint="arm", motor_position="/joint_states:position[1]", effort="/joint_states:effort[1]")
    assert_true(read_recording(bag, given))
    with pytest.raises(SignalError, match=r"position\.7"):
        read_recording(
            bag, SignalSelection(joint="arm", motor_position="/joint_states:position[7]", effort="/joint_states")
        )


@pytest.mark.parametrize("version", range(len(KNOWN_TYPES[TRAJECTORY])))
def test_a_controller_state_by_joint_name_whatever_its_version(tmp_path: Path, version: int) -> None:
    store = store_with(TRAJECTORY, version)
    point = store.types["trajectory_msgs/msg/JointTrajectoryPoint"]
    nothing = np.zeros(0)
    zero = store.types["builtin_interfaces/msg/Duration"](0, 0)
    messages = swing(SAMPLES)
    measured = "actual" if version == 2 else "feedback"
    for i in range(SAMPLES):
        now = point(np.array([0.5, Q[i]]), nothing, nothing, np.array([0.0, U[i]]), zero)
        content = filled(store, TRAJECTORY, header=header(ns(TIME[i])), joint_names=JOINTS, **{measured: now})
        messages.append(Message("/controller_state", ns(TIME[i]) + LATENCY_NS, TRAJECTORY, content))
    bag = without_definitions(bag_of(tmp_path, messages, store, StoragePlugin.SQLITE3))
    given = SignalSelection(
        joint="joint_2", motor_position=f"/controller_state:joint_2.{measured}.positions",
        effort=f"/controller_state:{measured}.effort[1]",
    )  # fmt: skip
    assert_true(read_recording(bag, given))


@pytest.mark.parametrize("version", range(len(KNOWN_TYPES[ROBOT])))
@pytest.mark.parametrize("defined", [True, False])
def test_a_robot_state_of_franka(tmp_path: Path, version: int, defined: bool) -> None:
    store = store_with(ROBOT, version)
    names, nothing = [f"fr3_joint{i}" for i in range(1, 8)], np.zeros(0)
    state = store.types["sensor_msgs/msg/JointState"]
    messages = []
    for i in range(SAMPLES):
        q, u = np.full(7, 0.5), np.zeros(7)
        q[3], u[3] = Q[i], U[i]
        measured = state(header(ns(TIME[i])), names, q, nothing, u)
        content = filled(store, ROBOT, header=header(ns(TIME[i])), measured_joint_state=measured, dtau_j=2.0 * u)
        messages.append(Message("/broadcaster/robot_state", ns(TIME[i]) + LATENCY_NS, ROBOT, content))
    bag = bag_of(tmp_path, messages, store, StoragePlugin.SQLITE3)
    if not defined:
        without_definitions(bag)
    topic = "/broadcaster/robot_state:"
    for position_at, effort_at, scale in (
        ("measured_joint_state.fr3_joint4.position", "measured_joint_state.fr3_joint4.effort", 1.0),
        ("measured_joint_state.position[3]", "dtau_j[3]", 0.5),
    ):
        given = SignalSelection(
            joint="fr3_joint4", motor_position=topic + position_at, effort=topic + effort_at, effort_scale=scale
        )
        assert_true(read_recording(bag, given))
    with pytest.raises(SignalError, match="holds no messages"):
        read_recording(bag, SignalSelection(motor_position=f"{topic}measured_joint_state.nobody.position",
                                            effort=f"{topic}dtau_j[3]"))  # fmt: skip


@pytest.mark.parametrize(("kind", "path"), [
    ("control_msgs/msg/JointControllerState", "process_value"), ("franka_msgs/msg/FrankaState", "tau_j"),
    ("ur_msgs/msg/RobotStateRTMsg", "controller_timer"),
])  # fmt: skip
def test_other_types_of_drivers_are_read_to_their_end(kind: str, path: str) -> None:
    for version in range(len(KNOWN_TYPES[kind])):
        store = store_with(kind, version)
        value = np.arange(7.0) if path == "tau_j" else 3.0
        payload = bytes(store.serialize_cdr(filled(store, kind, **{path: value}), kind))
        layouts = MessageLayouts(Topic("/state", kind), ros1=False)
        ((layout, rows, _),) = layouts(block_of("/state", [1, 2], [payload, payload]))
        assert layouts.damaged == 0
        np.testing.assert_array_equal(layout.numbers[path].of(rows)[1], np.atleast_1d(value))


def odrive_bag(folder: Path, kind: str = ODRIVE) -> Path:
    """Humble's bag of one ODrive: positions in turns, no stamps, no definitions."""
    store = store_with(ODRIVE)
    if kind != ODRIVE:
        store.register(get_types_from_msg(KNOWN_TYPES[ODRIVE][0], kind))
    messages = [
        Message("/odrive_axis0/controller_status", ns(TIME[i]), kind,
                filled(store, kind, pos_estimate=Q[i], torque_estimate=U[i]))
        for i in range(SAMPLES)
    ]  # fmt: skip
    return without_definitions(bag_of(folder, messages, store, StoragePlugin.SQLITE3))


ODRIVE_PLACES = {
    "motor_position": "odrive_axis0/controller_status:pos_estimate",
    "effort": "odrive_axis0/controller_status:torque_estimate",
}


def test_an_odrive(tmp_path: Path) -> None:
    recording = read_recording(odrive_bag(tmp_path), SignalSelection(joint="axis", **ODRIVE_PLACES))
    np.testing.assert_allclose(recording.motor_position, position(recording.time), atol=1e-5)


def test_a_type_that_nobody_knows_needs_its_file(tmp_path: Path) -> None:
    bag = odrive_bag(tmp_path, "my_msgs/msg/Drive")
    with pytest.raises(
        SignalError, match=r"my_msgs/msg/Drive, which neither ROS nor the bag defines.*--type-file X\.msg"
    ):
        read_recording(bag, SignalSelection(**ODRIVE_PLACES))
    file = tmp_path / "Drive.msg"
    file.write_text("# the drive\n" + KNOWN_TYPES[ODRIVE][0] + "\n")
    recording = read_recording(bag, SignalSelection(type_files=(str(file),), **ODRIVE_PLACES))
    np.testing.assert_allclose(recording.motor_position, position(recording.time), atol=1e-5)
    folder = tmp_path / "my_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Drive.msg").write_text("Inner inner\n" + "".join(KNOWN_TYPES[ODRIVE][0].partition("float32 iq_set")[1:]))
    (folder / "Inner.msg").write_text(KNOWN_TYPES[ODRIVE][0].partition("float32 iq_set")[0])
    places = {role: text.replace(":", ":inner.") for role, text in ODRIVE_PLACES.items()}
    for given in (folder, folder / "Drive.msg", folder.parent):
        read_recording(bag, SignalSelection(type_files=(str(given),), **places))


@pytest.mark.parametrize(
    ("file", "text", "error", "said"),
    [
        ("Drive.msg", None, UsageError, "cannot be read"),
        ("Drive.txt", "", UsageError, r"expected a \.msg file"),
        ("Drive.msg", "float32 a\nfloat64[] b\n", SignalError, "no field 'pos_estimate'"),
        ("Drive.msg", "float32 pos_estimate\nfloat32 torque_estimate\n", SignalError, "fits its messages"),
        ("Drive.msg", "float32 pos_estimate\nOther other\n", SignalError, r"does not define .*Other is not among"),
        ("Drive.msg", "this is ] no definition", SignalError, "does not define"),
        ("Drive.msg", "x" * (1 << 20), UsageError, "are read at most"),
    ],
)
def test_a_wrong_type_file_is_refused_in_one_line(
    tmp_path: Path, file: str, text: str | None, error: type[FlexIdentError], said: str
) -> None:
    if text is not None:
        (tmp_path / file).write_text(text)
    with pytest.raises(error, match=said) as caught:
        read_recording(
            odrive_bag(tmp_path, "my_msgs/msg/Drive"),
            SignalSelection(type_files=(str(tmp_path / file),), **ODRIVE_PLACES),
        )
    assert str(caught.value).isprintable()


def test_another_version_of_a_known_type_is_not_guessed_at(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    longer = KNOWN_TYPES[ODRIVE][0].replace("uint32 active_errors", "uint32 active_errors\nfloat64[4] more")
    store.register(get_types_from_msg(longer, ODRIVE))
    messages = [
        Message("/odrive_axis0/controller_status", ns(t), ODRIVE, filled(store, ODRIVE, pos_estimate=q))
        for t, q in zip(TIME, Q, strict=True)
    ]
    bag = without_definitions(bag_of(tmp_path, messages, store, StoragePlugin.SQLITE3))
    with pytest.raises(SignalError, match="no known definition of odrive_can/msg/ControllerStatus fits"):
        read_recording(bag, SignalSelection(**ODRIVE_PLACES))
