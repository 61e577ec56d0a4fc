"""What searches for curves tell is what a curve is made of."""

from dataclasses import fields

from firstcontact.curves.fields import CurveFields
from firstcontact.result_curve import IntersectionCurve


def test_fields_of_searches_are_those_of_the_result():
    told = {name: x.__forward_arg__ for name, x in CurveFields.__annotations__.items()}
    own = {x.name: x.type for x in fields(IntersectionCurve) if x.name not in ("a", "b", "keeps_bodies")}
    assert told == own
