"""Proposals of joints that form a planar chain, for a robot whose moving joints together form none."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from chain_impact.conversion.joints import (
    MovingJoint,
    NoChainError,
    ancestors,
    joints_at_start,
    parallel_groups,
)
from chain_impact.conversion.planar import ConversionChoices, ConversionResult, planar_chain
from chain_impact.conversion.robot import Robot
from chain_impact.scene.errors import SceneError

TRIALS = 200  # largest number of conversions that are tried to find a proposal; one conversion takes a few ms


def chain_of(
    robot: Robot,
    choices: ConversionChoices,
    source: str,
    check: Callable[[ConversionResult], object] = lambda result: result,
) -> ConversionResult:
    """Return the scene of a robot; if the robot is not a planar chain, the error proposes joints to move.

    ``source`` is the file's name for messages. ``check`` is called with the conversion, and may raise a
    SceneError; joints for whose conversion ``check`` raises an error are not proposed.

    Raises:
        NoChainError: when the robot is not a planar chain; if some joints that form one are found, the
            message and ``proposed`` have their names.
        SceneError: when the choices do not fit the robot, or from ``check``.
    """
    try:
        result = planar_chain(robot, choices, source)
    except NoChainError as error:
        names = _propose_joints(robot, choices, source, check)
        if names is None:
            raise
        proposal_text = f"choose joints {','.join(names)}: these make a chain, and the others are held"
        raise NoChainError(f"{error}; {proposal_text}", proposed=names) from None
    check(result)
    return result


def _propose_joints(
    robot: Robot, choices: ConversionChoices, source: str, check: Callable[[ConversionResult], object]
) -> list[str] | None:
    """Return the names of the largest set of joints that a trial has converted to a scene; None for no set.

    If a trial fails with a NoChainError, the sets without one of the error's ``joints`` are tried, too. There
    are at most TRIALS trials, so a larger set may remain untried.
    """
    best: list[str] = []
    trials = 0
    for start in _candidates(robot, choices.joints):
        waiting_lists = [start]
        while waiting_lists and trials < TRIALS and len(waiting_lists[0]) > len(best):
            names, trials = waiting_lists.pop(0), trials + 1
            try:
                check(planar_chain(robot, choices._replace(joints=names), source))
            except NoChainError as error:
                for name in error.joints:
                    fewer_names = [other_name for other_name in names if other_name != name]
                    if fewer_names and len(fewer_names) < len(names) and fewer_names not in waiting_lists:
                        waiting_lists.append(fewer_names)
            except SceneError:
                continue
            else:
                best = names
    return best or None


def _candidates(robot: Robot, wanted_names: Sequence[str]) -> Iterator[list[str]]:
    """Yield lists of the names of joints to try, those with the most hinges first.

    The hinges of a list have parallel axes and follow one another from the base outwards. If slides come
    before the first hinge, a list with these slides is yielded before the list without them. ``wanted_names``
    are the names of the joints that may be in a list; without names, all may be.
    """
    pool = [
        moving_joint
        for moving_joint in joints_at_start(robot)
        if not wanted_names or moving_joint.joint.name in wanted_names
    ]
    paths: list[list[MovingJoint]] = []
    for group in parallel_groups(
        [moving_joint for moving_joint in pool if moving_joint.joint.kind == "hinge"]
    ):
        paths += _paths(robot, group)
    for path in sorted(paths, key=len, reverse=True):
        bodies_before = set(ancestors(robot, path[0].body))
        sliders = [
            moving_joint
            for moving_joint in pool
            if moving_joint.joint.kind == "slide" and moving_joint.body in bodies_before
        ]
        if sliders:
            yield [moving_joint.joint.name for moving_joint in (*sliders, *path)]
        yield [hinge.joint.name for hinge in path]


def _paths(robot: Robot, group: Sequence[MovingJoint]) -> Iterator[list[MovingJoint]]:
    """Yield for each outermost joint of a group: the joints of the group at its body and at bodies before it.

    A joint is outermost if no joint of the group is at a body after its own. The joints of the group must be
    in the order from the base outwards.
    """
    for last in group:
        bodies_before = set(ancestors(robot, last.body))
        if not any(
            last.body in set(ancestors(robot, moving_joint.body)) - {moving_joint.body}
            for moving_joint in group
        ):
            yield [moving_joint for moving_joint in group if moving_joint.body in bodies_before]
