"""Where drivers leave their signals: changing layouts, empty arrays, other topics, other message types, no stamps."""

import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
from bag_writer import (
    JOINT_STATE,
    LATENCY_NS,
    RATE_HZ,
    ROS1_STORE,
    STORE,
    Message,
    effort,
    header,
    joint_state,
    mcap_file,
    ns,
    position,
    ros1_bag,
    rosbag2_bag,
    swing,
)
from mcap.writer import Writer
from rosbags.typesys import get_types_from_msg

from flex_ident.bags.motions import joint_motions
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.errors import BagError, ExcitationError, FlexIdentError, SignalError, UsageError
from flex_ident.recording import Recording
from flex_ident.report.sentences import sentence

TIME = np.arange(1500) / RATE_HZ
Q, U = position(TIME), effort(TIME)


def states(
    i: int, names: list[str], q: list[float], u: list[float], *, frame: str = "", stamped: bool = True
) -> Message:
    stamp = ns(TIME[i])
    content = joint_state(stamp if stamped else 0, names, q, u, frame=frame)
    return Message("/joint_states", stamp + LATENCY_NS, JOINT_STATE, content)


def bag_of(folder: Path, messages: list[Message]) -> Path:
    return rosbag2_bag(folder / "bag", sorted(messages, key=lambda m: m.received_ns))


def assert_true(recording: Recording, *, atol: float = 1e-12) -> None:
    time = recording.time + recording.start_time_s - ns(0.0) * 1e-9
    np.testing.assert_allclose(recording.motor_position, position(time), atol=max(atol, 1e-5))
    np.testing.assert_allclose(recording.motor_torque, effort(time), atol=max(atol, 1e-3))


def codes(recording: Recording) -> list[str]:
    return [notice.code for notice in recording.notices]


def test_names_in_changing_order(tmp_path: Path) -> None:
    messages = []
    for i in range(TIME.size):
        names = ["a", "b", "c"] if i % 3 else ["c", "b", "a"]
        at = names.index("a")
        q, u = [0.1, 0.2, 0.3], [0.0] * 3
        q[at], u[at] = Q[i], U[i]
        messages.append(states(i, names, q, u))
    recording = read_recording(bag_of(tmp_path, messages), SignalSelection(joint="a"))
    np.testing.assert_array_equal(recording.motor_position, Q)
    np.testing.assert_array_equal(recording.motor_torque, U)
    assert codes(recording) == []


def test_order_of_equal_lengths_is_not_mistaken(tmp_path: Path) -> None:
    """Same bytes but for the names: only those tell the two layouts apart; the frame does not."""
    messages = [
        states(i, *((["a", "b"], [Q[i], 9.0], [U[i], 0.0]) if i % 2 else (["b", "a"], [9.0, Q[i]], [0.0, U[i]])),
               frame=f"f{i % 7}")
        for i in range(TIME.size)
    ]  # fmt: skip
    motions = {m.name: m.range for m in joint_motions(bag_of(tmp_path, messages))}
    assert motions == {"a": pytest.approx(np.ptp(Q), rel=0.01), "b": 0.0}


def test_joints_added_mid_way(tmp_path: Path) -> None:
    messages = [
        states(i, ["a"], [Q[i]], [U[i]]) if i < 700 else states(i, ["new", "a"], [0.0, Q[i]], [0.0, U[i]])
        for i in range(TIME.size)
    ]
    np.testing.assert_array_equal(read_recording(bag_of(tmp_path, messages)).motor_position, Q)


def test_joint_that_appears_mid_way_starts_there(tmp_path: Path) -> None:
    messages = [
        states(i, ["a"], [0.0], [0.0]) if i < 500 else states(i, ["a", "b"], [0.0, Q[i]], [0.0, U[i]])
        for i in range(TIME.size)
    ]
    recording = read_recording(bag_of(tmp_path, messages))
    np.testing.assert_array_equal(recording.motor_position, Q[500:])
    assert recording.start_time_s == pytest.approx(ns(TIME[500]) * 1e-9, abs=1e-6)


