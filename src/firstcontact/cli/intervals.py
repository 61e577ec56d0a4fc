"""`firstcontact intervals`: all times of contact of every pair of a scene."""

from __future__ import annotations

from firstcontact.cli import common


@common.scene_command
def intervals(files: tuple[str, ...], options: common.Options) -> int:
    """List all times of contact of each pair.

    SCENE is a TOML file; without a [[check]] table every pair of its bodies is checked, but for those at rest with each
    other.  Of two or more mesh or STEP FILEs the first one moves, by --move or --turn, and is checked against the
    others.
    """
    with options.outputs(files) as out:
        results = common.answer_checks(files, options, out, "contact_intervals")
    # An undecided rest of the span does not take back the intervals that are proved.
    return common.exit_code_of(results)
