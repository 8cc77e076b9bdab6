"""The recipes of docs/development/recipes.md name files that exist, and all places of their examples."""

import re
from pathlib import Path

import pytest

from chain_impact.scene.contents import SceneContents
from chain_impact.scene.reading import keys_of

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "fmu_src" / "chain_impact"
PAGE = (ROOT / "docs" / "development" / "recipes.md").read_text(encoding="utf-8")
KINDS = (".py", ".js", ".c", ".h", ".md", ".json", ".yml")
FOLDERS = (PACKAGE, ROOT / "docs", ROOT / "packaging", ROOT / "tests" / "helpers")
SOURCES = [
    file
    for file in (*(file for folder in FOLDERS for file in folder.rglob("*")), ROOT / "mkdocs.yml")
    if file.suffix in KINDS and file.parent.name != "vendor" and file.name != "recipes.md"
] + [*(ROOT / "tests").rglob("*.txt"), ROOT / "tests" / "pages" / "scene_texts.py"]
SECTIONS = dict(re.findall(r"^## (.*)\n((?:(?!## ).*\n)*)", PAGE, re.M))
"""Heading → text."""
RECIPES = {heading: text for heading, text in SECTIONS.items() if "`" in heading}
for text in SECTIONS.values():
    RECIPES |= re.findall(r"^- (\*\*[^:]*):(.*(?:\n  .*)*)", text, re.M)
"""Heading of a section, or first words of an entry, with examples in quotes → text."""
TEXT_OF_ANCHOR = {
    re.sub(r"[^\w-]", "", heading.lower().replace(" ", "-")): text for heading, text in SECTIONS.items()
}
"""The part of a link to a section after ``#`` → text."""


def examples_in(heading):
    return re.findall(r"`([^`]+)`", heading)


def places_in(text):
    """Return the files and folders that a recipe names, with those of the recipes to which it links."""
    places = re.findall(r"`([\w./]*(?:/|\.(?:py|js|toml|yml|md|json|txt)))`", text)
    for anchor in re.findall(r"\]\(#([\w-]+)\)", text):
        places += places_in(TEXT_OF_ANCHOR[anchor])
    return places


def is_named(file, places):
    """Return whether a file is one of the places, or in one of their folders."""
    path = f"/{file.relative_to(ROOT).as_posix()}"
    return any(f"/{place}" in path if place.endswith("/") else path.endswith(f"/{place}") for place in places)


def test_the_places_of_recipes_exist():
    tops = [ROOT / top for top in (".ci", "docs", "fmu_src", "models", "packaging", "tests")]
    files = [file for top in tops for file in top.rglob("*.*")] + [*ROOT.iterdir()]
    places = {place for text in SECTIONS.values() for place in places_in(text)}
    assert len(places) > 60
    assert [place for place in places if not any(is_named(file, [place]) for file in files)] == []


@pytest.mark.parametrize(
    ("heading", "example"),
    [(heading, example_of_recipe) for heading in RECIPES for example_of_recipe in examples_in(heading)],
)
def test_a_recipe_names_all_places_of_its_example(heading, example):
    word = re.compile(rf"(?<!\w){re.escape(example)}(?!\w)")
    uses = [file for file in SOURCES if word.search(file.read_text(encoding="utf-8"))]
    assert len(uses) > 0 or (ROOT / "models" / example).is_dir()
    # a folder of the package is no place: the recipe must name the file
    places = [place for place in places_in(RECIPES[heading]) if not (PACKAGE / place).is_dir()]
    assert places
    places += places_in(SECTIONS["After each change"])
    assert [file.as_posix() for file in uses if not is_named(file, places)] == []


def test_the_code_of_the_first_contribution_is_that_of_the_repository():
    blocks = re.findall(r'^```py title="(.*)"\n((?:(?!```).*\n)+)', PAGE, re.M)
    assert len(blocks) >= 3
    assert [name for name, text in blocks if text not in (ROOT / name).read_text(encoding="utf-8")] == []


WITHOUT_RANDOM_SCENES = {
    *("author", "copyright", "license", "version"),
    *("box.y_max", "contact.law_file", "initial.joint_angles"),
    *(f"signals.<name>.{key}" for key in ("file", "frequency_rate", "interpolation", "period")),
}


def test_random_scenes_have_the_keys_of_scenes():
    text = "".join(
        file.read_text(encoding="utf-8") for file in (ROOT / "tests/helpers/campaigns").glob("*.py")
    )
    words = {*re.findall(r"\w+", text)}
    unused_keys = {key for key, _ in keys_of(SceneContents) if re.findall(r"\w+", key)[-1] not in words}
    assert unused_keys == WITHOUT_RANDOM_SCENES
