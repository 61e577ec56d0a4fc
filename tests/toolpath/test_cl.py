"""APT / CL data, beside lists of ways written by hand."""

import pytest

import firstcontact as fc
from firstcontact.exact.numbers import to_double
from firstcontact.toolpath.moves import StraightMove, Swing


def blocks_of(tmp_path, text, **given):
    file = tmp_path / "job.apt"
    file.write_text(text, encoding="utf-8")
    return list(fc.ToolPath(file, **given))


def test_words_are_those_written_by_hand(tmp_path):
    text = (
        "PARTNO A PART OF 5$\nREMARK/ $$ a comment\nUNITS/MM\nFROM/0,0,50\nLOADTL/7,LENGTH,100\nRAPID\nGOTO/1,2,50\n"
        "goto / 1 , 2 , $\n  -3.5\nGODLTA/0,0,1E1\nRAPID\nGOTO/1,2,60\n"
        "MULTAX/ON\nGOTO/1,2,60,0,0.6,0.8\nGOTO/5,2,60,0,0.6,0.8\nFEDRAT/100,MMPM\nFINI\n"
    )
    blocks = blocks_of(tmp_path, text)
    assert [x.line for x in blocks] == [7, 8, 10, 12, 14, 15] and {x.tool for x in blocks} == {7}
    ends = [tuple(map(to_double, x.stretches[0].end)) for x in blocks]
    assert ends == [(1, 2, 50), (1, 2, -3.5), (1, 2, 6.5), (1, 2, 60), (1, 2, 60), (5, 2, 60)]
    assert [x.stretches[0].kind for x in blocks] == ["rapid", "feed", "feed", "back", "feed", "feed"]
    assert [type(x.stretches[0]) for x in blocks] == [StraightMove] * 4 + [Swing] * 2


def test_a_text_does_not_go_on_in_the_next_line(tmp_path):
    assert [x.line for x in blocks_of(tmp_path, "FROM/0,0,0\nREMARK ALL FOR 5$\nGOTO/1,2,3\n")] == [3]


FAULTS = {
    "GOTO/1,2": "line 1: GOTO: 2 numbers",
    "GOTO/1,2,x": "line 1: GOTO: 'X' is no number",
    "GOTO/1,2,1E46": "line 1: GOTO: 1E46: give a number below 2^150",
    "FROM/0,0,0\nGOTO/1,2,3,0,1,0": "line 2: GOTO: a tool axis that is not +z without MULTAX",
    "MULTAX\nFROM/0,0,0\nGOTO/1,2,3,0,0,0": "line 3: GOTO: the tool axis is zero",
    "MULTAX\nFROM/0,0,0,0,1,1\nGOTO/1,2,3,0,-1,-1": "line 3: GOTO: the tool axis turns by half a turn",
    "CIRCLE/0,0,0,0,0,1,5": "line 1: CIRCLE: not read",
    "FINI\nPPRINT/next\nGODLTA/1,2,3": "line 3: GODLTA: after FINI, where the program ends",
    "UNITS/FEET": "line 1: UNITS/FEET: not read",
    "CYCLE/DRILL,5": "line 1: CYCLE: not read",
}


@pytest.mark.parametrize("text", FAULTS, ids=FAULTS)
def test_what_is_not_read_stops_with_line_and_word(tmp_path, text):
    with pytest.raises(fc.InputError, match="job.apt: ") as error:
        blocks_of(tmp_path, text)
    assert FAULTS[text] in str(error.value)


def test_inches_and_unknown_places(tmp_path):
    blocks = blocks_of(tmp_path, "UNITS/INCH\nGOTO/1,0,0\nGOTO/2,0,0")
    assert blocks[0].unknown and blocks[1].stretches[0].length == 25.4
