"""Variables of the package, and of rooms of the tests, have names that say what they hold."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "fmu_src" / "chain_impact"
ROOMS = {file.parent.name for file in PACKAGE.glob("*/__init__.py")} - {"kernel"}

ADJECTIVES = """
above across after again ahead alike allowed alone along apart around asked away before behind below
beside between beyond both by changed chosen done drawn driven each either every exact expected far fast
few fewer filled finite found free fresh given held here hidden how inner inside kept known largest later
least like lost made marked matches meant met mine missing more most moved moves moving named near nearest
needed new nothing numbered of off often old one only other others otherwise ours own prepared reached
relative relevant rests said scaled seen several shown small some sorted still taken there told tried
turned turns typed unknown until up usable used usual varied varying wanted what where which whole
why wide within without written wrong
"""
"""Adjectives, verb forms, pronouns and prepositions: alone, none of them says what a variable holds."""
NOUNS = """
bodies candidates choices curves drives errors events facts inputs keys kit members names numbers places
prepared_scene recording rows scene tables text
"""
"""Usual names of variables: a variable of this name hides a function of this name."""
PUBLIC_PARAMETERS = {("plot", "around"), ("curves", "around"), ("curves_of", "around"), ("fit", "free")}
PUBLIC_PARAMETERS |= {(function, "like") for function in ("save", "write_scene")}
PUBLIC_PARAMETERS |= {("__eq__", "other"), ("__init__", "what"), ("__init__", "otherwise")}


def variables(file):
    """Yield (function or "", name) of each parameter and variable of a file.

    Attributes with a type in the body of a class, and older names of attributes, are left out.
    """
    code = [*ast.walk(ast.parse(file.read_text("utf-8")))]
    attributes = {
        id(target)
        for node in code
        if isinstance(node, ast.ClassDef)
        for line in node.body
        for target in (getattr(line, "target", None), *getattr(line, "targets", ()))
        if isinstance(line, ast.AnnAssign) or "OlderName(" in ast.unparse(line)
    }
    for node in code:
        if isinstance(node, (ast.FunctionDef, ast.Lambda)):
            arguments = (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)
            yield from ((getattr(node, "name", ""), argument.arg) for argument in arguments)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and id(node) not in attributes:
            yield "", node.id


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_no_variable_is_a_bare_adjective(room):
    """A name such as kept does not say what is kept: kept_rows does."""
    names_of_room = {pair for file in (PACKAGE / room).rglob("*.py") for pair in variables(file)}
    assert {
        pair for pair in names_of_room if pair[1].lower().strip("_") in ADJECTIVES.split()
    } - PUBLIC_PARAMETERS == set()


ROOMS_OF_TESTS = """
benchmarks
docs/tools
tests/*.py
tests/cli
tests/compilation
tests/conversion
tests/fmu
tests/helpers
tests/kernel
tests/pages
tests/pictures
tests/recording
tests/repository
tests/results
tests/scenarios
tests/scene
tests/simulation
tests/studies
tests/study_data
tests/user_laws
tests/variables
"""
"""Files and folders of the repository, outside of the package, that are read."""
HASHED = """
body_model chain_friction chain_model chain_parts complex_laws derivatives problems reference textbook
"""
"""Helpers whose code is part of the hashes of stored answers; they are not read."""
SAY_NOTHING = "done found known one right said told truth"
"""Alone, none of them says what a variable holds: a value is a ``result``, its known value ``expected``."""
WITHOUT_ADJECTIVES = {*ROOMS_OF_TESTS.split()} - {"tests/helpers", "tests/kernel", "tests/scenarios"}
"""Rooms in which no variable is one of ADJECTIVES, either, except ``expected``."""


@pytest.mark.parametrize("room", ROOMS_OF_TESTS.split())
def test_no_variable_of_a_test_says_nothing(room):
    """A name such as done does not say what is done: process does."""
    files = {file for path in ROOT.glob(room) for file in (path.rglob("*.py") if path.is_dir() else [path])}
    files -= {file for file in files if file.parent.parent.name == "helpers" and file.stem in HASHED.split()}
    assert files
    names = {(file.name, name) for file in files for _, name in variables(file)}
    words = {*SAY_NOTHING.split(), *(ADJECTIVES.split() if room in WITHOUT_ADJECTIVES else ())}
    assert {pair for pair in names if pair[1].lower().strip("_") in words - {"expected"}} == set()


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_no_function_has_the_name_of_a_usual_variable(room):
    """A variable such as keys hides a function keys: key_fields says what the function returns."""
    functions = {
        node.name
        for file in (PACKAGE / room).rglob("*.py")
        for node in ast.parse(file.read_text("utf-8")).body
        if isinstance(node, ast.FunctionDef)
    }
    assert functions & {*NOUNS.split()} == set()


TEXTS = """
advice beginning cause code fault file heading headline hint key kind label line mark name note path pattern
prefix reason remedy requirement script sentence subject text title unit verb warning
"""
"""Last words of the names of texts."""
TRUTHS = """
is has are acts asks begins can changes damps differs displaces lacks may overlaps touches
"""
"""First words of the names of truths, and of arrays of truths."""
MOTIONS = """
arrives ends falls fits had jumps keeps leaves moves passes rises slides sticks stops stores
"""
"""First words of further names of truths in the kernel: verbs of motions, contacts and steps."""
OF_NUMBA = {("collecting.py", "_finalized")}
"""Attributes that numba's own classes have."""


def bindings(file):
    """Yield (name, its value as code) of each variable and attribute of ``self`` that a file binds.

    Attributes with a type in the body of a class are left out.
    """

    def pairs(target, value):
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for part, part_value in zip(target.elts, value.elts, strict=False):
                yield from pairs(part, part_value)
        elif isinstance(target, ast.Name):
            yield target.id, value
        elif isinstance(target, ast.Attribute) and ast.unparse(target.value) == "self":
            yield target.attr, value

    code = [*ast.walk(ast.parse(file.read_text("utf-8")))]
    attributes = [line for node in code if isinstance(node, ast.ClassDef) for line in node.body]
    for node in code:
        if isinstance(node, (ast.Assign, ast.NamedExpr)) or (
            isinstance(node, ast.AnnAssign) and node.value is not None and node not in attributes
        ):
            for target in getattr(node, "targets", None) or [node.target]:
                yield from pairs(target, node.value)


def operands(value):
    """Yield the values of which a value is composed, or of which it is one."""
    match value:
        case ast.IfExp(body=first, orelse=second):
            yield from (*operands(first), *operands(second))
        case ast.BinOp(left=first, op=ast.Add() | ast.Mult() | ast.BitAnd() | ast.BitOr(), right=second):
            yield from (*operands(first), *operands(second))
        case ast.BoolOp(values=parts):
            yield from (operand for part in parts for operand in operands(part))
        case ast.UnaryOp(op=ast.Invert(), operand=first):
            yield from operands(first)
        case ast.Call(func=ast.Attribute(value=first, attr="replace" | "removeprefix" | "strip")):
            yield from operands(first)
        case _:
            yield value


def is_text(value):
    """Return whether a value is a composed text, or words with a space."""
    match value:
        case ast.JoinedStr() | ast.Call(func=ast.Attribute(value=ast.Constant(value=str()), attr="join")):
            return True
        case ast.Constant(value=str(text)):
            return " " in text.strip()
    return False


def is_truth(value):
    """Return whether a value is a truth, or an array of truths."""
    match value:
        case ast.Compare() | ast.UnaryOp(op=ast.Not()) | ast.Constant(value=bool()):
            return True
        case ast.Call(func=ast.Name(id="bool" | "any" | "all" | "isinstance")):
            return True
    return False


@pytest.mark.parametrize("room", sorted({*ROOMS, "kernel"}))
def test_names_of_texts_and_of_truths_say_so(room):
    """A text such as points_text is not taken for points, nor a truth such as is_joint for a joint."""
    misnamed, truths = set(), [*TRUTHS.split(), *(MOTIONS.split() if room == "kernel" else ())]
    for file in (PACKAGE / room).rglob("*.py"):
        for name, value in bindings(file):
            words = name.strip("_").split("_")
            if any(map(is_text, operands(value))) and words[-1] not in TEXTS.split():
                misnamed.add((file.name, name))
            if all(map(is_truth, operands(value))) and words[0] not in truths:
                misnamed.add((file.name, name))
    # the name of a type begins with a capital
    assert {(file, name) for file, name in misnamed if name.islower()} - OF_NUMBA == set()


KERNEL_WORDS = {
    "trial": r"",
    "place": r"_?place(_\w+)?|PLACEHOLDERS",
    "places": r"",
    "words": r"(next_|of_|command_|whole_)?words|WORDS",
}
"""A word that has a meaning of its own in the kernel → the names outside of it that may contain the word: the
verb to place, and the words of a text. A *word* of the record is 8 bytes: see MEMORY."""
MEMORY = ("compilation/", "simulation/", "variables/", "fmu/model_bin.py", "studies/animate.py")
"""Files and folders that read the record's words of memory."""


ROOMS_OF_WORDS = {
    "driven": r"scene/scene\.py",
    "fill": r"variables/\S+|pictures/(bars|drawing/dark_ground|motion/bodies)\.py",
    "varied": r"(cli|studies|study_data|pictures)/sweep\S*",
}
"""A word → the files whose names may contain it: records and areas of a picture are filled, a sweep varies
parameters, and ``Scene.is_driven`` is public; else signals give inputs, and drives are those of joints."""


def all_names(file):
    """Return the names of variables, parameters, functions, classes and attributes that a file defines."""
    code = [*ast.walk(ast.parse(file.read_text("utf-8")))]
    names = {name for _, name in variables(file)}
    names |= {node.name for node in code if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    return names | {
        node.attr for node in code if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    }


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_a_word_stays_in_the_room_of_its_meaning(room):
    misplaced = set()
    for file in (PACKAGE / room).rglob("*.py"):
        path = file.relative_to(PACKAGE).as_posix()
        words = {word for name in all_names(file) for word in name.lower().split("_")}
        misplaced |= {
            (path, word)
            for word, files in ROOMS_OF_WORDS.items()
            if word in words and not re.fullmatch(files, path)
        }
    assert misplaced == set()


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_words_of_the_kernel_have_no_other_meaning(room):
    """What the kernel calls a trial, a place or a word is not something else in another room."""
    misnamed = set()
    for file in (PACKAGE / room).rglob("*.py"):
        path, names = file.relative_to(PACKAGE).as_posix(), all_names(file)
        for word, pattern in KERNEL_WORDS.items():
            if word != "words" or not path.startswith(MEMORY):
                misnamed |= {
                    (path, name)
                    for name in names
                    if word in name.lower().split("_") and not re.fullmatch(pattern, name)
                }
    assert misnamed - {("scene/errors.py", "place"), ("simulation/errors.py", "place")} == set()