def test_two_publishers_on_one_topic(tmp_path: Path) -> None:
    """A gripper's driver publishes its joint on the same topic at its own rate."""
    messages = [states(i, ["a"], [Q[i]], [U[i]]) for i in range(TIME.size)]
    messages += [states(i, ["gripper"], [0.01], []) for i in range(0, TIME.size, 7)]
    recording = read_recording(bag_of(tmp_path, messages))
    np.testing.assert_array_equal(recording.motor_position, Q)
    np.testing.assert_array_equal(recording.motor_torque, U)


def test_nan_and_empty_arrays_are_dropped_and_counted(tmp_path: Path) -> None:
    messages = []
    for i in range(TIME.size):
        q, u = [Q[i], 0.0], [U[i], 0.0]
        if i % 50 == 7:
            q[0] = float("nan")
        if i % 50 == 9:
            u = []
        if i % 50 == 11:
            u = u[:1]
        messages.append(states(i, ["a", "b"], q, u))
    recording = read_recording(bag_of(tmp_path, messages), SignalSelection(joint="a"))
    by_role = {s.role: s for s in recording.sampling}
    assert by_role["motor_position"].dropped_nonfinite == 30
    assert by_role["motor_torque"].dropped_nonfinite == 60
    assert by_role["motor_torque"].lost_percent == pytest.approx(4.0)
    assert_true(recording)
    assert codes(recording) == ["nonfinite_values", "nonfinite_values"]


def float64(i: int, value: float, *, late_ns: int = LATENCY_NS) -> Message:
    return Message("/effort", ns(TIME[i]) + late_ns, "std_msgs/msg/Float64", STORE.types["std_msgs/msg/Float64"](value))


def test_effort_on_a_topic_without_stamp(tmp_path: Path) -> None:
    """Its times of reception, with their latency's jitter, are brought back to the stamps' axis."""
    late = (LATENCY_NS + np.random.default_rng(1).exponential(2e5, TIME.size)).astype(int).tolist()
    messages = [states(i, ["a"], [Q[i]], [])._replace(received_ns=ns(TIME[i]) + late[i]) for i in range(TIME.size)]
    other = (LATENCY_NS + np.random.default_rng(2).exponential(2e5, TIME.size)).astype(int).tolist()
    messages += [float64(i, U[i], late_ns=other[i]) for i in range(TIME.size)]
    recording = read_recording(bag_of(tmp_path, messages), SignalSelection(effort="/effort"))
    assert [s.clock for s in recording.sampling] == ["header", "receive"]
    assert recording.sampling[1].source == "/effort"
    assert "mixed_clocks" in codes(recording)
    slope = np.gradient(U, TIME)[50:-50]
    wrong = recording.motor_torque[: TIME.size] - effort(recording.time + recording.start_time_s - ns(0.0) * 1e-9)
    skew = -float(wrong[50 : 50 + slope.size] @ slope[: wrong.size - 50] / (slope @ slope))
    assert abs(skew) < 0.02 / RATE_HZ


@pytest.mark.parametrize("field", ["wrench.torque.z", "wrench.force.x"])
def test_effort_in_a_field_of_a_stamped_message(tmp_path: Path, field: str) -> None:
    kinds, vector = STORE.types, STORE.types["geometry_msgs/msg/Vector3"]
    messages = [states(i, ["a"], [Q[i]], []) for i in range(TIME.size)]
    for i in range(TIME.size):
        force, torque = (U[i], 0.0) if "force" in field else (0.0, U[i])
        wrench = kinds["geometry_msgs/msg/Wrench"](vector(force, 1.0, 2.0), vector(3.0, 4.0, torque))
        stamp = ns(TIME[i])
        content = kinds["geometry_msgs/msg/WrenchStamped"](header(stamp, frame="sensor" + "x" * (i % 3)), wrench)
        messages.append(Message("/ft", stamp + LATENCY_NS, "geometry_msgs/msg/WrenchStamped", content))
    recording = read_recording(bag_of(tmp_path, messages), SignalSelection(effort=f"/ft:{field}"))
    assert [s.clock for s in recording.sampling] == ["header", "header"]
    assert recording.sampling[1].source == f"/ft:{field}"
    np.testing.assert_array_equal(recording.motor_torque, U)


