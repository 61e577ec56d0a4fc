"""Tables of answers as pyarrow, pandas and Parquet have them."""

import math
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import firstcontact as fc

CUBE = fc.examples.box((1, 1, 1))
WALL = CUBE.translated((3, 0, 0))


@pytest.fixture(scope="module")
def table():
    """CONTACT, FREE, INITIAL_CONTACT, a CONTACT of spheres, and a span that is none."""
    cubes = CUBE.moving(fc.Translation((4, 0, 0)))
    queries = [
        (cubes, WALL), (CUBE.moving(fc.Translation((0, 4, 0))), WALL), (cubes, CUBE),
        (fc.sphere(1).moving(fc.Translation((4, 0, 0))), fc.sphere(1).translated((3, 0, 0))), (cubes, WALL, (1, 0)),
    ]  # fmt: skip
    return fc.first_contacts(queries)


def test_columns_are_those_of_the_table(table):
    arrow = table.to_arrow()
    assert arrow["status"].to_pylist() == ["CONTACT", "FREE", "INITIAL_CONTACT", "CONTACT", None]
    assert arrow["initial"].to_pylist() == [None, None, "overlapping", None, None]
    for name in ("time", "lo", "hi", "free_until"):
        expected = [None if math.isnan(x) else x for x in table.column(name).tolist()]
        assert arrow[name].to_pylist() == expected, name
    for name in ("point", "normal"):
        for k, axis in enumerate("xyz"):
            expected = [None if math.isnan(x) else x for x in table.column(name)[:, k].tolist()]
            assert arrow[f"{name}_{axis}"].to_pylist() == expected
    assert arrow["kind_a"].to_pylist() == [x or None for x in table.kind_a.tolist()]
    assert arrow["index_b"].to_pylist() == [None if x < 0 else x for x in table.index_b.tolist()]
    assert arrow["work"].to_pylist() == table.work.tolist()


def test_words_are_dictionaries_and_errors_texts(table):
    arrow = table.to_arrow()
    for name in ("status", "initial", "reason", "kind_a", "kind_b"):
        assert arrow.schema.field(name).type == pa.dictionary(pa.int8(), pa.string())
    assert arrow["error"].null_count == 4 and "span" in arrow["error"][4].as_py()
    assert arrow.schema.equals(fc.first_contacts([]).to_arrow().schema)


def test_parquet_holds_the_same_table(table, tmp_path):
    table.to_parquet(tmp_path / "table.parquet")
    assert pq.read_table(tmp_path / "table.parquet").equals(table.to_arrow())


def test_intervals_are_a_list_of_each_row(tmp_path):
    queries = [(CUBE.moving(fc.Translation(v)), WALL) for v in ((8, 0, 0), (0, 4, 0), (4, 0, 0))]
    table = fc.many_contact_intervals([*queries, (CUBE, WALL, (1, 0))])
    arrow = table.to_arrow()
    assert arrow["status"].to_pylist() == ["CONTACT", "FREE", "CONTACT", None] and arrow["error"].null_count == 3
    listed = [[(x["start"], x["end"]) for x in row] for row in arrow["intervals"].to_pylist()]
    assert listed == [[(0.25, 0.5)], [], [(0.5, 1.0)], []]
    first = arrow["intervals"][0].as_py()[0]
    assert (first["start_lo"], first["start_hi"]) == table[0][0].start_interval
    table.to_parquet(tmp_path / "table.parquet")
    assert pq.read_table(tmp_path / "table.parquet").equals(arrow)
    assert fc.many_contact_intervals([]).to_arrow().schema.equals(arrow.schema)


def test_pandas_has_whole_numbers_and_categories(table):
    frame = table.to_pandas()
    assert len(frame) == 5 and frame["status"].dtype == "category"
    assert str(frame["index_a"].dtype) == "Int32" and str(frame["work"].dtype) == "Int64"
    assert frame["time"][0] == 0.5 and np.isnan(frame["time"][1])
    assert frame.groupby("status", observed=True).size().to_dict() == {"CONTACT": 2, "FREE": 1, "INITIAL_CONTACT": 1}


@pytest.mark.parametrize("missing, ask", [("pyarrow", "to_arrow"), ("pandas", "to_pandas")])
def test_what_is_missing_is_named(table, monkeypatch, missing, ask):
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(fc.InputError, match=rf"need {missing}: pip install 'firstcontact\[batch\]'"):
        getattr(table, ask)()


def test_elements_of_ruled_surfaces_and_apexes_have_words():
    """They were an error of their rows."""
    strip = fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)").translated((0.8, 0, 3))
    other = fc.RuledSurface("(0, 0, u)", "(1, 1/3, u)")
    tip = fc.cone(1, 1).rotated((1, 0, 0), degrees=180).translated((0.1, 0, 3))
    down = fc.Translation((0, 0, -5))
    table = fc.first_contacts([(strip.moving(down), other), (tip.moving(down), fc.box((1, 1, 1)))])
    assert table.kind_a.tolist() == ["end_ruling", "apex"] and table.kind_b.tolist() == ["end_ruling", "face"]
    assert table.error.tolist() == [None, None]
