# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Reports of the benchmarks: exit status, markdown, and the way to JSON and back."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmark import __main__ as runner
from benchmark.report import Measure, Report, Table, finish

TABLE = Table("Times", ("call", "time [ms]"), [["ours", 0.123456], ["theirs", None]], "one thread")


@pytest.mark.parametrize(
    ("value", "at_least", "kept"),
    [(1.0, False, True), (1.1, False, False), (1.1, True, True), (0.9, True, False), (float("nan"), False, False)],
)
def test_a_measure_is_kept_on_its_side_of_the_limit(value: float, at_least: bool, kept: bool) -> None:
    assert Measure("ratio", value, 1.0, at_least).kept is kept


def test_finish_names_missed_measures_and_returns_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert finish(Report("Speed", "one run", [TABLE], [Measure("ratio", 2.0, 1.0)]), None) == 1
    assert "MISSED ratio: 2.000, limit 1.000" in capsys.readouterr().err
    assert finish(Report("Speed", "one run", [TABLE], [Measure("ratio", 0.5, 1.0)]), None) == 0


def test_markdown_has_aligned_columns() -> None:
    text = TABLE.markdown()
    assert "| call   | time [ms] |" in text
    assert "| ours   |    0.1235 |" in text
    assert "| theirs |         - |" in text
    assert text.endswith("one thread\n")


def test_a_report_comes_back_from_json(tmp_path: Path) -> None:
    report = Report("Speed", "one run", [TABLE], [Measure("ratio", 0.5, 1.0, True)])
    report.save(tmp_path / "speed.json")
    loaded = Report.load(tmp_path / "speed.json")
    assert loaded.markdown() == report.markdown()
    assert loaded.missed == report.missed


def test_write_replaces_what_stands_between_the_markers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    start, end = runner.MARKERS
    (tmp_path / "doc").mkdir()
    (tmp_path / "README.md").write_text(f"before\n{start}\nold\n{end}\nafter\n", encoding="utf-8")
    monkeypatch.setattr(runner, "REPOSITORY", tmp_path)
    measures = [Measure("a: RMSE / bound", 1.0, 1.1), Measure("b: RMSE / bound", 1.05, 1.1)]
    monkeypatch.setattr(runner, "HEADLINES", (runner.Headline("speed", "*RMSE / bound", "accuracy"),))
    runner.write({"speed": Report("Speed", "one run", [TABLE], measures)})
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert text.startswith(f"before\n{start}\n| measured")
    assert text.endswith(f"{end}\nafter\n")
    assert [cell.strip() for cell in text.splitlines()[4].split("|")[1:4]] == ["accuracy", "1.050", "<= 1.100"]
    assert "old" not in text
    assert "## Speed" in (tmp_path / "doc/accuracy.md").read_text(encoding="utf-8")


def test_write_keeps_what_other_benchmarks_wrote(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    start, end = runner.MARKERS
    (tmp_path / "doc").mkdir()
    (tmp_path / "README.md").write_text(f"{start}\n{end}\n", encoding="utf-8")
    monkeypatch.setattr(runner, "REPOSITORY", tmp_path)
    lines = (runner.Headline("speed", "fast", "how fast"), runner.Headline("foe", "error", "how exact"))
    monkeypatch.setattr(runner, "HEADLINES", lines)
    first = {
        "speed": Report("Speed", "one run", [TABLE], [Measure("fast", 2.0, 3.0)]),
        "foe": Report("Direction", "one run", [TABLE], [Measure("error", 0.5, 1.0)]),
    }
    runner.write(first)
    whole = (tmp_path / "doc/accuracy.md").read_text(encoding="utf-8"), (tmp_path / "README.md").read_text("utf-8")
    runner.write({"foe": first["foe"]})
    again = (tmp_path / "doc/accuracy.md").read_text(encoding="utf-8"), (tmp_path / "README.md").read_text("utf-8")
    assert again == whole
    runner.write({"foe": Report("Direction", "another run", [], [Measure("error", 0.25, 1.0)])})
    accuracy, readme = (tmp_path / "doc/accuracy.md").read_text("utf-8"), (tmp_path / "README.md").read_text("utf-8")
    assert "## Speed\n\none run" in accuracy
    assert "## Direction\n\nanother run" in accuracy
    assert [line.split("|")[2].strip() for line in readme.splitlines()[3:5]] == ["2.000", "0.2500"]


def test_a_headline_without_its_measure_is_an_error() -> None:
    with pytest.raises(KeyError, match="has no measure 'gone'"):
        runner.Headline("speed", "gone", "accuracy").row(Report("Speed", "one run"))
