"""MCAP files of JSON and protobuf messages, with and without Foxglove's own schemas."""

import json
import resource
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_writer import LATENCY_NS, RATE_HZ, effort, ns, position
from mcap.writer import CompressionType, Writer

from flex_ident.bags import extras
from flex_ident.bags.motions import joint_motions
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.errors import SignalError
from flex_ident.recording import Recording

SAMPLES = 1500
TIME = np.arange(SAMPLES) / RATE_HZ
Q, U = position(TIME), effort(TIME)


def mcap_of(
    path: Path, topic: str, encoding: str, schema: tuple[str, str, bytes] | None, rows: Iterable[bytes],
    *, compression: CompressionType = CompressionType.ZSTD,
) -> Path:  # fmt: skip
    with path.open("wb") as file:
        writer = Writer(file, compression=compression)
        writer.start("")
        number = 0 if schema is None else writer.register_schema(*schema)
        channel = writer.register_channel(topic, encoding, number)
        for i, row in enumerate(rows):
            at = ns(i / RATE_HZ) + LATENCY_NS
            writer.add_message(channel, at, row, at)
        writer.finish()
    return path


def stamp(i: int, names: tuple[str, str] = ("sec", "nsec")) -> dict[str, int]:
    return dict(zip(names, divmod(ns(TIME[i]), 1_000_000_000), strict=True))


def foxglove(i: int) -> dict[str, Any]:
    held = {"name": "joint_1", "position": 0.5, "velocity": None}
    return {"timestamp": stamp(i), "joints": [held, {"name": "joint_2", "position": Q[i], "effort": U[i]}]}


def ros(i: int) -> dict[str, Any]:
    names = ("sec", "nanosec")
    state = {"name": ["joint_1", "joint_2"], "position": [0.5, Q[i]], "velocity": [], "effort": [0.0, U[i]]}
    return {"header": {"stamp": stamp(i, names), "frame_id": "at 1"}, **state}


def assert_true(recording: Recording, *, latency: float = 0.0) -> None:
    time = recording.time + recording.start_time_s - ns(0.0) * 1e-9 - latency
    np.testing.assert_allclose(recording.motor_position, position(time), atol=2e-5)
    np.testing.assert_allclose(recording.motor_torque, effort(time), atol=2e-3)


@pytest.mark.parametrize(
    ("schema", "topic", "content"),
    [
        ("foxglove.JointStates", "/joint_states", foxglove), ("foxglove_msgs/msg/JointStates", "robot", foxglove),
        ("sensor_msgs/msg/JointState", "/joint_states", ros), ("sensor_msgs.JointState", "states", ros),
        ("JointState", "joint_states", ros), (None, "joint_states", ros),
    ],
)  # fmt: skip
def test_joint_states_as_json(
    tmp_path: Path, schema: str | None, topic: str, content: Callable[[int], dict[str, Any]]
) -> None:
    given = None if schema is None else (schema, "jsonschema", b"{}")
    bag = mcap_of(tmp_path / "a.mcap", topic, "json", given, (json.dumps(content(i)).encode() for i in range(SAMPLES)))
    assert {m.name: m.moves for m in joint_motions(bag)} == {"joint_1": False, "joint_2": True}
    recording = read_recording(bag)
    assert recording.joint == "joint_2"
    assert recording.sampling[0].clock == "header"
    assert_true(recording)


def test_any_field_of_json_by_its_path(tmp_path: Path) -> None:
    rows = (
        json.dumps({"t": i, "motors": [{"id": 3, "q": 0}, {"id": "x", "q": Q[i]}], "tau": [0, 1, U[i]]}).encode()
        for i in range(SAMPLES)
    )
    bag = mcap_of(tmp_path / "a.mcap", "drives", "json", None, rows)
    given = SignalSelection(motor_position="drives:motors[1].q", effort="drives:tau[2]")
    assert_true(read_recording(bag, given), latency=LATENCY_NS * 1e-9)
    for wrong, said in (
        ("drives:motors[1].p", r"no field 'motors\.1\.p': it has t, motors\.0\.id, motors\.0\.q"),
        ("drives:tau", r"is 3 numbers: say which, as in drives:tau\.0"), ("drives", "no field ''"),
    ):  # fmt: skip
        with pytest.raises(SignalError, match=said):
            read_recording(bag, SignalSelection(motor_position=wrong, effort="drives:tau[2]"))


@pytest.mark.slow
def test_messages_of_many_numbers_take_little_memory(tmp_path: Path) -> None:
    wide = json.dumps([0.5] * 30_000)
    rows = (f'{{"image": {wide}, "q": {Q[i]:.17g}, "tau": {U[i]:.17g}}}'.encode() for i in range(300))
    bag = mcap_of(tmp_path / "a.mcap", "drive", "json", None, rows)
    given = SignalSelection(motor_position="drive:q", effort="drive:tau")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert_true(read_recording(bag, given), latency=LATENCY_NS * 1e-9)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000


