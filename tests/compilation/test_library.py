"""The kernel as a shared library: its dependencies, and its sources."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import chain_impact.kernel
from chain_impact import BuildError, load_scene, simulate
from chain_impact.compilation import compilers, library, prebuilt
from chain_impact.compilation.library import kernel_library
from chain_impact.extras import how_to_install
from chain_impact.scene.scene import with_values
from chain_impact.simulation.kernels import load_kernel
from chain_impact.system import HOST
from chain_impact.user_laws.law_file import LawError
from chain_impact.variables.prepared import PreparedScene
from tests.fmu.standard import all_functions_of_fmi3, co_simulation_functions
from tests.helpers.tools.binaries import read_binary
from tests.tiers import needs_compilers

ENTRY_POINTS = {
    *("initialize", "advance_to", "advance_awhile", "advance_to_onset", "event_update"),
    *("observe_now", "is_sound", "log_contacts", "trajectory", "run_each", "record_words"),
}
OLDEST_GLIBC = (2, 17)  # CentOS 7, of 2014
HOST_ONLY = pytest.mark.skipif(sys.platform != "linux", reason="reads an ELF file")


@pytest.fixture(scope="module")
def one_link():
    return kernel_library(1)


@HOST_ONLY
def test_a_library_offers_the_interface_and_needs_an_old_c_library_only(one_link):
    binary, content = read_binary(one_link), one_link.read_bytes()
    assert [name for name in binary.needed if re.match(r"_?Py|NRT_|numba|_ZN|chain_|user_law", name)] == []
    assert not {"cos", "exp", "expm1", "fmod", "log", "log1p", "pow", "sin", "sincos"} & set(binary.needed)
    offered = {name for name in binary.offered if not name.startswith("_")}
    standard = {*co_simulation_functions(), *all_functions_of_fmi3()}
    assert offered == ENTRY_POINTS | standard | {"another_fmi2_instance"}
    assert binary.libraries == {"libc.so.6", "libm.so.6"}
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", content)
    assert (0, 0) < max((int(major), int(minor)) for major, minor in versions) <= OLDEST_GLIBC
    for folder in (f"{Path.home()}/", str(Path(chain_impact.kernel.__file__).parent)):
        assert folder.encode() not in content


@pytest.mark.parametrize("part", [library.KERNEL, library.DERIVATIVES])
def test_the_kernel_does_not_allocate(part):
    module = library._lowered_kernel(part)
    assert {library.KERNEL: "@initialize", library.DERIVATIVES: "@on_start"}[part] in module
    assert not [name for name in ("NRT_Allocate", "NRT_MemInfo_alloc", "malloc") if name in module]


@pytest.mark.full("takes long")
def test_every_function_that_it_offers_computes_with_the_usual_registers():
    """No arithmetic is inlined into an exported function, where it could run before the registers are set."""
    module = library._lowered_kernel(library.KERNEL)
    for name in ENTRY_POINTS:
        (body,) = re.findall(rf"^define [^\n]*@{name}\(.*?^\}}", module, re.M | re.S)
        calls = re.findall(r"call [^\n]*@\S+?\(.*", body)
        assert "@usual_registers()" in calls[0]
        assert "@put_registers_back(" in calls[-1]
        assert len(calls) == 3
        attributes = re.findall(r"#\d+$", calls[1])
        assert re.search(rf"^attributes {attributes[0]} = {{[^}}]*noinline", module, re.M)


def test_kernels_for_any_and_for_four_links_give_equal_bits():
    scene = load_scene("four_link_box")
    outputs = []
    for path in (kernel_library(4), kernel_library(prebuilt.LARGEST_EXACT + 1)):
        memory, kernel = PreparedScene(scene).new_instance(), load_kernel(path)
        assert kernel.initialize(memory.ctypes.data, 0.0) == 0
        assert kernel.advance_to(memory.ctypes.data, 1.0) == 0
        assert kernel.observe_now(memory.ctypes.data) == 0
        outputs.append(memory.tobytes())
    assert outputs[0] == outputs[1]
    assert memory[0]["impact"]["count"] > 1


def test_the_number_of_candidates_is_no_part_of_a_kernel():
    """A wall that is never touched changes only the offsets in the record."""
    scene = load_scene("rod_drop")
    scene_of_more_walls = with_values(scene, {("box", "y_max"): 1e3, ("box", "x_min"): -1e3})
    result, result_of_more_walls = (
        simulate(scene, stop_time=1.0),
        simulate(scene_of_more_walls, stop_time=1.0),
    )
    np.testing.assert_array_equal(result.points, result_of_more_walls.points)
    np.testing.assert_array_equal(result.energy, result_of_more_walls.energy)
    assert result.statistics == result_of_more_walls.statistics


@needs_compilers
def test_a_law_that_calls_what_only_numba_has_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(compilers, "interface_sources", list)  # the law alone
    (tmp_path / "mine.py").write_text("import math\n\n\ndef mine(rate):\n    return math.gamma(rate)\n")
    compilers.lower(tmp_path / "mine.ll", "law", tmp_path / "mine.py")
    empty_source = tmp_path / "nothing.c"
    empty_source.touch()
    with pytest.raises(LawError, match=r"^calls gamma, which a kernel does not have$"):
        compilers.link([empty_source], tmp_path / "kernel.so", HOST, tmp_path / "mine.ll")


@needs_compilers
def test_long_chains_share_a_kernel():
    assert kernel_library(30) == kernel_library(1000)


# --- the steps to a kernel, with compilers that only write files ------------------------------------------


class Compilers:
    """Stand-ins for numba and zig."""

    def __init__(self):
        self.lowered, self.compiled = [], []

    def lower(self, module, part, _law=None):
        self.lowered.append(part)
        module.write_text(part)

    def compile_part(self, module, compiled, platform, part, scope):
        assert module == part
        assert compiled.name.startswith(part)
        self.compiled.append((part, platform, scope))
        compiled.write_text(f"{part} for {scope}")

    def link(self, parts, library, platform, law=None):
        assert all(part.stem.endswith(platform) for part in parts)
        texts = [*(part.read_text() for part in parts), *([law.name] if law else [])]
        library.write_text(" and ".join(texts))


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """Replace the compilers by stand-ins, with an empty cache and no prebuilt library."""
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv(prebuilt.RELEASE, raising=False)
    monkeypatch.setattr(prebuilt, "_is_usable", lambda: False)
    stand_ins = Compilers()
    for name in ("lower", "compile_part", "link"):
        monkeypatch.setattr(compilers, name, getattr(stand_ins, name))
    return stand_ins


@needs_compilers
def test_the_kernel_is_lowered_and_linked_once_for_any_number_of_links(stand_in, caplog):
    caplog.set_level("INFO", "chain_impact")
    first = kernel_library(2)
    messages = [text.partition(" (about")[0] for text in caplog.messages]
    assert messages == ["compiling the kernel", "linking the kernel for linux64"]
    assert {kernel_library(links) for links in (2, 3, 64)} == {first}
    assert (stand_in.lowered, first.suffix) == (["kernel"], ".so")
    assert stand_in.compiled == [("kernel", "linux64", compilers.AnyLinks.PLAIN)]
    assert len(caplog.messages) == 2
    assert (kernel_library(3, "win64").suffix, stand_in.lowered) == (".dll", ["kernel"])


@needs_compilers
def test_for_a_release_it_is_linked_for_each_number_of_links_up_to_ten(stand_in, monkeypatch):
    monkeypatch.setenv(prebuilt.RELEASE, "1")
    for links in (3, prebuilt.LARGEST_EXACT, prebuilt.LARGEST_EXACT + 1):
        kernel_library(links)
    assert [links for *_, links in stand_in.compiled] == [3, prebuilt.LARGEST_EXACT, compilers.AnyLinks.PLAIN]


@needs_compilers
def test_derivatives_are_linked_to_the_unchanged_kernel(stand_in):
    plain, with_derivatives = kernel_library(3), kernel_library(3, derivatives=True)
    assert plain.read_text() == "kernel for AnyLinks.PLAIN"
    assert with_derivatives.read_text() == "kernel for AnyLinks.PLAIN and derivatives for AnyLinks.PLAIN"
    assert {kernel_library(links, derivatives=True) for links in (1, 2, 4)} == {with_derivatives}
    assert stand_in.lowered == ["kernel", "derivatives"]
    assert [part for part, *_ in stand_in.compiled] == ["kernel", "derivatives"]


@needs_compilers
def test_laws_are_linked_to_one_kernel(stand_in, tmp_path):
    files = [tmp_path / "one" / "mine.py", tmp_path / "two" / "mine.py"]
    for file, force in zip(files, ("1.0", "2.0"), strict=True):
        file.parent.mkdir()
        file.write_text(f"def mine(rate):\n    return {force}\n")
    first, second = (kernel_library(2, law_file=str(file)) for file in files)
    assert len({first, second, kernel_library(2)}) == 3
    with_derivatives = kernel_library(2, law_file=str(files[0]), derivatives=True)
    assert stand_in.lowered == ["law", "kernel", "law", "derivatives"]
    assert len(stand_in.compiled) == 2
    for file, parts in (
        (first, ["kernel"]),
        (second, ["kernel"]),
        (with_derivatives, ["kernel", "derivatives"]),
    ):
        law = file.stem.removeprefix(f"{parts[-1]}-any-").removesuffix("-linux64")
        assert file.read_text() == " and ".join(
            [*(f"{part} for AnyLinks.PLAIN" for part in parts), f"{law}.ll"]
        )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, f"this kernel needs a compiler: {how_to_install('compiler')} (ziglang missing)"),
        ({"platform": "win64"}, "a kernel for win64 needs a compiler: "),
        ({"derivatives": True}, "a kernel that carries derivatives needs a compiler: "),
        ({"law_file": "mine.py"}, "mine.py: a contact law of your own needs a compiler: "),
    ],
)
def test_without_a_compiler_one_sentence_says_what_to_install(
    stand_in, monkeypatch, tmp_path, arguments, message
):
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text("def mine(rate):\n    return 1.0\n")
    monkeypatch.setattr(prebuilt, "find_spec", lambda name: None if name == "ziglang" else name)
    with pytest.raises(BuildError) as caught:
        kernel_library(3, **arguments)
    assert str(caught.value).startswith(message)
    assert stand_in.lowered == []


@needs_compilers
@pytest.mark.parametrize(("step", "finished"), [("compile_part", []), ("link", ["kernel-any-linux64.o"])])
def test_a_compiler_that_fails_leaves_nothing_behind(stand_in, monkeypatch, tmp_path, step, finished):
    def fails(_, output, *__, **___):
        output.write_text("half")
        raise BuildError("no luck")

    monkeypatch.setattr(compilers, step, fails)
    with pytest.raises(BuildError, match="no luck"):
        kernel_library(3)
    (folder,) = (path for path in (tmp_path / "cache").iterdir() if path.is_dir())
    left = {path.name for path in folder.iterdir() if not path.name.endswith((".lock", ".crc32"))}
    assert left == {"kernel.ll", *finished}