def test_numbers_in_arrays_by_their_index(tmp_path: Path) -> None:
    kinds = STORE.types
    layout = kinds["std_msgs/msg/MultiArrayLayout"]([], 0)
    messages = []
    for i in range(TIME.size):
        data = np.array([1.0, Q[i], U[i]] if i % 2 else [1.0, Q[i], U[i], 5.0])
        content = kinds["std_msgs/msg/Float64MultiArray"](layout, data)
        messages.append(Message("/raw", ns(TIME[i]), "std_msgs/msg/Float64MultiArray", content))
    selection = SignalSelection(motor_position="/raw:data.1", effort="raw:data.2")
    recording = read_recording(bag_of(tmp_path, messages), selection)
    np.testing.assert_array_equal(recording.motor_position, Q)
    np.testing.assert_array_equal(recording.motor_torque, U)
    assert codes(recording)[0] == "receive_times"


def test_type_that_only_the_bag_defines(tmp_path: Path) -> None:
    """A driver's own message, whose definition is embedded in the bag."""
    text = "std_msgs/Header header\nstring[] label\nstd_msgs/Empty[3] none\nfloat32 heat\nint16 i\nfloat64[2] torque\n"
    store = type(STORE)()
    store.register(
        {
            name: STORE.fielddefs[name]
            for name in ("std_msgs/msg/Header", "builtin_interfaces/msg/Time", "std_msgs/msg/Empty")
        }
    )
    store.register(get_types_from_msg(text, "drive_msgs/msg/State"))
    state, nothing = store.types["drive_msgs/msg/State"], store.types["std_msgs/msg/Empty"]()
    depends = "std_msgs/msg/Header", "builtin_interfaces/msg/Time"
    parts = [STORE.generate_msgdef(d, ros_version=2)[0].split("=" * 80)[0] for d in depends]
    definition = text + "".join(
        f"{'=' * 80}\nMSG: {n.replace('/msg/', '/')}\n{p}" for n, p in zip(depends, parts, strict=True)
    )
    path = tmp_path / "drive.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("drive_msgs/msg/State", "ros2msg", definition.encode())
        channel = writer.register_channel("/drive", "cdr", schema)
        for i in range(TIME.size):
            labels = ["x" * (i % 4), "warm"]
            content = state(header(ns(TIME[i])), labels, [nothing] * 3, 30.0, i % 100, np.array([Q[i], U[i]]))
            writer.add_message(channel, ns(TIME[i]), bytes(store.serialize_cdr(content, "drive_msgs/msg/State")), 0)
        writer.finish()
    recording = read_recording(path, SignalSelection(motor_position="/drive:torque.0", effort="/drive:torque.1"))
    np.testing.assert_array_equal(recording.motor_torque, U)
    assert {s.clock for s in recording.sampling} == {"header"}


def test_type_defined_by_idl(tmp_path: Path) -> None:
    definition = (
        f"{'=' * 80}\nIDL: drive_msgs/msg/State\n"
        "module drive_msgs { module msg { struct State { uint8 mode; double angle; double torque; }; }; };\n"
    )
    path = tmp_path / "drive.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("drive_msgs/msg/State", "ros2idl", definition.encode())
        channel = writer.register_channel("/drive", "cdr", schema)
        for i in range(TIME.size):
            data = struct.pack("<4xB7x2d", 3, Q[i], U[i])
            writer.add_message(channel, ns(TIME[i]), b"\0\1" + data[2:], 0)
        writer.finish()
    recording = read_recording(path, SignalSelection(motor_position="/drive:angle", effort="/drive:torque"))
    np.testing.assert_array_equal(recording.motor_position, Q)
    np.testing.assert_array_equal(recording.motor_torque, U)


@pytest.mark.parametrize("link_name", ["a_link", "a/link", "a_secondary"])
def test_link_position_in_the_same_message(tmp_path: Path, link_name: str) -> None:
    messages = [states(i, ["a", link_name], [Q[i], 0.9 * Q[i]], [U[i], float("nan")]) for i in range(TIME.size)]
    recording = read_recording(bag_of(tmp_path, messages))
    assert recording.joint == "a"
    assert recording.link_position is not None
    np.testing.assert_array_equal(recording.link_position, 0.9 * Q)
    assert read_recording(tmp_path / "bag", SignalSelection(sensors="motor")).link_position is None


