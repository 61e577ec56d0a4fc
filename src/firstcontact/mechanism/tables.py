"""Joint values from files: tables (CSV), arrays (NPZ), and ROS `JointTrajectory` as JSON."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from flint import fmpq

from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import rational

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from firstcontact.exact.numbers import Given

TIMES = "time", "t", "time_from_start"
"""Names of the column of times."""


class Columns(NamedTuple):
    """Times, values of joints by their names, and their velocities where these are known."""

    times: Sequence[Given]
    values: dict[str, list[Given]]
    velocities: dict[str, list[Given]] | None = None


def read(path: str | Path) -> Columns:
    """The columns of a file, by its suffix."""
    path = Path(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path}: suffix {path.suffix!r} is unknown; give one of {', '.join(READERS)}")
    try:
        return reader(path)
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}; give a table of joint values") from error


def _csv(path: Path) -> Columns:
    """A row of names, then rows of numbers, which are exact as they are written."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = [(number, row) for number, row in enumerate(csv.reader(file), 1) if any(x.strip() for x in row)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: no table of text ({error}); give one with a row of names first") from error
    if len(rows) < 3:
        raise InputError(f"{path}: {max(len(rows) - 1, 0)} rows of values; give a row of names and at least two rows")
    names = [x.strip() for x in rows[0][1]]
    for number, row in rows[1:]:
        if len(row) != len(names):
            raise InputError(f"{path}: line {number} has {len(row)} values, but there are {len(names)} names")
        for name, text in zip(names, row, strict=True):
            _check_number(path, f"line {number}", name, text.strip())
    if len(set(names)) != len(names):
        raise InputError(f"{path}: two columns have one name; give each its own")
    return _split({name: [row[k].strip() for _, row in rows[1:]] for k, name in enumerate(names)})


def _check_number(path: Path, place: str, name: str, given: Given) -> None:
    try:
        rational(given, name)
    except InputError as error:
        raise InputError(f"{path}: {place}: {error}") from error


def _split(columns: dict[str, list[Given]]) -> Columns:
    """Times apart; rows are a unit apart where there are none."""
    key = next((name for name in TIMES if name in columns), None)
    times = list(range(max(map(len, columns.values()), default=0))) if key is None else columns.pop(key)
    return Columns(times, columns)


def _npz(path: Path) -> Columns:
    """One array for each joint, or `positions` (n, joints) with `joint_names`; `time` beside them."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except (ValueError, EOFError, BadZipFile) as error:
        raise InputError(f"{path}: no archive of plain arrays; write them by numpy.savez") from error
    if "positions" not in arrays:
        return _split({name: array.tolist() for name, array in arrays.items()})
    names = [str(name) for name in arrays.get("joint_names", ())]
    columns = {key: _by_name(path, key, names, arrays[key]) for key in ("positions", "velocities") if key in arrays}
    times = next((arrays[key].tolist() for key in TIMES if key in arrays), list(range(len(arrays["positions"]))))
    return Columns(times, columns["positions"], columns.get("velocities"))


def _by_name(path: Path, key: str, names: list[str], rows: ArrayLike) -> dict[str, list[Given]]:
    array = np.asarray(rows, float)
    if array.ndim != 2 or array.shape[1] != len(names):
        raise InputError(f"{path}: {key} of the shape {array.shape} for {len(names)} joint_names; give each a column")
    return {name: array[:, k].tolist() for k, name in enumerate(names)}


def _json(path: Path) -> Columns:
    """A `JointTrajectory` of ROS, or a message that holds one."""
    try:
        message = json.loads(path.read_text(encoding="utf-8-sig"))
    except ValueError as error:
        raise InputError(f"{path}: no JSON ({error}); give a JointTrajectory") from error
    for key in ("joint_trajectory", "trajectory"):
        message = message.get(key, message) if isinstance(message, dict) else message
    names, points = (message.get(key) if isinstance(message, dict) else None for key in ("joint_names", "points"))
    if not isinstance(names, list) or not isinstance(points, list):
        raise InputError(f"{path}: no JointTrajectory; give an object with joint_names and points, which are lists")
    if len(points) < 2:
        raise InputError(f"{path}: {len(points)} points; give at least two")
    names = [str(x) for x in names]
    times = [_time(f"{path}: points[{k}]", point) for k, point in enumerate(points)]
    every = all(point.get("velocities") for point in points)
    positions, velocities = (_in_columns(path, key, names, points) for key in ("positions", "velocities"))
    return Columns(times, positions, velocities if every else None)


def _in_columns(path: Path, key: str, names: list[str], points: list[Any]) -> dict[str, list[Given]]:
    """One number for each joint in each point that has any."""
    for k, point in enumerate(points):
        given = point.get(key)
        if key == "velocities" and not given:
            continue
        if not isinstance(given, list) or len(given) != len(names):
            raise InputError(f"{path}: points[{k}]: {key} are {shown(given)}; give {len(names)} numbers")
        for name, value in zip(names, given, strict=True):
            _check_number(path, f"points[{k}]", f"{key} of {name}", value)
    return {name: [point[key][j] for point in points if point.get(key)] for j, name in enumerate(names)}


def _time(who: str, point: object) -> fmpq:
    """Seconds, exactly: a number, or whole seconds and nanoseconds."""
    if not isinstance(point, dict) or "time_from_start" not in point:
        raise InputError(f"{who} is {shown(point)}; give an object with positions and time_from_start")
    value = point["time_from_start"]
    if not isinstance(value, dict):
        return rational(value, f"{who}: time_from_start")
    seconds, rest = value.get("sec", value.get("secs", 0)), value.get("nanosec", value.get("nsecs", 0))
    return rational(seconds, f"{who}: sec") + rational(rest, f"{who}: nanosec") / fmpq(10) ** 9


READERS: dict[str, Callable[[Path], Columns]] = {".csv": _csv, ".npz": _npz, ".json": _json}
