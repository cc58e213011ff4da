"""The shape: data flows one way, and the core knows nothing of ROS, bags or the command line."""

import ast
from pathlib import Path

import pytest

import flex_ident

ROOT = Path(flex_ident.__file__).parent
STAGES = (
    "notices", "recording", "parameters", "judgement", "filtering", "simulation", "effects", "regression", "likelihood",
    "screening", "estimation", "gap", "pooling",
)  # fmt: skip
"""The method, each stage above what it may import."""
ASIDE = ("excitation", "virtual_joint", "robot")
"""Core that the method does not import: what moves a joint, a joint to move, and what a robot's description says."""
ADAPTERS = ("bags", "formats", "configuration", "report", "jobs", "fleet", "commands", "nodes")
FOREIGN = ("rclpy", "rosbags", "matplotlib", "jinja2", "tqdm", "std_msgs", "sensor_msgs")
ALLOWED: dict[str, tuple[str, ...]] = {
    "notices": (),
    "recording": ("notices",),
    "parameters": ("notices", "recording"),
    "judgement": ("notices", "parameters"),
    "filtering": ("recording", "parameters"),
    "simulation": ("recording", "parameters", "filtering"),
    "effects": ("notices", "recording", "parameters", "simulation"),
    "regression": ("notices", "recording", "parameters", "judgement", "filtering"),
    "likelihood": ("recording", "parameters", "judgement", "filtering", "simulation", "effects"),
    "screening": ("recording", "parameters", "filtering", "simulation", "effects", "likelihood"),
    "estimation": (
        "notices", "recording", "parameters", "judgement", "filtering", "simulation", "effects", "regression",
        "likelihood", "screening",
    ),
    "gap": (
        "notices", "recording", "parameters", "judgement", "filtering", "effects", "regression", "likelihood",
        "screening", "estimation",
    ),
    "pooling": ("notices", "recording", "parameters", "judgement"),
    "excitation": ("robot",),
    "virtual_joint": ("recording", "parameters"),
    "robot": ("recording",),
}  # fmt: skip
"""What each folder of the core imports beside itself and `errors`: no more than it does today."""
METHOD = ("regression", "likelihood", "screening", "estimation", "gap")


def imported(path: Path) -> set[str]:
    """Names of all modules that a file imports, wherever in it."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(a.name for a in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names.add(node.module or "")
    return names


def test_stages_are_in_order() -> None:
    assert set(ALLOWED) == {*STAGES, *ASIDE}
    for i, stage in enumerate(STAGES):
        assert set(ALLOWED[stage]) <= set(STAGES[:i]), stage
    for stage in ASIDE:
        assert not set(ALLOWED[stage]) & set(METHOD), stage


def test_every_folder_is_a_stage_or_an_adapter() -> None:
    folders = {p.name for p in ROOT.iterdir() if (p / "__init__.py").exists()}
    assert folders == {*STAGES, *ASIDE, *ADAPTERS}


@pytest.mark.parametrize("stage", [*STAGES, *ASIDE])
def test_a_stage_imports_only_earlier_stages(stage: str) -> None:
    for path in (ROOT / stage).rglob("*.py"):
        for name in imported(path):
            parts = name.split(".")
            assert name != "flex_ident", f"{stage}/{path.name} imports the whole package"
            assert parts[0] not in FOREIGN, f"{path.name} imports {name}"
            if parts[0] == "flex_ident" and len(parts) > 1:
                assert parts[1] in (*ALLOWED[stage], stage, "errors"), f"{stage}/{path.name} imports {name}"


@pytest.mark.parametrize("adapter", [a for a in ADAPTERS if a != "nodes"])
def test_only_nodes_need_ros(adapter: str) -> None:
    for path in (ROOT / adapter).rglob("*.py"):
        assert not any(n.split(".")[0] == "rclpy" for n in imported(path)), path


@pytest.mark.parametrize("adapter", ["bags", "formats", "configuration", "report", "jobs", "fleet"])
def test_what_commands_and_nodes_share_knows_neither(adapter: str) -> None:
    for path in (ROOT / adapter).rglob("*.py"):
        for name in imported(path):
            assert not name.startswith(("flex_ident.commands", "flex_ident.nodes")), f"{path.name} imports {name}"
            assert adapter == "fleet" or not name.startswith("flex_ident.fleet"), f"{path.name} imports {name}"
            assert adapter in ("jobs", "fleet") or not name.startswith("flex_ident.jobs"), f"{path.name} imports {name}"


def test_every_folder_is_in_the_architecture() -> None:
    text = (ROOT.parent / "ARCHITECTURE.md").read_text(encoding="utf-8")
    for folder in (p for p in ROOT.iterdir() if (p / "__init__.py").exists()):
        assert f"`{folder.name}/`" in text, folder.name
