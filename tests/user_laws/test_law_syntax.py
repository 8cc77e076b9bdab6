"""A law's file executes only its own constant definitions, whatever the file contains."""

# Tests: compilation/law.py, user_laws/law_file.py

import re
from pathlib import Path

import pytest

from chain_impact import SceneError, load_scene, simulate
from chain_impact.user_laws.law_file import LawError, parse_law, read_law
from chain_impact.user_laws.law_syntax import ALLOWED_SYNTAX
from tests.tiers import needs_compilers

LAW = "def damped(rate):\n    return 1e3 * rate\n"
RUN = '__import__("pathlib").Path("{mark}").touch()'
# statement that would leave a mark if executed → the line in the error message
HOSTILE = {
    "a statement": (f"{RUN}\n{LAW}", 1),
    "a constant": (f"X = {RUN}\n{LAW}", 1),
    "a default": (f"def damped(rate={RUN}):\n    return rate\n", 1),
    "a default of another function": (f"def other(x, y={RUN}):\n    return x\n{LAW}", 1),
    "a default for a name": (f"def other(x, *, y={RUN}):\n    return x\n{LAW}", 1),
    "a lambda in a default": (f"def other(x, y=lambda: {RUN}):\n    return x\n{LAW}", 1),
    "a decorator": (f"@(lambda f: {RUN})\n{LAW}", 1),
    "a decorator by name": (f"def other(f):\n    return f\n@other\n{LAW}", 3),
    "an annotation": (f"def damped(rate: {RUN}) -> float:\n    return rate\n", 1),
    "an annotation of what is returned": (f"def damped(rate) -> {RUN}:\n    return rate\n", 1),
    "an annotation of a constant": (f"X: {RUN} = 1.0\n{LAW}", 1),
    "a generator expression": (f"X = max({RUN} for _ in (1, 2))\n{LAW}", 1),
    "the classes of Python": (f"X = ().__class__.__bases__[0].__subclasses__()\n{LAW}", 1),
    "an f-string": (f"X = f'{{().__class__}}'\n{LAW}", 1),
    "a walrus": (f"X = (y := {RUN})\n{LAW}", 1),
    "exec": (f"exec('{RUN}')\n{LAW}", 1),
    "exec by another name": (f"X = exec\nY = X('{RUN}')\n{LAW}", 1),
    "exec where a function has a value of that name": (
        "def damped(rate):\n    exec = rate\n    return exec\nX = exec({})\n",
        4,
    ),
    "exec in letters that Python reads as others": (f"ｅｘｅｃ('{RUN}')\n{LAW}", 1),
    "eval in a function": (f"def damped(rate):\n    return eval('{RUN}')\n", 2),
    "all of a module": (f"from math import *\n{LAW}", 1),
    "what is not of the module": (f"from math import __loader__\n{LAW}", 1),
    "a loader": (f"import math\nX = math.__loader__\n{LAW}", 2),
    "another function for everybody": (f"import math\ndef f(x):\n    return x\nmath.sqrt = f\n{LAW}", 4),
    "a class": (f"class A:\n    x = {RUN}\n{LAW}", 1),
    "a branch": (f"if True:\n    {RUN}\n{LAW}", 2),
    "a loop": (f"for x in (1, 2):\n    {RUN}\n{LAW}", 2),
    "a loop over what takes long": (f"while True:\n    pass\n{LAW}", 1),
    "a function of the file": (f"def other():\n    return 1.0\nX = other()\n{LAW}", 3),
    "what Python knows of a module": (f"X = __builtins__['exec']\n{LAW}", 1),
    "all names": (f"X = globals()['damped']\n{LAW}", 1),
    "another builtin": (f"__builtins__ = 1\n{LAW}", 1),
    "an attribute by its name": (f"import math\nX = getattr(math, 'sqrt')\n{LAW}", 2),
    "a print": (f"print('a')\n{LAW}", 1),
    "a coroutine": (f"async def other():\n    return 1.0\n{LAW}", 1),
    "a with": ("def damped(rate):\n    with rate:\n        return rate\n", 2),
    "a delete": (f"{LAW}del damped\n", 3),
}  # fmt: skip


@pytest.mark.parametrize(("text", "line"), HOSTILE.values(), ids=HOSTILE.keys())
def test_a_hostile_file_is_not_run(text, line, tmp_path):
    mark, file = tmp_path / "mark", tmp_path / "damped.py"
    file.write_text(text.replace("{mark}", str(mark)).replace("{}", f"'{mark}'"), encoding="utf-8")
    values = {"contact.law_file": str(file), "contact.model": "damped"}
    with pytest.raises(SceneError) as caught:
        simulate(load_scene("rod_drop").with_values(values))
    assert not mark.exists()
    path, allowed_text = map(re.escape, (str(file), ALLOWED_SYNTAX))
    assert re.fullmatch(
        rf"RodDrop: contact\.law_file = '{path}' has .* in line {line}; {allowed_text}", str(caught.value)
    )


@pytest.mark.parametrize("text", ["-" * 100_000 + "1", "(" * 5000, "x" + ".y" * 100_000, "\0"])
def test_a_file_that_is_too_much_for_python_is_refused(text):
    with pytest.raises(LawError, match=r"^(is not valid Python: .|has x\.y)"):
        parse_law("damped", f"X = {text}\n{LAW}")


@needs_compilers
@pytest.mark.parametrize(
    "text",
    [
        "'''What it is.'''\nimport math as m\nfrom math import sqrt as root, pi\nX: float = root(2.0) * pi\n"
        "Y = m.sqrt(X) if X > 1 else max(abs(-X), 2)\ndef damped(rate: float) -> float:\n    return X * rate",
        "TABLE = (1.0, 2.0)\ndef pair(x, y=2.0 * 3):\n    return x, y\n"
        "def damped(rate):\n    a, b = pair(rate, y=1.0)\n    return a * TABLE[0] + b",
        "def damped(rate):\n    def twice(x):\n        return 2.0 * x\n    total = 0.0\n    k = 0\n"
        "    while k < 3 and not total > 1e9:\n        k += 1\n        if k == 2:\n            continue\n"
        "        total += twice(rate)\n    return total",
        "def damped(rate):\n    sum = 0.0\n    for k in range(3):\n"
        "        sum += rate ** k // 1 % 7\n    return sum",
    ],
)
def test_a_law_may_use_what_it_needs_and_compiles(text):
    from chain_impact.compilation.law import law_entry

    assert law_entry(parse_law("damped", text))


def test_the_laws_of_the_page_are_allowed(tmp_path):
    page = Path(__file__).parents[2] / "docs" / "walls.md"
    blocks = re.findall(
        r"^```python[^\n]*\n((?:(?!```).)*^def .*?)^```", page.read_text(encoding="utf-8"), re.M | re.S
    )
    functions = [re.search(r"^def .*?(?=^\S|\Z)", block, re.M | re.S) for block in blocks]
    laws = {match[0].split("(")[0].removeprefix("def "): (block, match[0])
            for block, match in zip(blocks, functions, strict=True)}  # fmt: skip
    assert list(laws) == ["rubber", "saturated"]
    for name, (block, function) in laws.items():
        file = tmp_path / f"{name}.py"
        file.write_text(block if name == "rubber" else f"import math\n{function}", encoding="utf-8")
        assert read_law(file).arguments[0] == "penetration"
