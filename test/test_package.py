"""package.xml names what nodes and launch files import, and agrees with setup.py."""

import ast
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
APT = {
    "yaml": "python3-yaml",
    "rosbags": "python3-rosbags-pip",
    **{n: f"python3-{n}" for n in ("numpy", "scipy", "matplotlib", "jinja2", "tqdm", "numba")},
}
EXTRAS = {"google", "h5py", "pyarrow", "dask", "distributed"}
"""What setup.py's extras bring: imported where a file needs it, and asked for in one line where it is missing."""


def imported(path: Path) -> set[str]:
    """Names of the packages that a file imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(a.name for a in node.names)
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module or "")
    return {n.partition(".")[0] for n in names} - {"flex_ident", "__future__"} - set(sys.stdlib_module_names)


def test_what_is_imported_is_declared_once() -> None:
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    declared = [e.text for e in package.findall("exec_depend")]
    assert len(declared) == len(set(declared))
    files = [*(ROOT / "flex_ident").rglob("*.py"), *(ROOT / "launch").glob("*.py")]
    used = set().union(*map(imported, files)) - EXTRAS
    assert {APT.get(n, n) for n in used} == set(declared)


def test_package_and_setup_agree() -> None:
    package = ElementTree.parse(ROOT / "package.xml").getroot()
    setup = (ROOT / "setup.py").read_text(encoding="utf-8")
    for key, tag in (("version", "version"), ("license", "license"), ("maintainer", "maintainer")):
        assert re.search(rf'{key}="(.*?)"', setup).group(1) == package.findtext(tag)
    required = re.search(r"install_requires=\[(.*?)\]", setup, re.S).group(1)
    names = set(re.findall(r'"(\w+)', required)) - EXTRAS
    assert {APT.get(n, APT.get(n.removeprefix("py"), n)) for n in names} <= {
        e.text for e in package.findall("exec_depend")
    }
