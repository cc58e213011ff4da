"""Tables of every kind as a bag that identify_bag reads; what is no recording is refused in one line."""

import json
import math
import os
import resource
import struct
import subprocess
import sys
import sysconfig
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from flex_ident.bags import extras
from flex_ident.bags.extras import MissingExtraError
from flex_ident.bags.motions import joint_motions
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.configuration import IMPORT_SETTINGS, read_settings
from flex_ident.errors import BagError, FlexIdentError, SignalError, UsageError
from flex_ident.formats import Imported, imported, matlab_content, matlab_files, tables

SAMPLES, RATE_HZ = 2000, 250.0
TIME = np.arange(SAMPLES) / RATE_HZ
Q, DQ, TAU = 0.3 * np.sin(8.0 * TIME), 2.4 * np.cos(8.0 * TIME), 5.0 * np.cos(8.0 * TIME)
HELD = np.full(SAMPLES, 0.5)
TWO = {"q": np.column_stack((HELD, Q)), "tau": np.column_stack((0.0 * HELD, TAU))}


def import_of(file: Path | list[Path], bag: Path, **given: object) -> Imported:
    values = {s.key: s.default for s in IMPORT_SETTINGS}
    return imported(file, bag, {**values, **{f"import.{key}": value for key, value in given.items()}})


def assert_true(bag: Path, joint: str | None = None, *, atol: float = 1e-9) -> None:
    recording = read_recording(bag, SignalSelection(joint=joint))
    np.testing.assert_allclose(recording.motor_position, 0.3 * np.sin(8.0 * recording.time), atol=max(atol, 1e-5))
    np.testing.assert_allclose(recording.motor_torque, 5.0 * np.cos(8.0 * recording.time), atol=max(atol, 1e-3))


def csv_file(path: Path, head: str, *columns: np.ndarray[Any, Any]) -> Path:
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.12g")
    return path


def test_csv(tmp_path: Path) -> None:
    done = import_of(csv_file(tmp_path / "a.csv", "time,q,tau", TIME, Q, TAU), tmp_path / "bag")
    assert_true(tmp_path / "bag")
    assert done.lines[0] == "time: time, 2000 samples at 250.00 Hz"
    assert done.lines[1] == "joint: position q, effort tau"
    assert "taken by their names: time, position, effort" in done.lines[2]


def test_many_joints_with_link_and_reference(tmp_path: Path) -> None:
    head = "t,q1,q2,tau1,tau2,dq2,ql2,q_ref2"
    file = csv_file(tmp_path / "a.csv", head, TIME, HELD, Q, 0.0 * HELD, TAU, DQ, Q + 1e-3 * TAU, 1.1 * Q)
    import_of(file, tmp_path / "bag", joints="base,elbow")
    assert_true(tmp_path / "bag")
    recording = read_recording(tmp_path / "bag")
    assert recording.joint == "elbow"
    assert recording.link_position is not None
    assert {m.name for m in joint_motions(tmp_path / "bag")} == {"base", "elbow"}
    assert [s.source for s in recording.sampling if s.role == "reference"] == [
        "/chirp_exciter/reference:elbow.position"
    ]


def test_units_in_names_are_converted_and_scales_win(tmp_path: Path) -> None:
    file = csv_file(tmp_path / "a.csv", "t [ms],q [deg],tau [mNm]", 1e3 * TIME, np.degrees(Q), 1e3 * TAU)
    done = import_of(file, tmp_path / "bag")
    assert_true(tmp_path / "bag")
    assert done.lines[0].startswith("time: t [ms] times 0.001, 2000 samples")
    assert "q [deg] times 0.0174533" in done.lines[1]
    file = csv_file(tmp_path / "b.csv", "t,angle,current", 1e9 * TIME, np.degrees(Q), TAU / 2.0)
    done = import_of(file, tmp_path / "bag_b", time_scale=1e-9, position_scale=math.pi / 180.0, effort="current",
                     effort_scale=2.0)  # fmt: skip
    assert_true(tmp_path / "bag_b")
    assert not any("degrees" in line or "no torque" in line for line in done.lines)


def test_what_does_not_look_like_si_is_said(tmp_path: Path) -> None:
    file = csv_file(tmp_path / "a.csv", "t,angle,current", TIME, 60.0 * Q, TAU)
    lines = import_of(file, tmp_path / "bag", effort="current").lines
    assert any("joint moves 36: if that is in degrees" in line for line in lines)
    assert any("the effort current is no torque by its name" in line for line in lines)


