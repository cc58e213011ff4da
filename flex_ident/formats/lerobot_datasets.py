"""LeRobot datasets, versions 2 and 3: an episode's Parquet rows, with the names of motors from `meta/info.json`."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flex_ident.errors import SignalError, UsageError
from flex_ident.formats.parquet_files import ParquetFiles
from flex_ident.parameters.documents import DocumentError, text_of
from flex_ident.recording.names import harmless, path_text

INFORMATION = Path("meta") / "info.json"
EPISODE = re.compile(r"episode_(\d+)\.parquet$")
EPISODE_COLUMN = "episode_index"
LARGEST_INFORMATION = 1 << 22
MOST_FILES = 1 << 17


def is_lerobot(path: Path) -> bool:
    """Whether the folder is a LeRobot dataset."""
    return (path / INFORMATION).is_file()


def lerobot_episode(path: Path, episode: int | None) -> ParquetFiles:
    """The rows of one episode; `episode` may be left out where there is but one.

    Raises SignalError, UsageError without an episode that there is, and MissingExtraError without pyarrow.
    """
    shown = path_text(path)
    content = _information(path)
    files = sorted((path / "data").rglob("*.parquet"))[:MOST_FILES]
    if not files:
        raise SignalError(f"{shown}: a LeRobot dataset without data (no data/**/*.parquet).")
    count = content.get("total_episodes")
    known = count if isinstance(count, int) and count > 0 else None
    if episode is None and known != 1:
        raise UsageError(f"{shown}: holds {known or 'several'} episodes: name one with --episode, from 0.")
    number = episode or 0
    if known is not None and number >= known:
        raise UsageError(f"{shown}: holds {known} episodes: --episode is {number}, expected 0 to {known - 1}.")
    own = [file for file in files if (match := EPISODE.search(file.name)) and int(match.group(1)) == number]
    if own:
        return ParquetFiles(own[:1], shown, labels=_labels(content))
    return ParquetFiles(files, shown, labels=_labels(content), only=(EPISODE_COLUMN, number))


def _information(path: Path) -> Mapping[str, Any]:
    shown = path_text(path / INFORMATION)
    try:
        content = json.loads(text_of(path / INFORMATION, LARGEST_INFORMATION))
    except DocumentError as error:
        raise SignalError(f"{shown}: {error}") from error
    except (ValueError, RecursionError) as error:
        raise SignalError(f"{shown}: is not JSON.") from error
    if not isinstance(content, dict):
        raise SignalError(f"{shown}: describes no dataset.")
    return content


def _labels(content: Mapping[str, Any]) -> dict[str, list[str]]:
    """Names of the numbers in each feature: a list, or a list under one key such as `motors`."""
    features = content.get("features")
    found: dict[str, list[str]] = {}
    for name, feature in features.items() if isinstance(features, dict) else ():
        names = feature.get("names") if isinstance(feature, dict) else None
        if isinstance(names, dict) and len(names) == 1:
            names = next(iter(names.values()))
        if isinstance(names, list) and all(isinstance(own, str) for own in names):
            found[str(name)] = [harmless(own) for own in names]
    return found
