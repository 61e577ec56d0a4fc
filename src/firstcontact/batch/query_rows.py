"""What a table of queries asks: its columns as bodies, motions and spans.

    a, b                          keys of the bodies
    vector, or vx, vy, vz         body a moves by this translation
    axis, or ax, ay, az           it turns about this axis, through `point` (or px, py, pz; without it the origin),
    degrees, radians or turns     by this angle
    pose0, pose1                  it goes from one pose to another; 16 numbers each, row by row
    span, or t0, t1               from a time to another one

A row has one motion or none; what it has not is null.  All other columns are carried along.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.batch import arrow
from firstcontact.batch.arrow import pyarrow
from firstcontact.batch.query_files import QueryFile, first_wrong
from firstcontact.batch.questions import Questions, columns
from firstcontact.errors import InputError, shown
from firstcontact.motion.arrays import Motions, Poses, Rotations, Translations
from firstcontact.motion.moving import Moving

if TYPE_CHECKING:
    from types import ModuleType

    from pyarrow import Array, DataType, Table

    from firstcontact.body.kinds import Body

KEYS = "a", "b"
LISTS = {"vector": 3, "axis": 3, "point": 3, "pose0": 16, "pose1": 16, "span": 2}
"""Columns of lists, and how many numbers each holds."""
APART = {"vector": ("vx", "vy", "vz"), "axis": ("ax", "ay", "az"), "point": ("px", "py", "pz"), "span": ("t0", "t1")}
"""The same in a column for each number."""
UNITS = "degrees", "radians", "turns"
KNOWN = {*KEYS, *LISTS, *UNITS, *(name for names in APART.values() for name in names)}
NEEDS = {"axis": UNITS, "point": ("axis",), "pose0": ("pose1",), "pose1": ("pose0",), **dict.fromkeys(UNITS, ("axis",))}
"""What a column is nothing without: one of these."""


def carried(names: Sequence[str]) -> list[str]:
    """The columns that are carried along, a and b among them."""
    return [name for name in names if name in KEYS or name not in KNOWN]


def check_columns(file: QueryFile, names: Sequence[str]) -> None:
    """InputError names a column that is missing, or one too many."""
    given = {name for name, parts in APART.items() if set(parts) & set(names)} | set(names)
    for key in KEYS:
        if key not in names:
            raise InputError(f"{file.path}: column {key} is missing; it names a body of the scene")
    for name, parts in APART.items():
        there = [part for part in parts if part in names]
        missing = [part for part in parts if part not in names]
        if there and name in names:
            raise InputError(f"{file.path}: columns {name} and {there[0]} say the same; give one of them")
        if there and missing:
            raise InputError(f"{file.path}: column {missing[0]} is missing beside {there[0]}")
    for name, needs in NEEDS.items():
        if name in given and not given & set(needs):
            raise InputError(f"{file.path}: column {name} needs {' or '.join(needs)} beside it")
    for name in names:
        if name not in KNOWN and name in arrow.answer_columns():
            raise InputError(f"{file.path}: column {name} is to be carried along, but answers have one; rename it")


class Bodies:
    """Bodies by their keys."""

    def __init__(self, bodies: Mapping[str, Body]) -> None:
        self.keys, self.all = list(bodies), list(bodies.values())
        self.moving = np.array([isinstance(body, Moving) for body in self.all], bool)
        self.shapes = columns(self.all, np.empty((0, 2), int)).bodies


class QueryRows:
    """A table of queries that begins with row `begin` of a file."""

    def __init__(self, file: QueryFile, begin: int, table: Table, bodies: Bodies) -> None:
        self.file, self.begin, self.table, self.bodies = file, begin, table, bodies

    def questions(self) -> list[tuple[np.ndarray, Questions]]:
        """(rows of the table, questions about them), those with motions of one kind and with spans together."""
        a, b = self._bodies("a"), self._bodies("b")
        spans, timed = self._list("span", finite=False)
        asked = []
        for alike, motions in self._motions(a):
            for with_span in (False, True):
                chosen = np.flatnonzero(timed[alike] == with_span)
                if not len(chosen):
                    continue
                rows = alike[chosen]
                pairs = np.stack([a[rows], b[rows]], axis=1)
                questions = columns(self.bodies.all, pairs, None if motions is None else motions[chosen])
                if with_span:
                    questions = replace(questions, spans=list(map(tuple, spans[rows].tolist())))
                asked.append((rows, questions))
        return asked

    def _bodies(self, name: str) -> np.ndarray:
        pa, pc = pyarrow(), pyarrow("compute")
        keys = self.table[name].cast(pa.string())
        found = pc.fill_null(pc.index_in(keys, pa.array(self.bodies.keys, pa.string())), -1).to_numpy()
        if (found < 0).any():
            row = int(np.argmax(found < 0))
            known = ", ".join(self.bodies.keys)
            raise self._fault(row, name, f"no body {shown(keys[row].as_py())}; the bodies are {known}")
        return np.asarray(found, np.int32)

    def _motions(self, a: np.ndarray) -> list[tuple[np.ndarray, Motions | None]]:
        """Rows that move alike, and how."""
        vectors, shifted = self._list("vector")
        axes, turned = self._list("axis")
        points, _ = self._list("point")
        (from_, posed), (to, _) = self._list("pose0", same="pose1"), self._list("pose1", same="pose0")
        angles = {unit: self._numbers(unit) for unit in UNITS}
        by = {unit: turned & given for unit, (_, given) in angles.items()}
        self._check_turns(axes, turned, angles)
        kinds = {"vector": shifted, "axis": turned, "pose0": posed}
        many = np.sum(list(kinds.values()), axis=0)
        self._refuse(many > 1, "axis", "a second motion of one query; leave all but one null")
        self._refuse((many > 0) & self.bodies.moving[a], "a", "this body moves in the scene already")
        found: list[tuple[np.ndarray, Motions | None]] = []
        for unit, given in by.items():
            if len(rows := np.flatnonzero(given)):
                turn: dict[str, Any] = {unit: angles[unit][0][rows]}
                found.append((rows, Rotations(axes[rows], np.nan_to_num(points[rows]), **turn)))
        if len(rows := np.flatnonzero(shifted)):
            found.append((rows, Translations(vectors[rows])))
        if len(rows := np.flatnonzero(posed)):
            found.append((rows, Poses(np.stack([from_[rows], to[rows]], axis=1).reshape(-1, 2, 4, 4))))
        if len(rows := np.flatnonzero(many == 0)):
            found.append((rows, None))
        return found

    def _check_turns(
        self, axes: np.ndarray, turned: np.ndarray, angles: dict[str, tuple[np.ndarray, np.ndarray]]
    ) -> None:
        units = np.sum([given for _, given in angles.values()], axis=0)
        self._refuse(turned & (units != 1), "axis", "give one of degrees, radians, turns with it")
        for unit, (_, given) in angles.items():
            self._refuse(given & ~turned, unit, "an angle without an axis")
        self._refuse(turned & ~axes.any(axis=1), "axis", "zero; give a direction such as 0, 0, 1")

    def _refuse(self, wrong: np.ndarray, column: str, text: str) -> None:
        if wrong.any():
            shown_column = column if column in self.table.column_names else APART.get(column, (column,))[0]
            raise self._fault(int(np.argmax(wrong)), shown_column, text)

    def _list(self, name: str, same: str = "", finite: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """(n, width) numbers, nan where there are none, and for which rows there are some.

        same: another column that has lists for the same rows.  finite: whether infinities are refused.
        """
        width = LISTS[name]
        if name in self.table.column_names:
            values, given = self._of_lists(name, width, finite)
        elif set(parts := APART.get(name, ())) & set(self.table.column_names):
            split = [self._numbers(part, finite) for part in parts]
            values, given = np.stack([x for x, _ in split], axis=1), split[0][1]
            for part, (_, there) in zip(parts, split, strict=True):
                self._refuse(given != there, part, f"null beside {parts[0]}, or the other way round")
        else:
            return np.full((len(self.table), width), np.nan), np.zeros(len(self.table), bool)
        if same and same in self.table.column_names:
            self._refuse(given & ~self._given(same), same, f"null beside {name}")
        return values, given

    def _of_lists(self, name: str, width: int, finite: bool) -> tuple[np.ndarray, np.ndarray]:
        pa, pc = pyarrow(), pyarrow("compute")
        column, given = self._one(name), self._given(name)
        if not given.any():
            return np.full((len(self.table), width), np.nan), given
        if _is_text(pa, column.type):
            column = self._written(name, column)
        if not _is_list(pa, column.type):
            row = int(np.argmax(given))
            raise self._fault(row, name, f"{shown(column[row].as_py())} is no list of {width} numbers")
        full = column.filter(pa.array(given))
        rows = np.flatnonzero(given)
        lengths = pc.list_value_length(full).to_numpy(zero_copy_only=False)
        flat = pc.list_flatten(full)
        if width == 16 and _is_list(pa, flat.type):  # four rows of four
            inner = pc.fill_null(pc.list_value_length(flat), -1).to_numpy(zero_copy_only=False)
            lengths = np.where(lengths == 4, width, -1) if (inner == 4).all() else np.zeros(len(lengths))
            flat = pc.list_flatten(flat)
        if (lengths != width).any():
            row = int(rows[np.argmax(lengths != width)])
            raise self._fault(row, name, f"{shown(column[row].as_py())} is no list of {width} numbers")
        numbers = self._doubles(name, flat, np.repeat(rows, width), finite, nulls=False)
        values = np.full((len(self.table), width), np.nan)
        values[rows] = numbers.reshape(-1, width)
        return values, given

    def _written(self, name: str, column: Array) -> Array:
        """Lists that are written as texts, as CSV needs them."""
        lists: list[list[float] | None] = []
        for row, text in enumerate(column.to_pylist()):
            try:
                lists.append(None if text is None else [float(x) for x in np.ravel(json.loads(text))])
            except (ValueError, TypeError, RecursionError):
                raise self._fault(row, name, f'{shown(text)} is no list of numbers; write "[1, 0, 0.5]"') from None
        return pyarrow().array(lists, pyarrow().list_(pyarrow().float64()))

    def _numbers(self, name: str, finite: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """(n,) numbers, nan where there are none, and for which rows there are some."""
        if name not in self.table.column_names:
            return np.full(len(self.table), np.nan), np.zeros(len(self.table), bool)
        return self._doubles(name, self._one(name), np.arange(len(self.table)), finite), self._given(name)

    def _doubles(self, name: str, values: Array, rows: np.ndarray, finite: bool, nulls: bool = True) -> np.ndarray:
        """The values, of these rows, as doubles; nan where they are null, if they may be."""
        pa, pc = pyarrow(), pyarrow("compute")
        there = pc.is_valid(values).to_numpy(zero_copy_only=False)
        doubles = _cast(pa, pc, values)
        if doubles is None:
            place = first_wrong(len(values), lambda n: _cast(pa, pc, values.slice(0, n)) is not None)
            raise self._fault(int(rows[place]), name, f"{shown(values[place].as_py())} is no double")
        wrong = there & (~np.isfinite(doubles) if finite else np.isnan(doubles))
        if not nulls:
            wrong |= ~there
        if wrong.any():
            place = int(np.argmax(wrong))
            raise self._fault(int(rows[place]), name, f"{shown(values[place].as_py())} is no finite number")
        return np.asarray(doubles, float)

    def _one(self, name: str) -> Array:
        """A column in one piece."""
        pa = pyarrow()
        column = self.table[name].combine_chunks()
        if isinstance(column, pa.ChunkedArray):
            column = pa.concat_arrays(column.chunks) if column.num_chunks else pa.array([], column.type)
        return column.dictionary_decode() if pa.types.is_dictionary(column.type) else column

    def _given(self, name: str) -> np.ndarray:
        given: np.ndarray = pyarrow("compute").is_valid(self.table[name]).to_numpy()
        return given

    def _fault(self, row: int, column: str, text: str) -> InputError:
        return self.file.fault(self.begin + row, column, text)


def _is_list(pa: ModuleType, kind: DataType) -> bool:
    return bool(pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind))


def _is_text(pa: ModuleType, kind: DataType) -> bool:
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def _cast(pa: ModuleType, pc: ModuleType, values: Array) -> np.ndarray | None:
    """The values as doubles; None where one is none."""
    if pa.types.is_boolean(values.type):
        return None if len(values) else np.empty(0)
    plain = pc.utf8_trim_whitespace(values) if _is_text(pa, values.type) else values
    try:
        doubles: np.ndarray = plain.cast(pa.float64()).to_numpy(zero_copy_only=False)
    except pa.ArrowException:
        return None
    return doubles
