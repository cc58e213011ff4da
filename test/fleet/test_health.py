"""`flex_ident health` on made-up archives: what changed is found, dated and put down to something; nothing else is."""

import json
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flex_ident.commands.flex_ident import main
from flex_ident.errors import DataError, UsageError
from flex_ident.fleet.causes import Cause, probable_cause
from flex_ident.fleet.health import fleet_health
from flex_ident.fleet.ratios import ratios
from flex_ident.fleet.rows import Row, common_row, result_row
from flex_ident.report.health_table import CAUSES, health_text

TRUTH = {"Jm": 1.0, "K": 1e4, "JL": 2.0, "FVm": 8.0, "FSm": 4.0, "FV": 2.0, "FS": 1.0, "MX": 0.5, "MY": 3.0}
START, DAY = datetime(2026, 1, 1, tzinfo=UTC).timestamp(), 86400.0


def made_up(
    robots: int = 6, results: int = 8, *, seed: int = 0, changed: dict[str, float] | None = None, since: int = 5,
    until: int = 99, joints: int = 1, **common: Any,
) -> list[Row]:  # fmt: skip
    """Rows of robots whose parameters scatter by 2 %, a result each 30 days; those `changed` of robot 0 by factors."""
    rng = np.random.default_rng(seed)
    rows = []
    for robot, joint, i in np.ndindex(robots, joints, results):
        parameters = {}
        for key, truth in TRUTH.items():
            std = 0.005 * truth
            value = truth * rng.normal(1.0, 0.02) + std * rng.normal()
            if (robot, joint) == (0, 0) and since <= i < until:
                value *= (changed or {}).get(key, 1.0)
            parameters[key] = {"value": value, "std": std, "unit": "SI", "identifiable": True}
        content = {
            "joint": f"joint_{joint}", "sensors": "motor+link", "method": "auto", "verdict": "trusted",
            "parameters": parameters, "warnings": [],
        }  # fmt: skip
        given = {"tag": "first" if i < 2 else "", "conditions": {}, "settings": {}, **common}
        name = f"{robot}.{joint}.{i}"
        own = common_row(robot=f"arm {robot}", bag=name, sha256=name, **given)
        rows.append(result_row(own, content, start_time_s=START + 30 * DAY * i, seconds=1.0))
    return rows


def test_nothing_changed_and_nothing_said() -> None:
    alarmed = 0
    for seed in range(12):
        content = fleet_health(made_up(8, joints=3, seed=100 + seed))
        assert content["false_alarms"]["comparisons"] == 8 * 3 * 9 > 200
        alarmed += bool(content["changes"])
    assert alarmed <= 3  # 0.6 on average at 5 %
    assert {joint["state"] for joint in content["joints"]} == {"unchanged"}


@pytest.mark.parametrize("baseline", ["", "2026-04-05", "first"])
def test_a_change_is_found_dated_and_sized(baseline: str) -> None:
    held, said_falsely = 0, 0
    for seed in range(10):
        content = fleet_health(made_up(changed={"K": 0.8}, seed=seed), baseline)
        [change] = [own for own in content["changes"] if (own["robot"], own["parameter"]) == ("arm 0", "K")]
        said_falsely += len(content["changes"]) - 1
        low, high = change["ci95"]
        held += low <= -2000.0 <= high
        assert change["since"] == {"after": "2026-05-01T00:00:00+00:00", "until": "2026-05-31T00:00:00+00:00"}
        assert change["chance"] < 1e-2
    assert held >= 8
    assert said_falsely <= 2
    [joint] = [own for own in content["joints"] if own["state"] == "changed"]
    assert joint["cause"] == Cause.TRANSMISSION
    said = health_text(content)
    assert "stiffness fell" in said
    assert "Benjamini-Hochberg" in said


def test_the_newest_result_alone_waits_for_another() -> None:
    content = fleet_health(made_up(changed={"K": 0.7}, since=7))
    assert content["changes"] == []
    assert [own["parameter"] for own in content["to_confirm"]] == ["K"]
    assert "of another day would tell" in health_text(content)


def test_only_the_last_result_of_a_recording_counts() -> None:
    rows = made_up(changed={"K": 0.5})
    again = made_up()
    assert fleet_health([*rows, *again])["changes"] == []
    assert fleet_health([*rows, *[{**row, "verdict": "rejected"} for row in again]])["changes"] != []


