"""The structure of a scene, and the tables of conditions, counts and owners, which pages evaluate as well."""

# Tests: variables/owners.py

from dataclasses import fields

import pytest

from chain_impact import load_scene, model_names
from chain_impact.kernel.record.counts import COUNTS
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.facts import FACTS, LISTS
from chain_impact.scene.keys.chain_tables import Link
from chain_impact.scene.keys.tables import Inputs, Material, Outputs
from chain_impact.scene.rules.rule_language import names_in, tree
from chain_impact.scene.scene import scene_keys
from chain_impact.scene.texts.input_table import INPUT_KEYS
from chain_impact.variables.outputs import INPUTS, OUTPUTS
from chain_impact.variables.owners import COUNT_RULES, OWN_CONDITIONS, OWNER_KINDS, RECORD_NUMBERS
from chain_impact.variables.parameters import PARAMETERS
from chain_impact.variables.structure import structure_of
from tests.helpers.campaigns import random_scenes
from tests.variables.everything import CART, EVERYTHING

FILE_KEYS = {key for key, _ in scene_keys() if "." in key}
FILE_KEYS |= {entry.name for table in (Link, Material) for entry in fields(table)}
KEYS = {f"{table.__name__.lower()}.{entry.name}" for table in (Inputs, Outputs) for entry in fields(table)}


def names_of(*rules):
    return {name for rule in rules for name in names_in(tree(rule))}


def members_of(name):
    """Return the names of all values of a list's members, in the scenes EVERYTHING and CART."""
    lists = [structure_of(scene).lists.get(name) for scene in (EVERYTHING, CART)]
    return {value for members in lists for member in members or () for value in member}


def are_known(known_names, *rules):
    """Return whether each name in rules is in known_names, or a value of members of a list that they name."""
    names = names_of(*rules)
    return names - known_names - {"order"} <= {
        name for list_name in names & LISTS.keys() for name in members_of(list_name)
    }


@pytest.mark.parametrize("scene", [EVERYTHING, CART], ids=["everything", "cart"])
def test_each_fact_and_each_list_is_explained(scene):
    structure = structure_of(scene)
    assert {*structure.numbers} == FACTS.keys() | KEYS | LISTS.keys() | {*COUNTS}
    assert structure.lists.keys() == LISTS.keys()
    assert all(name in LISTS[list_name].meaning for list_name in LISTS for name in members_of(list_name))


def test_names_in_the_tables_are_known():
    known_names = LISTS.keys() | FILE_KEYS
    for list_name, row in LISTS.items():
        rules = [row.source_list, row.condition, *row.values.values()] if row.source_list else []
        assert are_known(known_names | row.values.keys(), *rules), list_name
    for name, (rule, meaning) in FACTS.items():
        assert are_known(known_names, rule), name
        assert meaning
        known_names |= {name}
    assert COUNT_RULES.keys() == {*COUNTS}
    assert are_known(known_names, *COUNT_RULES.values())
    known_names |= {*COUNTS}
    for kind, row in OWNER_KINDS.items():
        rules = [row.condition, row.source_list, *row.numbers.values(), *row.conditions.values()]
        assert are_known(known_names | row.conditions.keys(), *rules), kind
        assert row.conditions.keys() <= OWN_CONDITIONS.keys(), kind
    for name, row in RECORD_NUMBERS.items():
        assert are_known(known_names, row.number, row.source_list, row.at), name


def test_the_conditions_of_variables_are_known():
    known_names = FACTS.keys() | KEYS | LISTS.keys() | {*COUNTS} | OWN_CONDITIONS.keys()
    kinds = [kind for table in (PARAMETERS, INPUTS, OUTPUTS) for of_owner in table for kind in of_owner.kinds]
    for kind in kinds:
        conditions = {*kind.when, kind.tunable, kind.stores_given_if} - {""}
        assert conditions <= known_names | members_of(OWNER_KINDS[kind.owner_kind].source_list), kind.name


def test_no_owner_changes_what_holds_for_its_scene():
    of_scenes = FACTS.keys() | KEYS | LISTS.keys() | {*COUNTS}
    of_members = {name for list_name in LISTS for name in members_of(list_name)} | {"order"}
    assert not of_scenes & OWN_CONDITIONS.keys()
    assert not of_scenes & of_members
    assert not OWN_CONDITIONS.keys() & of_members


@pytest.mark.parametrize(
    "scene", [*map(load_scene, model_names()), *map(random_scenes.scene, range(20))], ids=str
)
def test_the_conditions_of_a_scene_are_those_that_users_read(scene):
    structure = structure_of(scene)
    conditions, links, slider, contact = (
        structure.numbers,
        scene.chain.links,
        scene.chain.slider,
        scene.contact,
    )
    asked_walls, walls = scene.inputs.wall_motion, scene.half_planes
    moving_walls = [name for name in scene.wall_names if name in walls and {"*", name} & {*asked_walls}]
    assert [wall["name"] for wall in structure.lists["moving_walls"]] == moving_walls
    wall_coefficients = [
        value for wall in contact.wall.values() for value in (wall.friction, wall.static_friction)
    ]
    coefficients = contact.friction + contact.static_friction
    rubs = bool(point_wall_pairs(scene)) and (
        coefficients > 0.0 or wall_coefficients != [None] * len(wall_coefficients)
    )
    assert conditions["has_contact_friction"] == rubs
    jointed = links if scene.chain.base != "free" else links[1:]
    in_joints = any(link.joint_friction for link in jointed)
    assert conditions["has_dry_friction"] == (
        rubs or in_joints or (slider is not None and slider.friction > 0.0)
    )
    assert conditions["skewed"] == any(link.center_of_mass_offset for link in links)
    limits = [slider and slider.force_limit, *(link.joint_torque_limit for link in links)]
    asks = [getattr(scene.inputs, key) for key in INPUT_KEYS]
    assert conditions["has_supply"] == (any(asks) or limits != [None] * len(limits))
    assert conditions["has_base_joint"] == scene.chain.has_base_joint


def test_joint_stops_are_one_owner_and_sliders_have_no_friction():
    stopped = CART.with_values({"link[3].joint_min": -2.0, "link[3].joint_max": 2.0, "slider.max": 0.1})
    structure = structure_of(stopped)
    pairs = structure.numbers["pair_count"]
    stops = [owner.values for owner in structure.owners("stop")]
    assert [(stop["n"], stop["at"]) for stop in stops] == [(2, pairs), (3, pairs + 1)]
    *contacts, end = structure.owners("contact")
    assert (len(contacts), end.values["at"], end.values["name"]) == (pairs, pairs + 3, "slider_max")
    assert all(contact.conditions["may_have_friction"] for contact in contacts)
    assert not end.conditions["may_have_friction"]
    assert end.conditions["has_contact_friction"]
