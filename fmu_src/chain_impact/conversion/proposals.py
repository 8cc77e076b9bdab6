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
    check: Callable[[ConversionResult], object] = lambda done: done,
) -> ConversionResult:
    """Return the scene of a robot; if the robot is not a planar chain, the error proposes joints to move.

    ``source`` is the file's name for messages. ``check`` is called with the conversion, and may raise a
    SceneError; joints for whose conversion ``check`` raises an error are not proposed.

    Raises:
        NoChainError: when the robot is not a planar chain; if some joints that form one are found, the
            message and ``joints`` have their names.
        SceneError: when the choices do not fit the robot, or from ``check``.
    """
    try:
        done = planar_chain(robot, choices, source)
    except NoChainError as error:
        names = _propose_joints(robot, choices, source, check)
        if names is None:
            raise
        how = f"--joints {','.join(names)} takes joints that make a chain, and holds the others"
        raise NoChainError(f"{error}; {how}", names) from None
    check(done)
    return done


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
        waiting = [start]
        while waiting and trials < TRIALS and len(waiting[0]) > len(best):
            names, trials = waiting.pop(0), trials + 1
            try:
                check(planar_chain(robot, choices._replace(joints=names), source))
            except NoChainError as error:
                for name in error.joints:
                    fewer = [other for other in names if other != name]
                    if fewer and len(fewer) < len(names) and fewer not in waiting:
                        waiting.append(fewer)
            except SceneError:
                continue
            else:
                best = names
    return best or None


def _candidates(robot: Robot, wanted: Sequence[str]) -> Iterator[list[str]]:
    """Yield lists of the names of joints to try, those with the most hinges first.

    The hinges of a list have parallel axes and follow one another from the base outwards. If slides come
    before the first hinge, a list with these slides is yielded before the list without them. ``wanted`` are
    the names of the joints that may be in a list; without names, all may be.
    """
    pool = [moved for moved in joints_at_start(robot) if not wanted or moved.joint.name in wanted]
    paths: list[list[MovingJoint]] = []
    for group in parallel_groups([moved for moved in pool if moved.joint.kind == "hinge"]):
        paths += _paths(robot, group)
    for path in sorted(paths, key=len, reverse=True):
        before = set(ancestors(robot, path[0].body))
        slides = [moved for moved in pool if moved.joint.kind == "slide" and moved.body in before]
        if slides:
            yield [moved.joint.name for moved in (*slides, *path)]
        yield [hinge.joint.name for hinge in path]


def _paths(robot: Robot, group: Sequence[MovingJoint]) -> Iterator[list[MovingJoint]]:
    """Yield for each outermost joint of a group: the joints of the group from the base up to this joint.

    A joint is outermost if no other joint of the group comes after it. The joints of the group must be in the
    order from the base outwards.
    """
    for last in group:
        before = set(ancestors(robot, last.body))
        if not any(last.body in set(ancestors(robot, moved.body)) - {moved.body} for moved in group):
            yield [moved for moved in group if moved.body in before]