@pytest.mark.parametrize(
    ("changes", "temperature", "cause"),
    [
        ({"K": -0.2}, False, Cause.TRANSMISSION), ({"K": -0.2, "backlash.gap": 1.0}, False, Cause.GEAR_WEAR),
        ({"K": 0.2}, False, Cause.STIFFER), ({"FV": 0.3, "FVm": 0.2}, False, Cause.LUBRICATION),
        ({"FV": 0.3, "FVm": 0.2}, True, Cause.TEMPERATURE), ({"FSm": 0.5}, False, Cause.DRY_FRICTION),
        ({"JL": 0.3, "MX": 0.4}, False, Cause.PAYLOAD), ({"offset": 2.0}, False, Cause.OFFSET),
        ({"K": 0.1, "JL": 0.1, "Jm": 0.1}, False, Cause.EFFORT_SCALE), ({"K": 0.1, "JL": -0.4}, False, Cause.SEVERAL),
    ],
)  # fmt: skip
def test_causes(changes: dict[str, float], temperature: bool, cause: Cause) -> None:
    own = {key: (change, 0.01) for key, change in changes.items()}
    assert probable_cause(own, {"K", "JL", "Jm", *changes}, temperature=temperature) is cause
    assert set(CAUSES) == set(Cause)


@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({"K/JL": -0.05}, Cause.TRANSMISSION), ({"K/JL": -0.05, "K": -0.05}, Cause.TRANSMISSION),
        ({"K/JL": -0.2, "JL/Jm": 0.2}, Cause.PAYLOAD), ({"K/JL": -0.2, "JL": 0.2}, Cause.PAYLOAD),
    ],
)  # fmt: skip
def test_a_ratio_is_put_down_to_the_parameter_that_changes_it(changes: dict[str, float], cause: Cause) -> None:
    own = {key: (change, 0.01) for key, change in changes.items()}
    assert probable_cause(own, {"K", "JL", "Jm", *changes}) is cause


def test_ratios_go_by_the_covariance() -> None:
    known = {"K": (1e4, 100.0, "N m/rad"), "JL": (2.0, 0.02, "kg m^2")}
    matrix = [[1e4, 1.98], [1.98, 4e-4]]  # correlated by 0.99
    found = ratios(known, json.dumps({"keys": ["K", "JL"], "matrix": matrix}))
    assert list(found) == ["K/JL"]
    value, std, unit = found["K/JL"]
    assert (value, unit) == (5000.0, "1/s^2")
    assert std == pytest.approx(5000.0 * 0.01 * np.sqrt(2.0 * (1.0 - 0.99)))
    assert ratios(known, None) == {}


def test_pairs_of_results_are_judged_by_the_fleet_and_wait_for_a_third() -> None:
    content = fleet_health(made_up(40, 2, changed={"K": 0.7}, since=1))
    assert content["changes"] == []
    assert [(own["robot"], own["parameter"]) for own in content["to_confirm"]] == [("arm 0", "K")]
    [joint] = [own for own in content["joints"] if own["state"] == "to_confirm"]
    assert joint["cause"] == Cause.TRANSMISSION
    with pytest.raises(DataError, match="twenty"):
        fleet_health(made_up(10, 2))


@pytest.mark.parametrize("results", [3, 4])
def test_two_results_are_left_behind_the_baseline(results: int) -> None:
    content = fleet_health(made_up(40, results, changed={"K": 0.7}, since=results - 2))
    assert [(own["robot"], own["parameter"]) for own in content["changes"]] == [("arm 0", "K")]


@pytest.mark.campaign
def test_the_smallest_change_that_could_be_shown_is_found_about_as_often_as_is_said() -> None:
    smallest = fleet_health(made_up(60, seed=50))["smallest"]["K"]["median_percent"]
    assert 5.0 < smallest < 15.0
    for share, least, most in ((1.0, 15, 20), (0.4, 0, 8)):
        factor = 1.0 - share * smallest / 100.0
        found = [fleet_health(made_up(60, seed=seed, changed={"K": factor}, since=3))["changes"] for seed in range(20)]
        count = sum(any((own["robot"], own["parameter"]) == ("arm 0", "K") for own in changes) for changes in found)
        assert least <= count <= most, share


