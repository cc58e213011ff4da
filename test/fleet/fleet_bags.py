"""Small recordings of a fleet: rigid virtual joints."""

from pathlib import Path

from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import Experiment

EXPERIMENT = Experiment(duration_s=10.0, sample_rate_hz=200.0)


def small_bag(path: Path, *, inertia: float = 2.0, seed: int = 0) -> Path:
    """A recording of a rigid joint, elbow."""
    model = JointModel({"J": inertia, "FV": 3.0, "FS": 1.0, "offset": 0.0}, joint="elbow")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_virtual_bag(path, model, EXPERIMENT, seed=seed)
    return path


def broken_bag(path: Path) -> Path:
    """A folder with a file that is no bag."""
    path.mkdir(parents=True)
    (path / "x.mcap").write_bytes(b"no bag")
    return path
