"""The shape: data flows one way, and the core knows nothing of ROS, bags or the command line."""

import ast
from pathlib import Path

import pytest

import flex_ident

ROOT = Path(flex_ident.__file__).parent
STAGES = (
    "notices", "recording", "parameters", "filtering", "regression", "effects", "simulation", "estimation", "gap",
    "excitation", "virtual_joint",
)  # fmt: skip
ADAPTERS = ("bags", "configuration", "report", "jobs", "commands", "nodes")
FOREIGN = ("rclpy", "rosbags", "matplotlib", "jinja2", "tqdm", "std_msgs", "sensor_msgs")
ALLOWED: dict[str, tuple[str, ...]] = {
    "notices": (),
    "recording": ("notices",),
    "parameters": ("notices", "recording"),
    "filtering": ("recording", "parameters"),
    "regression": ("notices", "recording", "parameters", "filtering"),
    "simulation": ("recording", "parameters", "filtering"),
    "effects": ("recording", "parameters", "simulation"),
    "estimation": ("notices", "recording", "parameters", "filtering", "regression", "simulation", "effects"),
    "gap": ("notices", "recording", "parameters", "filtering", "regression", "simulation", "effects", "estimation"),
    "excitation": (),
    "virtual_joint": ("recording", "parameters"),
}


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


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_imports_only_earlier_stages(stage: str) -> None:
    for path in (ROOT / stage).rglob("*.py"):
        for name in imported(path):
            parts = name.split(".")
            assert parts[0] not in FOREIGN, f"{path.name} imports {name}"
            if parts[0] == "flex_ident" and len(parts) > 1:
                assert parts[1] in (*ALLOWED[stage], stage, "errors"), f"{stage}/{path.name} imports {name}"


@pytest.mark.parametrize("adapter", [a for a in ADAPTERS if a != "nodes"])
def test_only_nodes_need_ros(adapter: str) -> None:
    for path in (ROOT / adapter).rglob("*.py"):
        assert not any(n.split(".")[0] == "rclpy" for n in imported(path)), path


@pytest.mark.parametrize("adapter", ["bags", "configuration", "report", "jobs"])
def test_what_commands_and_nodes_share_knows_neither(adapter: str) -> None:
    for path in (ROOT / adapter).rglob("*.py"):
        for name in imported(path):
            assert not name.startswith(("flex_ident.commands", "flex_ident.nodes")), f"{path.name} imports {name}"
            assert adapter == "jobs" or not name.startswith("flex_ident.jobs"), f"{path.name} imports {name}"


def test_every_folder_is_in_the_architecture() -> None:
    text = (ROOT.parent / "ARCHITECTURE.md").read_text(encoding="utf-8")
    for folder in (p for p in ROOT.iterdir() if (p / "__init__.py").exists()):
        assert f"`{folder.name}/`" in text, folder.name
