"""The virtual joint's experiment as a bag says what its recording says, however it is stored."""

from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags.reading import read_recording
from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.bags.writing import write_joint_states
from flex_ident.errors import UsageError
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, chain_for
from flex_ident.virtual_joint.run import virtual_recording


@pytest.mark.slow
@pytest.mark.parametrize("storage", ["mcap", pytest.param("sqlite3", marks=pytest.mark.campaign)])
@pytest.mark.parametrize("compression", ["", pytest.param("file", marks=pytest.mark.campaign), "message"])
def test_a_virtual_bag_is_read_as_it_was_made(tmp_path: Path, storage: str, compression: str) -> None:
    experiment = Experiment(duration_s=5.0)
    made = virtual_recording(COBOT_JOINT, experiment, chain_for("network"), seed=4)
    options = {"storage": storage, "compression": compression}
    write_virtual_bag(tmp_path / "bag", COBOT_JOINT, experiment, chain_for("network"), seed=4, **options)
    read = read_recording(tmp_path / "bag")
    assert read.joint == "cobot"
    for role in ("motor_position", "motor_torque", "link_position"):
        there, here = getattr(read, role), getattr(made, role)
        assert np.max(np.abs(there - here)) < 1e-6 * np.std(here), role
    assert read.reference is not None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"storage": "hdf5"}, "storage is 'hdf5'"),
        ({"compression": "zip"}, "compression is 'zip'"),
        ({}, r"shape \(3, 2\)"),
    ],
)
def test_what_cannot_be_written_is_refused(tmp_path: Path, options: dict[str, str], message: str) -> None:
    values = np.zeros((3, 2 if not options else 1))
    with pytest.raises(UsageError, match=message):
        write_joint_states(tmp_path / "bag", np.arange(3.0), ["a"], values, values, values, **options)
    assert not (tmp_path / "bag").exists()


def test_a_folder_that_is_no_bag_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    values = np.zeros((3, 1))
    with pytest.raises(UsageError, match="not overwritten"):
        write_joint_states(tmp_path, np.arange(3.0), ["a"], values, values, values)
    assert (tmp_path / "notes.txt").read_text() == "mine"