@pytest.mark.parametrize(
    "row", [b"", b"{", b"[" * 100_000, b'{"a":' * 50_000, b"\xff\xfe", b"nul", b"1e999999", b'{"joints": 5}',
            b'{"joints": [{"name": 5, "position": "x"}]}', b'{"timestamp": {"sec": 1e99, "nsec": null}, "joints": []}',
            json.dumps({"q": [0] * 70_000}).encode(), b"9" * 5000],
)  # fmt: skip
def test_damaged_json_is_passed_over(tmp_path: Path, row: bytes) -> None:
    rows = [json.dumps(foxglove(i)).encode() for i in range(SAMPLES)]
    rows[700] = row
    schema = ("foxglove.JointStates", "jsonschema", b"{}")
    assert_true(read_recording(mcap_of(tmp_path / "a.mcap", "/joint_states", "json", schema, rows)))
    with pytest.raises(SignalError) as caught:
        read_recording(mcap_of(tmp_path / "b.mcap", "/joint_states", "json", schema, [row] * 5))
    assert str(caught.value).isprintable()


def joint_states_proto() -> tuple[Any, bytes]:
    """The class and the descriptors of a message like foxglove.JointStates."""
    pytest.importorskip("google.protobuf", reason="needs protobuf (the extra foxglove)")
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, timestamp_pb2

    one = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(name="states.proto", package="foxglove", syntax="proto3")
    file.dependency.append("google/protobuf/timestamp.proto")
    joint = file.message_type.add(name="JointState")
    for number, (name, kind) in enumerate([("name", one.TYPE_STRING), ("position", one.TYPE_DOUBLE),
                                           ("velocity", one.TYPE_DOUBLE), ("effort", one.TYPE_DOUBLE)], 1):  # fmt: skip
        own = joint.field.add(name=name, number=number, type=kind, label=one.LABEL_OPTIONAL)
        if name != "name":
            own.proto3_optional, own.oneof_index = True, number - 2
            joint.oneof_decl.add(name=f"_{name}")
    states = file.message_type.add(name="JointStates")
    states.field.add(name="timestamp", number=1, type=one.TYPE_MESSAGE, label=one.LABEL_OPTIONAL,
                     type_name=".google.protobuf.Timestamp")  # fmt: skip
    states.field.add(name="joints", number=2, type=one.TYPE_MESSAGE, label=one.LABEL_REPEATED,
                     type_name=".foxglove.JointState")  # fmt: skip
    states.field.add(name="raw", number=3, type=one.TYPE_FLOAT, label=one.LABEL_REPEATED)
    clock = descriptor_pb2.FileDescriptorProto.FromString(timestamp_pb2.DESCRIPTOR.serialized_pb)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(clock)
    pool.Add(file)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName("foxglove.JointStates"))
    return kind, descriptor_pb2.FileDescriptorSet(file=[file, clock]).SerializeToString()


def protobuf_rows(kind: Any) -> list[bytes]:
    rows = []
    for i in range(SAMPLES):
        seconds, rest = divmod(ns(TIME[i]), 1_000_000_000)
        message = kind(raw=[0.0, Q[i], U[i]])
        message.timestamp.seconds, message.timestamp.nanos = seconds, rest
        message.joints.add(name="joint_1", position=0.5)
        message.joints.add(name="joint_2", position=Q[i], effort=U[i])
        rows.append(message.SerializeToString())
    return rows


def test_joint_states_as_protobuf(tmp_path: Path) -> None:
    kind, schema = joint_states_proto()
    rows = protobuf_rows(kind)
    rows[600], rows[601] = b"", b"\xff\xff\xff"
    bag = mcap_of(tmp_path / "a.mcap", "/joint_states", "protobuf", ("foxglove.JointStates", "protobuf", schema), rows)
    recording = read_recording(bag)
    assert recording.joint == "joint_2"
    assert recording.sampling[0].clock == "header"
    assert_true(recording)
    assert "bag_damaged" in {n.code for n in recording.notices}
    given = SignalSelection(
        joint="a", motor_position="joint_states:joints[1].position", effort="joint_states:joints[1].effort"
    )
    assert_true(read_recording(bag, given))


def test_protobuf_without_its_schema_or_library_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kind, schema = joint_states_proto()
    rows = protobuf_rows(kind)
    for own in (b"", schema[:100], b"\xff" * 50):
        bag = mcap_of(tmp_path / "a.mcap", "/joint_states", "protobuf", ("foxglove.JointStates", "protobuf", own), rows)
        with pytest.raises(SignalError, match=r"the protobuf schema 'foxglove\.JointStates' is not whole"):
            read_recording(bag)

    def absent(name: str) -> Any:
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(extras.importlib, "import_module", absent)
    with pytest.raises(
        extras.MissingExtraError, match=r"need protobuf: pip install 'flex_ident\[foxglove\]'"
    ) as caught:
        read_recording(bag)
    assert caught.value.exit_status == 2