def test_without_time_by_the_rate(tmp_path: Path) -> None:
    file = csv_file(tmp_path / "a.csv", "q,tau", Q, TAU)
    assert "as said" in import_of(file, tmp_path / "bag", rate_hz=RATE_HZ).lines[0]
    assert_true(tmp_path / "bag")


def test_rows_that_do_not_advance_are_dropped_and_counted(tmp_path: Path) -> None:
    time = TIME.copy()
    time[[500, 900]] = time[499], math.nan
    done = import_of(csv_file(tmp_path / "a.csv", "time,q,tau", time, Q, TAU), tmp_path / "bag")
    assert done.lines[0].endswith("1998 samples at 250.00 Hz, 2 rows dropped that do not advance")
    assert_true(tmp_path / "bag")


def test_a_mapping_in_the_configuration(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text(
        "flex_ident:\n  ros__parameters:\n    import:\n      time: ms\n      time_scale: 0.001\n"
        "      joints: [a, b]\n      position: [p, x]\n      effort: u,y\n"
    )
    given = read_settings(tmp_path / "map.yaml", IMPORT_SETTINGS, node="identifier", command="flex_ident")
    file = csv_file(tmp_path / "a.csv", "p,x,u,y,ms", HELD, Q, 0.0 * HELD, TAU, 1e3 * TIME)
    imported(file, tmp_path / "bag", {**{s.key: s.default for s in IMPORT_SETTINGS}, **given})
    assert_true(tmp_path / "bag", "b")


@pytest.mark.parametrize("compressed", [True, False])
@pytest.mark.parametrize("structure", [True, False])
def test_matlab_5(tmp_path: Path, compressed: bool, structure: bool) -> None:
    content = {"t": TIME, "q": TWO["q"], "tau": TWO["tau"].T, "note": "text", "scalar": 3.0, "cell": [[1, "a"]]}
    content = {"log": content} if structure else content
    scipy.io.savemat(tmp_path / "a.mat", content, do_compression=compressed)
    done = import_of(tmp_path / "a.mat", tmp_path / "bag")
    assert_true(tmp_path / "bag")
    assert f"position {'log.' if structure else ''}q.1" in done.lines[2]


@pytest.mark.parametrize("bits", [0x7FF0000000000001, 0x7FE1CCF385EBC8A0, 0xFFF0000000000000])
def test_numbers_with_which_no_one_can_reckon_are_dropped_without_a_warning(bits: int, tmp_path: Path) -> None:
    table = np.column_stack((TIME, Q, TAU))
    table.view(np.uint64)[[700, 900], [0, 1]] = bits
    np.save(tmp_path / "a.npy", table)
    with np.errstate(all="raise"):
        done = import_of(tmp_path / "a.npy", tmp_path / "bag", time="column.0", position="column.1", effort="column.2")
    assert done.lines[0].endswith("1 rows dropped that do not advance")
    assert_true(tmp_path / "bag")


def test_a_reader_that_crashes_takes_nobody_along(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    crash = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
    monkeypatch.setattr(matlab_content, "START", crash)
    scipy.io.savemat(tmp_path / "a.mat", {"t": TIME, "q": Q, "tau": TAU})
    with pytest.raises(SignalError, match=r"is damaged \(SIGSEGV in scipy's reader"):
        import_of(tmp_path / "a.mat", tmp_path / "bag")


def test_numpy_archives(tmp_path: Path) -> None:
    more = {"names": np.array(["a", "b"]), "made": np.array([{"by": 1}], object), "tau_command": TWO["q"]}
    np.savez(tmp_path / "a.npz", time=TIME, q=TWO["q"], tau_measured=TWO["tau"], **more)
    done = import_of(tmp_path / "a.npz", tmp_path / "bag")
    assert_true(tmp_path / "bag")
    assert done.lines[2].startswith("joint_1: position q.1, effort tau_measured.1")
    np.save(tmp_path / "b.npy", np.column_stack((TIME, Q, TAU)))
    import_of(tmp_path / "b.npy", tmp_path / "bag_b", time="column.0", position="column.1", effort="column.2")
    assert_true(tmp_path / "bag_b")


@pytest.mark.parametrize("damage", ["objects", "cut", "zip"])
def test_numpy_files_that_hold_no_numbers(tmp_path: Path, damage: str) -> None:
    file = tmp_path / "a.npz"
    np.savez(file, made=np.array([{"by": 1}], object)) if damage == "objects" else np.savez(file, q=Q)
    if damage == "cut":
        file.write_bytes(file.read_bytes()[:-200])
    if damage == "zip":
        file.write_bytes(b"PK\x03\x04 and no archive")
    with pytest.raises(SignalError, match="holds no numeric arrays" if damage == "objects" else "is damaged") as caught:
        import_of(file, tmp_path / "bag")
    assert "\n" not in str(caught.value)


def test_files_side_by_side(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "time.txt", TIME)
    np.savetxt(tmp_path / "angle.txt", TWO["q"])
    np.savetxt(tmp_path / "torque.txt", TWO["tau"])
    files = [tmp_path / f"{name}.txt" for name in ("time", "angle", "torque")]
    given = {"position": "angle.column_1..angle.column_2", "effort": "torque.column_1..torque.column_2"}
    done = import_of(files, tmp_path / "bag", joints="a,b", **given)
    assert_true(tmp_path / "bag", "b")
    assert done.lines[0] == "time: time, 2000 samples at 250.00 Hz"
    np.savetxt(tmp_path / "torque.txt", TWO["tau"][:-5])
    with pytest.raises(SignalError, match="different lengths"):
        import_of(files, tmp_path / "bag_b", **given)
    with pytest.raises(SignalError, match="two of the files are called alike: time"):
        import_of([files[0], files[0]], tmp_path / "bag_b", **given)
    with pytest.raises(UsageError, match=r"column_1 stands before angle\.column_2"):
        import_of(files, tmp_path / "bag_b", position="angle.column_2..angle.column_1")


def hdf5(path: Path, datasets: dict[str, Any], *, matlab: bool = False) -> Path:
    h5py = pytest.importorskip("h5py", reason="needs h5py (the extra hdf5)")
    with h5py.File(path, "w", userblock_size=512 if matlab else 0) as file:
        for name, values in datasets.items():
            file[name] = np.atleast_2d(values).reshape(1, -1) if matlab and values.ndim == 1 else values
    if matlab:
        with path.open("r+b") as raw:
            raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64")
    return path


def test_matlab_73(tmp_path: Path) -> None:
    datasets = {"log/t": TIME, "log/q": TWO["q"].T, "log/tau": TWO["tau"].T}
    done = import_of(hdf5(tmp_path / "a.mat", datasets, matlab=True), tmp_path / "bag")
    assert_true(tmp_path / "bag")
    assert "position log.q.1, effort log.tau.1" in done.lines[2]


def test_hdf5_as_robot_learning_leaves_it(tmp_path: Path) -> None:
    datasets = {
        "observations/qpos": TWO["q"], "observations/effort": TWO["tau"], "action": TWO["q"],
        "observations/images/top": np.zeros((SAMPLES, 4, 4, 3), np.uint8),
    }  # fmt: skip
    import_of(hdf5(tmp_path / "a.hdf5", datasets), tmp_path / "bag", rate_hz=RATE_HZ)
    assert_true(tmp_path / "bag", "joint_1")


def parquet(path: Path, columns: dict[str, Any]) -> Path:
    arrow = pytest.importorskip("pyarrow", reason="needs pyarrow (the extra parquet)", exc_type=ImportError)
    import pyarrow.parquet

    path.parent.mkdir(parents=True, exist_ok=True)
    lists = {name: own.tolist() if getattr(own, "ndim", 1) == 2 else own for name, own in columns.items()}
    pyarrow.parquet.write_table(arrow.table(lists), path)
    return path


def test_parquet(tmp_path: Path) -> None:
    stamps = np.datetime64("2026-11-26T12:00:00", "us") + (1e6 * TIME).astype("timedelta64[us]")
    done = import_of(
        parquet(tmp_path / "a.parquet", {"stamp": stamps, **TWO, "note": ["x"] * SAMPLES}), tmp_path / "bag"
    )
    assert_true(tmp_path / "bag", "joint_1")
    assert done.lines[0] == "time: stamp times 1e-09, 2000 samples at 250.00 Hz"


def test_lists_of_changing_length_are_not_mixed_up(tmp_path: Path) -> None:
    lists = [[float(q)] if i % 7 == 3 else [0.5, float(q)] for i, q in enumerate(Q)]
    import_of(parquet(tmp_path / "a.parquet", {"t": TIME, "q": lists, "tau": TWO["tau"]}), tmp_path / "bag")
    assert_true(tmp_path / "bag", "joint_1", atol=2e-2)


MOTORS = ["shoulder_pan.pos", "elbow_flex.pos"]


def lerobot(folder: Path, version: str, *, effort: bool = True) -> Path:
    """Three episodes, of which number 1 holds the swing, in degrees."""
    names: Any = MOTORS if version == "v3.0" else {"motors": MOTORS}
    features = {"observation.state": {"dtype": "float32", "shape": [2], "names": names},
                "observation.effort": {"dtype": "float32", "shape": [2], "names": names},
                "action": {"dtype": "float32", "shape": [2], "names": names}}  # fmt: skip
    (folder / "meta").mkdir(parents=True)
    information = {"codebase_version": version, "fps": RATE_HZ, "total_episodes": 3, "features": features}
    (folder / "meta" / "info.json").write_text(json.dumps(information))
    rows: list[dict[str, Any]] = []
    for episode in range(3):
        state = np.degrees(TWO["q"]) if episode == 1 else 0.0 * TWO["q"]
        rows.append({
            "observation.state": state.astype(np.float32), "action": state.astype(np.float32),
            "timestamp": TIME.astype(np.float32), "episode_index": np.full(SAMPLES, episode),
            **({"observation.effort": TWO["tau"].astype(np.float32)} if effort else {}),
        })  # fmt: skip
    if version == "v3.0":
        whole = {name: np.concatenate([own[name] for own in rows]) for name in rows[0]}
        parquet(folder / "data" / "chunk-000" / "file-000.parquet", whole)
    else:
        for episode, own in enumerate(rows):
            parquet(folder / "data" / "chunk-000" / f"episode_{episode:06d}.parquet", own)
    return folder


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_an_episode_of_a_lerobot_dataset(tmp_path: Path, version: str) -> None:
    dataset = lerobot(tmp_path / "data_set", version)
    done = import_of(dataset, tmp_path / "bag", episode=1, position_scale=math.pi / 180.0)
    assert {m.name: m.moves for m in joint_motions(tmp_path / "bag")} == {"shoulder_pan": False, "elbow_flex": True}
    assert_true(tmp_path / "bag", atol=1e-4)
    assert "elbow_flex: position observation.state.elbow_flex.pos" in done.lines[2]
    with pytest.raises(UsageError, match="holds 3 episodes: name one with --episode"):
        import_of(dataset, tmp_path / "other")
    with pytest.raises(UsageError, match=r"--episode is 3, expected 0 to 2"):
        import_of(dataset, tmp_path / "other", episode=3)


def test_a_dataset_without_effort_is_refused_by_name(tmp_path: Path) -> None:
    dataset = lerobot(tmp_path / "data_set", "v3.0", effort=False)
    with pytest.raises(SignalError, match=r"no column for effort among observation\.state\.shoulder_pan\.pos"):
        import_of(dataset, tmp_path / "bag", episode=1)


def same(file: Path) -> Path:
    return file


def damaged_hdf5(file: Path) -> Path:
    file.write_bytes(b"\x89HDF\r\n\x1a\n" + os.urandom(4000))
    return file


def damaged_parquet(file: Path) -> Path:
    file.write_bytes(b"PAR1" + os.urandom(4000) + b"PAR1")
    return file


def damaged_matlab(file: Path) -> Path:
    scipy.io.savemat(file, {"t": TIME, "q": Q})
    content = bytearray(file.read_bytes())
    content[140:400] = os.urandom(260)
    file.write_bytes(content)
    return file


def text(content: str) -> Callable[[Path], Path]:
    def write(file: Path) -> Path:
        file.write_text(content)
        return file

    return write


def folder(file: Path) -> Path:
    file.mkdir()
    return file


def broken_dataset(file: Path) -> Path:
    (file / "meta").mkdir(parents=True)
    (file / "meta" / "info.json").write_text('{"total_episodes": 1')
    return file


@pytest.mark.parametrize(
    ("make", "given", "error", "said"),
    [
        (same, {}, SignalError, "no such file"), (damaged_hdf5, {}, SignalError, "damaged, or not HDF5"),
        (damaged_parquet, {}, SignalError, "damaged, or not Parquet"), (damaged_matlab, {}, SignalError, "a.x: "),
        (folder, {}, SignalError, "no LeRobot dataset"), (broken_dataset, {}, SignalError, "is not JSON"),
        (text("t,q,tau\n"), {}, SignalError, "0 rows of numbers"),
        (text("t,q,tau\n0,1,2\n1,2,3\n"), {}, SignalError, "2 rows of numbers"),
        (text("t,q,tau\n" + "x,y,z\n" * 9), {}, SignalError, "0 rows of numbers"),
        (text("t,q,tau\n" + "1,1,2\n" * 9), {}, SignalError, "does not advance in 8 of 9 rows"),
        (text("t,q,tau\n" + "".join(f"{i},1,2\n" for i in range(9))), {}, SignalError, "come at 1 Hz.*--time-scale"),
        (text("t,q,tau\n0,1,2\n0.1,2,3\n1e300,3,4\n"), {}, SignalError, r"span 1e\+300 s"),
        (text("t,q,tau\n0,1,2\n0.1,2,3\n0.2,3,4\n"), {"episode": 0}, UsageError, "of LeRobot datasets"),
        (text("t,q,tau\n0,1,2\n0.1,2,3\n0.2,3,4\n"), {"episode": 0.5}, UsageError, "whole number"),
        (text("a\0b"), {}, SignalError, "no table that is known"),
        (text(""), {}, SignalError, "neither names of columns"),
    ],
)  # fmt: skip
def test_what_cannot_be_imported_is_one_line_and_leaves_nothing(
    tmp_path: Path, make: Callable[[Path], Path], given: dict[str, object], error: type[FlexIdentError], said: str
) -> None:
    for library in ("h5py", "pyarrow"):
        if library[:2] in make.__name__.replace("hdf5", "h5py").replace("parquet", "pyarrow"):
            pytest.importorskip(library, exc_type=ImportError)
    file = make(tmp_path / "a.x")
    with pytest.raises(error, match=said) as caught:
        import_of(file, tmp_path / "bag", **given)
    assert str(caught.value).isprintable()
    assert not (tmp_path / "bag").exists()


def test_nothing_is_written_over(tmp_path: Path) -> None:
    file = csv_file(tmp_path / "a.csv", "time,q,tau", TIME, Q, TAU)
    import_of(file, tmp_path / "bag")
    with pytest.raises(UsageError, match="exists already"):
        import_of(file, tmp_path / "bag")
    with pytest.raises(UsageError, match="is a bag already"):
        import_of(tmp_path / "bag", tmp_path / "other")
    with pytest.raises(UsageError, match="is a bag already"):
        import_of(next((tmp_path / "bag").glob("*.mcap")), tmp_path / "other")
    with pytest.raises(BagError, match="make a bag of it with flex_ident import FILE --out BAG"):
        read_recording(file)


@pytest.mark.parametrize(("name", "head"), [("h5py", b"\x89HDF\r\n\x1a\n"), ("pyarrow", b"PAR1")])
def test_a_missing_library_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, head: bytes
) -> None:
    def absent(module: str) -> Any:
        raise ModuleNotFoundError(module)

    monkeypatch.setattr(extras.importlib, "import_module", absent)
    (tmp_path / "a").write_bytes(head + bytes(100))
    with pytest.raises(MissingExtraError, match=rf"need {name}: pip install 'flex_ident\[") as caught:
        import_of(tmp_path / "a", tmp_path / "bag")
    assert caught.value.exit_status == 2


def test_a_bomb_is_refused_before_it_bursts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    packed = zlib.compress(struct.pack("<II", 14, 1 << 28) + bytes(1 << 26), 9)
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"
    (tmp_path / "a.mat").write_bytes(head + struct.pack("<II", 15, len(packed)) + packed)
    monkeypatch.setattr(matlab_files, "MOST_NUMBERS", 1 << 20)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(SignalError, match="unpacks to over"):
        import_of(tmp_path / "a.mat", tmp_path / "bag")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 20_000
    monkeypatch.setattr(tables, "MOST_NUMBERS", 1000)
    with pytest.raises(SignalError, match="are read at most"):
        import_of(csv_file(tmp_path / "a.csv", "time,q,tau", TIME, Q, TAU), tmp_path / "bag")


@pytest.mark.slow
def test_the_command(tmp_path: Path) -> None:
    csv_file(tmp_path / "log.csv", "time,q,tau", TIME, Q, TAU)
    command = [sys.executable, Path(sysconfig.get_path("scripts")) / "flex_ident", "import"]
    done = subprocess.run([*command, "log.csv", "--out", "my_bag"], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1] == "written: my_bag"
    assert_true(tmp_path / "my_bag")
    for words, status in ((["log.csv"], 2), (["log.csv", "--out", "b", "--position", "no"], 3),
                          (["no.csv", "--out", "b"], 3), (["log.csv", "--out", "b", "--rate", "x"], 2)):  # fmt: skip
        done = subprocess.run([*command, *words], cwd=tmp_path, capture_output=True, text=True)
        assert (done.returncode, len(done.stderr.splitlines()), done.stdout) == (status, 1, ""), done.stderr