def test_motor_and_link_by_the_name_of_the_joint(tmp_path: Path) -> None:
    messages = [states(i, ["a_link", "a_motor"], [0.9 * Q[i], Q[i]], [0.0, U[i]]) for i in range(TIME.size)]
    recording = read_recording(bag_of(tmp_path, messages), SignalSelection(joint="a", sensors="motor+link"))
    assert recording.joint == "a_motor"
    np.testing.assert_array_equal(recording.motor_position, Q)
    np.testing.assert_array_equal(recording.link_position, 0.9 * Q)


def test_link_position_on_its_own_topic_with_skew_and_another_rate(tmp_path: Path) -> None:
    skew = 0.37 / RATE_HZ
    messages = [states(i, ["a"], [Q[i]], [U[i]]) for i in range(TIME.size)]
    for i in range(int(0.6 * TIME.size)):
        time = i / (0.6 * RATE_HZ) + skew
        content = joint_state(ns(time), ["a"], [0.9 * float(position(np.array(time)))])
        messages.append(Message("/link_joint_states", ns(time) + LATENCY_NS, JOINT_STATE, content))
    recording = read_recording(bag_of(tmp_path, messages))
    assert recording.link_position is not None
    time = recording.time + recording.start_time_s - ns(0.0) * 1e-9
    np.testing.assert_allclose(recording.link_position[20:-20], 0.9 * position(time)[20:-20], atol=1e-5)
    assert recording.sampling[2].source == "/link_joint_states:a.position"
    assert recording.sampling[2].rate_hz == pytest.approx(0.6 * RATE_HZ)


def test_robots_in_namespaces(tmp_path: Path) -> None:
    """The joint is found in whichever robot's topic it is, with that robot's link encoders and its commands ignored."""
    messages = []
    for i in range(TIME.size):
        for topic, name, q in (
            ("/left/joint_states", "left_a", 0.2),
            ("/right/joint_states", "right_a", Q[i]),
            ("/right/joint_commands", "right_a", Q[i] + 1.0),
            ("/right/link_joint_states", "right_a", 0.9 * Q[i]),
        ):
            content = joint_state(ns(TIME[i]), [name], [q], [U[i]])
            messages.append(Message(topic, ns(TIME[i]) + LATENCY_NS, JOINT_STATE, content))
    bag = bag_of(tmp_path, messages)
    for selection in (SignalSelection(), SignalSelection(joint="right_a")):
        recording = read_recording(bag, selection)
        assert recording.sampling[0].source == "/right/joint_states:right_a.position"
        np.testing.assert_array_equal(recording.motor_position, Q)
        np.testing.assert_array_equal(recording.link_position, 0.9 * Q)
    with pytest.raises(SignalError, match=r"left_a \(0\), right_a \(0.6"):
        read_recording(bag, SignalSelection(joint="middle_a"))


def test_reference_of_the_exciter_is_found(tmp_path: Path) -> None:
    messages = swing(1500)
    for i in range(0, 1500, 2):
        content = joint_state(ns(TIME[i]), ["joint_2"], [Q[i] + 0.01])
        messages.append(Message("/chirp_exciter/reference", ns(TIME[i]) + LATENCY_NS, JOINT_STATE, content))
    recording = read_recording(bag_of(tmp_path, messages))
    assert recording.reference is not None
    np.testing.assert_allclose(recording.reference[:1499], Q[:1499] + 0.01, atol=1e-3)