def test_what_cannot_be_compared_is_refused() -> None:
    with pytest.raises(DataError, match="nothing can be compared, cannot tell yet: 1 joint, and it has not"):
        fleet_health(made_up(1, 1))
    with pytest.raises(DataError, match="tags: first"):
        fleet_health(made_up(), "last")
    with pytest.raises(UsageError, match="2026-13-45: there is no such day, and no such tag: give YYYY-MM-DD"):
        fleet_health(made_up(), "2026-13-45")


@pytest.mark.slow
def test_command_says_it_in_a_table_or_in_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pyarrow", reason="needs pyarrow", exc_type=ImportError)
    from flex_ident.fleet.archive import Archive

    for name, rows in (("same", made_up()), ("worn", made_up(changed={"K": 0.8}))):
        archive = Archive(tmp_path / name).opened()
        archive.write(archive.file_of("1", {}), rows)
    assert main(["health", str(tmp_path / "same")]) == 0
    assert "6 unchanged" in capsys.readouterr().out
    assert main(["health", str(tmp_path / "worn"), "--json"]) == 4
    said = json.loads(capsys.readouterr().out)
    assert [own["parameter"] for own in said["changes"]] == ["K"]
    assert ["stiffness fell" in own["cause_text"] for own in said["joints"] if "cause" in own] == [True]
    assert main(["health", str(tmp_path / "worn")]) == 4
    assert "arm 0" in capsys.readouterr().out
    assert main(["health", str(tmp_path / "worn"), "--out", str(tmp_path / "page")]) == 4
    page = (tmp_path / "page" / "report.html").read_text()
    assert page.count("data:image/png") == 6
    assert "smallest change" in page
    assert json.loads((tmp_path / "page" / "health.json").read_text())["smallest"]["K"]["series"] == 6
    assert main(["health", str(tmp_path / "none")]) == 3
    assert "no archive" in capsys.readouterr().err


def in_sessions(
    seed: int, *, robots: int, joints: int, sessions: int, day: float = 0.02, shared: str = "joint", **given: Any
) -> list[Row]:
    """Three recordings a session that share the session's deviations: a joint's own, a robot's, or the fleet's."""
    rng = np.random.default_rng(seed)
    drawn: dict[tuple[int, ...], Any] = {}
    rows = made_up(robots, 3 * sessions, joints=joints, seed=seed, **given)
    for n, (robot, joint, i) in enumerate(np.ndindex(robots, joints, 3 * sessions)):
        group = {"joint": (robot, joint), "robot": (robot,), "fleet": ()}[shared]
        deviations = drawn.setdefault(group, rng.normal(1.0, day, (sessions, len(TRUTH))))
        parameters = {
            key: {"value": truth * deviations[i // 3][c] * rng.normal(1.0, 0.005), "std": 0.005 * truth, "unit": "SI",
                  "identifiable": True}
            for c, (key, truth) in enumerate(TRUTH.items())
        }  # fmt: skip
        at = datetime.fromtimestamp(START + 30 * DAY * (i // 3) + 1800 * (i % 3), UTC)
        rows[n] = {**rows[n], "parameters": json.dumps(parameters), "recorded_at": at}
    return rows


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robots", "joints", "sessions", "shared"),
    [(1, 6, 4, "joint"), (6, 6, 4, "joint"), (6, 6, 4, "robot"), (6, 6, 3, "fleet"), (2, 6, 6, "fleet")],
)
def test_what_a_day_does_is_no_change(robots: int, joints: int, sessions: int, shared: str) -> None:
    alarmed = 0
    for seed in range(12):
        rows = in_sessions(seed, robots=robots, joints=joints, sessions=sessions, shared=shared)
        with suppress(DataError):  # of three days of one hall
            alarmed += bool(fleet_health(rows)["changes"])
    assert alarmed <= 1  # 0.12 on average at 1 %; every one of them where recordings count instead of days


def test_too_few_sessions_are_said_instead_of_an_alarm() -> None:
    with pytest.raises(DataError, match=r"cannot tell yet: 6 joints, .* \(2 sessions at most; .* Record on four days"):
        fleet_health(in_sessions(1, robots=1, joints=6, sessions=2, day=0.1))
    one_more = [{**row, "robot": "new"} for row in in_sessions(2, robots=1, joints=1, sessions=1)]
    content = fleet_health([*in_sessions(1, robots=6, joints=1, sessions=5), *one_more])
    [new] = [own for own in content["joints"] if own["robot"] == "new"]
    assert (new["state"], new["sessions"], new["results"]) == ("not_judged", 1, 3)
    assert "1 cannot tell yet: 1 session; record on four days or more" in health_text(content)


@pytest.mark.slow
def test_three_sessions_tell_no_less_than_two() -> None:
    def found(seed: int, sessions: int) -> bool:
        content = fleet_health(made_up(40, sessions, changed={"K": 0.8}, since=1, seed=seed))
        said = [*content["changes"], *content["to_confirm"]]
        return ("arm 0", "K") in {(own["robot"], own["parameter"]) for own in said}

    two, three = (sum(found(seed, sessions) for seed in range(8)) for sessions in (2, 3))
    assert three >= two >= 6


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("settings", {"effort_scale": 1.2}, "effort_scale 1.2"), ("settings", {"rigid": True}, "rigid True"),
        ("method", "paper", "paper"), ("sensors", "motor", "flexible, motor,"),
    ],
)  # fmt: skip
def test_another_method_or_setting_is_no_change_of_the_joint(column: str, value: object, said: str) -> None:
    rows = made_up(results=10, changed={"K": 0.8}, since=5)
    late = [row for n, row in enumerate(rows) if n % 10 >= 5]
    for row in late:
        row[column] = json.dumps(value) if isinstance(value, dict) else value
    content = fleet_health(rows)
    assert content["changes"] == []
    assert len(content["mixed"]) == 6
    assert len(content["joints"]) == 12
    text = health_text(content)
    assert said in text
    assert "not compared with each other" in text
    assert "1 more joints" in text
    for row in late:  # what settings leave out, and which joint was asked for, is no difference
        row |= {
            "settings": json.dumps({"joint": "all", "effort_scale": 1.0}),
            "method": "auto",
            "sensors": "motor+link",
        }
    content = fleet_health(rows)
    assert [own["parameter"] for own in content["changes"]] == ["K"]
    assert content["mixed"] == []


