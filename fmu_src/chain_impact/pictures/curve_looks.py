"""The colours and dashes of curves of outputs: what belongs to one point has one colour in all panels."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from chain_impact.pictures.drawing.colours import PALETTE

DASHES = ("-", "--", ":")
# for curves with peaks as narrow as a line, from which longer dashes would leave pieces
SHORT_DASHES = ("-", (0.0, (1.6, 0.7)), (0.0, (0.8, 0.8)))


def look_indices(names: Sequence[str], body_indices: dict[str, int]) -> list[int]:
    """Return, for each output of a panel, the index from 0 that determines the curve's colour and dashes.

    The colour is that of the index modulo the number of colours, the dashes those of the quotient. The index
    belongs to the ``body_of`` the output: ``body_indices`` has body → index. A body keeps its index from
    earlier panels. If all bodies of a panel are of one kind, such as links, a new body has the index of an
    earlier body with the same number, such as the point at its end. Any other new body gets an index that is
    free in this panel. Several outputs of one owner with a number, such as the components of a joint's force,
    have the colour of this owner and different dashes. Of several owners of one body, such as contacts of a
    point with two walls, each later one has a colour that no body has or, if none is left, other dashes. New
    bodies and these later owners are added to ``body_indices``.

    In three cases the outputs are numbered in their order, from 0, and ``body_indices`` does not change: two
    outputs have the same owner without a number; two outputs would have the same look; or there are too few
    dashes.
    """
    owners = [owner_of(name) for name in names]
    bodies = [body_of(owner) for owner in owners]
    bodies_once = list(dict.fromkeys(bodies))
    # number in brackets → index, for bodies of the only kind in the panel
    indices_by_number: dict[str, int] = {}
    if len({body.partition("[")[0] for body in bodies_once}) == 1:
        indices_by_number = {
            body.partition("[")[2]: index for body, index in body_indices.items() if "[" in body
        }
    present_indices = [
        body_indices.get(body, indices_by_number.get(body.partition("[")[2], -1)) for body in bodies_once
    ]
    earlier = [index for index in present_indices if index >= 0]
    free_indices = (index for index in range(2 * len(names)) if index not in earlier)
    new_indices = {
        body: k if k >= 0 else next(free_indices)
        for body, k in zip(bodies_once, present_indices, strict=True)
    }
    looks, look_counts, owner_looks = [], Counter[str](), dict[str, int]()
    used_colours = {*body_indices.values(), *new_indices.values()}
    free_colours = (number for number in range(len(PALETTE)) if number not in used_colours)
    for body, owner in zip(bodies, owners, strict=True):
        if owner in owner_looks and "[" in owner:
            owner_looks[owner] += len(PALETTE)
            looks.append(owner_looks[owner])
            continue
        look = body_indices.get(owner, new_indices[body] + len(PALETTE) * look_counts[body])
        if look_counts[body] and owner not in body_indices:
            look = new_indices[owner] = next(free_colours, look)
        looks.append(look)
        owner_looks[owner] = look
        look_counts[body] += 1
    unnumbered_owners = [owner for owner in owners if "[" not in owner]
    is_unclear = len({*looks}) < len(looks) or len({*unnumbered_owners}) < len(unnumbered_owners)
    if is_unclear or max(looks) >= len(PALETTE) * len(DASHES):
        return list(range(len(names)))
    body_indices |= new_indices
    return looks


def owner_of(name: str) -> str:
    """Return the owner of an output, its name without the quantity: point[2] of point[2].x."""
    return name.removesuffix(f".{shared_part([name])}")


def body_of(owner: str) -> str:
    """Return the point that touches if the owner of an output is a contact, else the owner."""
    return re.sub(r"^contact(\[\d+\])\..*", r"point\1", owner)


def shared_part(names: Sequence[str]) -> str:
    """Return the part behind the last dot of some names if all names share this part; "" otherwise.

    For a component of a vector, the last part includes the name of the vector: "force.x".
    """
    last = {re.sub(r".*?((?:\w+\.)?[xy]|\w+)$", r"\1", name) for name in names}
    return last.pop() if len(last) == 1 else ""