def test_zero_stamps_give_way_to_times_of_reception(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    messages = [
        states(i, ["a"], [Q[i]], [U[i]], stamped=False)._replace(
            received_ns=ns(TIME[i]) + LATENCY_NS + int(random.exponential(1.5e5))
        )
        for i in range(TIME.size)
    ]
    recording = read_recording(bag_of(tmp_path, messages))
    assert {s.clock for s in recording.sampling} == {"receive"}
    assert codes(recording) == ["receive_times"]
    assert recording.time.size == TIME.size
    np.testing.assert_allclose(recording.motor_position, Q, atol=1e-12)


def test_first_messages_without_stamp_do_not_spoil_the_rest(tmp_path: Path) -> None:
    messages = [states(i, ["a"], [Q[i]], [U[i]], stamped=i >= 5) for i in range(TIME.size)]
    recording = read_recording(bag_of(tmp_path, messages))
    assert {s.clock for s in recording.sampling} == {"header"}
    np.testing.assert_array_equal(recording.motor_position, Q[5:])


def test_big_endian_and_garbage_in_the_padding(tmp_path: Path) -> None:
    """A middleware leaves what it likes between aligned fields; a PowerPC writes its numbers the other way round."""
    random = np.random.default_rng(4)
    names = ["a", "bcd", "ef"]
    messages = []
    for i in range(TIME.size):
        content = joint_state(ns(TIME[i]), names, [Q[i], 0.0, 0.0], [U[i], 0.0, 0.0], frame="base")
        data = bytearray(STORE.serialize_cdr(content, JOINT_STATE, little_endian=i % 2 == 0))
        for at in (21, 22, 23):  # between the frame "base" and the count of names
            data[at] = int(random.integers(256))
        messages.append(Message("/joint_states", ns(TIME[i]) + LATENCY_NS, JOINT_STATE, bytes(data)))
    recording = read_recording(bag_of(tmp_path, messages), SignalSelection(joint="a"))
    np.testing.assert_array_equal(recording.motor_position, Q)


def test_ros1_effort_on_another_topic(tmp_path: Path) -> None:
    messages = swing(1500, store=ROS1_STORE)
    kind = ROS1_STORE.types["std_msgs/msg/Float64"]
    messages += [float64(i, U[i])._replace(content=kind(U[i])) for i in range(TIME.size)]
    messages.sort(key=lambda m: m.received_ns)
    recording = read_recording(ros1_bag(tmp_path / "bag.bag", messages), SignalSelection(effort="/effort"))
    np.testing.assert_allclose(recording.motor_torque[5:-5], U[5:-5], atol=1e-6)


def test_units_are_converted(tmp_path: Path) -> None:
    messages = [states(i, ["a"], [100.0 * Q[i]], [U[i] / 25.0]) for i in range(TIME.size)]
    selection = SignalSelection(gear_ratio=100.0, effort_scale=25.0)
    recording = read_recording(bag_of(tmp_path, messages), selection)
    np.testing.assert_allclose(recording.motor_position, Q)
    np.testing.assert_allclose(recording.motor_torque, U)


def test_effort_named_for_a_current_is_one(tmp_path: Path) -> None:
    messages = [states(i, ["a"], [Q[i]], []) for i in range(TIME.size)]
    messages += [float64(i, U[i])._replace(topic="/motor_current") for i in range(TIME.size)]
    bag = bag_of(tmp_path, messages)
    assert "effort_current" in codes(read_recording(bag, SignalSelection(effort="/motor_current")))
    assert "effort_not_si" not in codes(read_recording(bag, SignalSelection(effort="/motor_current", effort_scale=2.0)))


def held(value: float = 0.5, push: float = 1.0, samples: int = 300) -> list[Message]:
    return [states(i, ["a", "b"], [value, value], [push, push]) for i in range(samples)]


REFUSALS = {
    "text": (lambda f: _text(f / "bag.mcap"), {}, BagError, "is neither an MCAP, a rosbag2 sqlite3 nor a ROS 1 file"),
    "missing": (lambda f: f / "gone", {}, BagError, "no such file or folder"),
    "empty folder": (lambda f: f, {}, BagError, "holds no bag"),
    "empty file": (lambda f: _text(f / "bag.mcap", ""), {}, BagError, "is empty"),
    "no messages": (lambda f: mcap_file(f / "bag.mcap", []), {}, SignalError, "no joint_states topic"),
    "no topic": (
        lambda f: bag_of(f, swing(300)),
        {"effort": "/torques"},
        SignalError,
        "no topic '/torques' .* /joint_states",
    ),
    "no joint": (
        lambda f: bag_of(f, swing(300)),
        {"joint": "elbow"},
        SignalError,
        r"no joint 'elbow' .* joint_1 \(0\), joint_2 \(0\.\d+\)",
    ),
    "no joint of the link": (
        lambda f: bag_of(f, swing(300)),
        {"link_position": "/joint_states:x"},
        SignalError,
        "x.position is not in the recording",
    ),
    "no link": (lambda f: bag_of(f, swing(300)), {"sensors": "motor+link"}, SignalError, "--link-position"),
    "no topic named": (lambda f: bag_of(f, swing(300)), {"effort": ":x"}, UsageError, "names no topic"),
    "link is the motor": (
        lambda f: bag_of(f, swing(300)),
        {"link_position": "/joint_states:joint_2"},
        SignalError,
        "/joint_states:joint_2.position is the motor position itself",
    ),
    "link repeats the motor": (
        lambda f: bag_of(f, [*_alone(), *_repeated()]),
        {"link_position": "/encoder"},
        SignalError,
        "/encoder:a.position is the motor position itself",
    ),
    "no number among positions": (
        lambda f: bag_of(f, [states(i, ["a", "b"], [0.5, float("nan")], [0.0, U[i]]) for i in range(300)]),
        {},
        SignalError,
        r"position of b holds no finite number in 300 messages, and no other joint moved: a \(0\), b \(no number\)",
    ),
    "one message": (lambda f: bag_of(f, _alone()[:1]), {}, ExcitationError, "1 message of joint states in all"),
    "named effort is zero": (
        lambda f: bag_of(f, [states(i, ["a"], [Q[i]], [0.0]) for i in range(300)]),
        {"effort": "/joint_states:a"},
        SignalError,
        "zero throughout: it is what --effort names",
    ),
    "nothing moves": (lambda f: bag_of(f, held()), {}, ExcitationError, r"no joint moved: a \(0\), b \(0\)"),
    "joint does not move": (lambda f: bag_of(f, held()), {"joint": "a"}, ExcitationError, "joint a does not move"),
    "all move": (
        lambda f: bag_of(f, [states(i, ["a", "b"], [Q[i], Q[i]], [1.0, U[i]]) for i in range(300)]),
        {},
        SignalError,
        "2 joints moved: name one with --joint",
    ),
    "zero effort": (
        lambda f: bag_of(f, [states(i, ["a"], [Q[i]], [0.0]) for i in range(300)]),
        {},
        SignalError,
        "zero throughout",
    ),
    "constant effort": (
        lambda f: bag_of(f, [states(i, ["a"], [Q[i]], [2.0]) for i in range(300)]),
        {},
        SignalError,
        "constant at 2",
    ),
    "no effort": (
        lambda f: bag_of(f, [states(i, ["a"], [Q[i]], []) for i in range(300)]),
        {},
        SignalError,
        "none of 300 values that is a finite number",
    ),
    "effort elsewhere": (
        lambda f: bag_of(
            f,
            [
                *(states(i, ["a"], [Q[i]], []) for i in range(300)),
                *(states(i, ["a"], [Q[i]], [U[i]])._replace(topic="/torque_sensor") for i in range(300)),
                *(states(i, ["a"], [0.0], [0.0])._replace(topic="/tf") for i in range(3)),
            ],
        ),
        {"joint": "a", "motor_position": "/joint_states:a"},
        SignalError,
        "finite number: name the effort's signal with --effort, of /torque_sensor.$",
    ),
    "NaN effort": (
        lambda f: bag_of(f, [states(i, ["a"], [Q[i]], [float("nan")]) for i in range(300)]),
        {},
        SignalError,
        "a.effort holds none of 300 values",
    ),
    "too short": (
        lambda f: bag_of(f, swing(40)),
        {},
        ExcitationError,
        r"40 samples \(.* 500 Hz\) in which all signals overlap",
    ),
    "a field that is not there": (
        lambda f: bag_of(f, [*swing(300), float64(0, 1.0)]),
        {"effort": "/effort:value"},
        SignalError,
        r"no field 'value': it has data",
    ),
    "an array": (
        lambda f: bag_of(f, [*swing(300), *_arrays()]),
        {"effort": "/raw"},
        SignalError,
        r"/raw is 3 numbers: say which, as in /raw:data\.0\.$",
    ),
    "a field that is a message": (
        lambda f: bag_of(f, [*swing(300), *_wrenches()]),
        {"effort": "/ft:wrench.force"},
        SignalError,
        "not a number but a message: add a field of it, of x, y, z",
    ),
    "a text": (
        lambda f: bag_of(f, [*swing(300), *_wrenches()]),
        {"effort": "/ft:header.frame_id"},
        SignalError,
        "is a text",
    ),
}


def _alone() -> list[Message]:
    return [states(i, ["a"], [Q[i]], [U[i]]) for i in range(300)]


def _repeated() -> list[Message]:
    kind = STORE.types["sensor_msgs/msg/JointState"]
    return [
        Message(
            "/encoder",
            m.received_ns,
            JOINT_STATE,
            kind(m.content.header, ["a"], m.content.position, *2 * [np.zeros(0)]),
        )
        for m in _alone()
    ]


def test_link_position_is_left_alone_with_the_motor_only(tmp_path: Path) -> None:
    recording = read_recording(
        bag_of(tmp_path, _alone()), SignalSelection(sensors="motor", link_position="/joint_states:a")
    )
    assert recording.link_position is None


def test_link_encoder_that_repeats_the_motor_is_no_second_one(tmp_path: Path) -> None:
    messages = [*_alone(), *(m._replace(topic="/link_joint_states") for m in _repeated())]
    recording = read_recording(bag_of(tmp_path, messages))
    assert recording.link_position is None
    assert codes(recording) == ["link_repeats_motor"]


def _text(path: Path, content: str = "hello\n") -> Path:
    path.write_text(content)
    return path


def _wrenches() -> list[Message]:
    kinds, zero = STORE.types, STORE.types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    content = kinds["geometry_msgs/msg/WrenchStamped"](header(ns(0.0)), kinds["geometry_msgs/msg/Wrench"](zero, zero))
    return [Message("/ft", ns(0.0), "geometry_msgs/msg/WrenchStamped", content)]


def _arrays() -> list[Message]:
    kinds = STORE.types
    content = kinds["std_msgs/msg/Float64MultiArray"](kinds["std_msgs/msg/MultiArrayLayout"]([], 0), np.zeros(3))
    return [Message("/raw", ns(0.1), "std_msgs/msg/Float64MultiArray", content)]


@pytest.mark.parametrize("case", REFUSALS)
def test_what_cannot_be_answered_is_refused_in_one_line(tmp_path: Path, case: str) -> None:
    make, options, kind, text = REFUSALS[case]
    with pytest.raises(FlexIdentError, match=text) as caught:
        read_recording(make(tmp_path), SignalSelection(**options))
    assert type(caught.value) is kind
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == (2 if kind is UsageError else 3)


def test_time_that_jumps_back_keeps_the_longest_stretch(tmp_path: Path) -> None:
    messages = [states(i, ["a"], [Q[i]], [U[i]]) for i in range(TIME.size)]
    back = [
        m._replace(received_ns=m.received_ns - 5 * 10**9, content=joint_state(ns(TIME[i] - 5.0), ["a"], [Q[i]], [U[i]]))
        for i, m in enumerate(messages)
    ]
    recording = read_recording(rosbag2_bag(tmp_path / "bag", messages[:900] + back[900:]))
    assert codes(recording) == ["time_jumped_back"]
    assert "jumped back once, by 5 s at most, " in sentence(recording.notices[0])
    np.testing.assert_array_equal(recording.motor_position, Q[:900])


def test_a_clock_that_was_set_while_messages_went_on_costs_nothing(tmp_path: Path) -> None:
    messages = [states(i, ["a"], [Q[i]], [U[i]]) for i in range(TIME.size)]
    for number, step in enumerate((-5.0, -0.013, 0.037, 120.0)):
        set_anew = [
            m._replace(content=joint_state(ns(TIME[i] + step), ["a"], [Q[i]], [U[i]])) for i, m in enumerate(messages)
        ]
        (tmp_path / str(number)).mkdir()
        recording = read_recording(bag_of(tmp_path / str(number), messages[:900] + set_anew[900:]))
        assert codes(recording) == ["clock_stepped"]
        assert f"was set once, by {1e3 * step:+.4g} ms" in sentence(recording.notices[0])
        np.testing.assert_allclose(recording.motor_position, Q, atol=1e-5)


@pytest.mark.parametrize("value", [1e308, -np.inf, np.nan, 1e15])
@pytest.mark.parametrize("every", [1, 2])
def test_numbers_that_nobody_measured_in_another_joint_do_no_harm(tmp_path: Path, value: float, every: int) -> None:
    messages = swing(1500)
    for i in range(0, len(messages), every):
        content = messages[i].content
        content.position[0], content.effort[0] = (-1.0) ** i * value, value
    path = mcap_file(tmp_path / "bag.mcap", messages)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        recording = read_recording(path, SignalSelection(joint="joint_2"))
        found = {m.name: m for m in joint_motions(path)}
    assert recording.others == {}
    assert np.max(np.abs(recording.motor_position - position(recording.time))) < 1e-6
    assert not found["joint_1"].moves