def test_results_by_another_setting_do_not_take_the_place_of_those_there_are() -> None:
    """Three days identified once more with `--effort-kind current` hid what had changed on them."""
    rows = made_up(results=10, changed={"K": 0.8}, since=5)
    again = [{**row, "settings": json.dumps({"effort_kind": "current"})} for n, row in enumerate(rows) if n % 10 >= 7]
    content = fleet_health([*rows, *again])
    assert [own["parameter"] for own in content["changes"]] == ["K"]
    assert content["mixed"]


def test_a_change_with_the_version_is_put_down_to_it() -> None:
    rows = made_up(results=10, changed={"K": 0.8}, since=5)
    for n, row in enumerate(rows):
        row["flex_ident_version"] = "0.1" if n % 10 < 5 else "0.2"
    content = fleet_health(rows)
    assert {own.get("cause") for own in content["joints"]} == {None, Cause.VERSION}
    assert "other versions of flex_ident" in health_text(content)


def test_a_bag_that_was_replaced_under_its_name_counts_once() -> None:
    rows = made_up(results=8)
    broken = {**rows[7], "sha256": "old", "finished_at": rows[7]["finished_at"] - timedelta(days=1)}
    broken["parameters"] = json.dumps({
        key: {**own, "value": 2.0 * own["value"]} for key, own in json.loads(rows[7]["parameters"]).items()
    })  # fmt: skip
    content = fleet_health([*rows, broken])
    assert content["replaced"] == [{"bag": "0.0.7", "robot": "arm 0", "recordings": 1}]
    assert content["changes"] == content["to_confirm"] == []
    assert content["joints"][0]["results"] == 8
    assert "1 bag was replaced by another of the same name and day (0.0.7)" in health_text(content)


def test_a_name_that_is_written_again_on_other_days_is_of_other_recordings() -> None:
    content = fleet_health([{**row, "bag": f"{row['robot']}/latest"} for row in made_up()])
    assert content["replaced"] == []
    assert {own["results"] for own in content["joints"]} == {8}
