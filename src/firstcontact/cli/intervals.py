"""`firstcontact intervals`: all times of contact of every pair of a scene."""

from __future__ import annotations

from firstcontact.cli import common


@common.scene_command
def intervals(scene: str, options: common.Options) -> int:
    """List all times of contact of each pair.

    SCENE is a TOML file; without a [[check]] table every pair of its bodies is checked.
    """
    results = common.answer_checks(scene, options, "contact_intervals")
    common.deliver(results, options)
    # An undecided rest of the span does not take back the intervals that are proved.
    return common.exit_code(["CONTACT" if len(result) else result.status.name for result in results])
