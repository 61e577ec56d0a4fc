"""What a row of a batch should hold: the answer of `first_contact` to that question alone."""

import firstcontact as fc


def answer(hit):
    """A result as a row of the answers."""
    row = {"status": hit.status.name, "initial": hit.initial, "reason": hit.reason, "multiplicity": hit.multiplicity}
    row |= dict(zip(("lo", "hi"), hit.time_interval or (None, None), strict=True))
    row |= {"time": hit.time, "free_until": hit.free_until, "work": hit.stats.node_visits + hit.stats.pair_tests}
    for side, element in (("a", hit.element_a), ("b", hit.element_b)):
        row |= {f"kind_{side}": element and element.kind, f"index_{side}": element and element.index}
    for name, vector in (("point", hit.point), ("normal", hit.normal)):
        numbers = (None,) * 3 if vector is None else vector.tolist()
        row |= {f"{name}_{x}": v for x, v in zip("xyz", numbers, strict=True)}
    return row | {"error": None}


def one_by_one(queries, **arguments):
    """The rows of a batch: answers, or the text of the error alone."""
    rows = []
    for a, b, *span in queries:
        try:
            rows.append(answer(fc.first_contact(a, b, *span, **arguments)))
        except fc.FirstContactError as error:
            rows.append(str(error))
    return rows


def rows_of(table):
    """The same of a table."""
    return [row if row["error"] is None else row["error"] for row in table.to_arrow().to_pylist()]
