# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""Points files of `measure`: what is read, and how wrong rows are named."""

from __future__ import annotations

from pathlib import Path

import pytest

from cv_active_handeye.files import FileFormatError
from cv_active_handeye.measured_points import read_point_rows, write_measured


def read(folder: Path, text: str) -> list[tuple[object, ...]]:
    (folder / "points.csv").write_bytes(text.encode())
    return [tuple(row)[1:] for row in read_point_rows(folder / "points.csv")]


def test_rows_are_read_with_and_without_reference(tmp_path: Path) -> None:
    text = "name,view,u,v,x,y,z\nS1,0,100,200.5,1,2e1,-3\n\nedge of plate,12,1e2,7,,,\n"
    assert read(tmp_path, text) == [
        ("S1", 0, 100.0, 200.5, 0.3, (1.0, 20.0, -3.0)),
        ("edge of plate", 12, 100.0, 7.0, 0.3, None),
    ]
    assert read(tmp_path, "name,view,u,v\nS1,0,1,2\nS1,1,3,4\n")[1] == ("S1", 1, 3.0, 4.0, 0.3, None)
    assert read(tmp_path, "name,view,u,v,sigma\nS1,0,1,2,0.05\nS1,1,3,4,\n") == [
        ("S1", 0, 1.0, 2.0, 0.05, None),
        ("S1", 1, 3.0, 4.0, 0.3, None),
    ]


def test_columns_in_any_order_blanks_and_a_byte_order_mark_are_read(tmp_path: Path) -> None:
    text = '\ufeffv, u ,name,view\r\n 2,1,"S 1, left", 3\r\n'
    assert read(tmp_path, text) == [("S 1, left", 3, 1.0, 2.0, 0.3, None)]


HEAD = "name,view,u,v,x,y,z\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "needs the columns name,view,u,v, where wanted sigma, and, .* missing name,view,u,v, given nothing"),
        ("name,view,u\nS1,0,1\n", "missing v, given name,view,u$"),
        ("name,view,u,v,x,y\nS1,0,1,2,3,4\n", "missing z, given"),
        ("name;view;u;v\n", "column 'name;view;u;v' is unknown"),
        ("name,view,u,v,depth\nS1,0,1,2,3\n", "column 'depth' is unknown"),
        ("name,view,u,v,u\nS1,0,1,2,3\n", "needs every column once, but 'u' appears 2 times"),
        ("name,view,u,v\n", "needs at least one row below the header, has none"),
        ("name,view,u,v\nS1,0,1\n", "line 2: needs 4 columns as in the header, given 3"),
        ("name,view,u,v\nS1,0,1,2\n,0,1,2\n", "line 3: column 'name' needs a name, given ''"),
        ("name,view,u,v\nS1,-1,1,2\n", "line 2: column 'view' needs a whole number from 0 on, given '-1'"),
        ("name,view,u,v\nS1,1.5,1,2\n", "column 'view' needs a whole number from 0 on, given '1.5'"),
        ("name,view,u,v\nS1,0,left,2\n", "line 2: column 'u' needs a finite number, given 'left'"),
        ("name,view,u,v\nS1,0,1,nan\n", "column 'v' needs a finite number, given 'nan'"),
        ("name,view,u,v,sigma\nS1,0,1,2,-1\n", "line 2: column 'sigma' needs 0 or a positive number, given '-1'"),
        (HEAD + "S1,0,1,2,3,inf,5\n", "column 'y' needs a finite number, given 'inf'"),
        (HEAD + "S1,0,1,2,3,,5\n", "line 2: reference values need all of x,y,z or none, given x,z"),
        (HEAD + "S1,0,1,2,,,\nS1,0,3,4,,,\n", "line 3: needs one row for each point and view, .* in .*, line 2 too"),
        (HEAD + "S1,0,1,2,3,4,5\nS1,1,1,2,3,4,6\n", r"line 3: needs the same x,y,z for point S1 as .*, given \(3.0, 4"),
    ],
)
def test_wrong_files_are_refused_with_the_line_and_what_is_needed(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        read(tmp_path, text)


def test_missing_and_unreadable_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"absent.csv: cannot be read as a table of points: No such file"):
        read_point_rows(tmp_path / "absent.csv")
    (tmp_path / "points.csv").write_bytes(b"name,view,u,v\nS\xff,0,1,2\n")
    with pytest.raises(FileFormatError, match="cannot be read as a table of points: 'utf-8' codec"):
        read_point_rows(tmp_path / "points.csv")


def test_written_tables_keep_names_with_commas(tmp_path: Path) -> None:
    write_measured(tmp_path / "measured.csv", ["name", "x"], [["S 1, left", "0.5"]])
    assert (tmp_path / "measured.csv").read_text() == 'name,x\n"S 1, left",0.5\n'
