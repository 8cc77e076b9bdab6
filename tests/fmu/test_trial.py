"""Binaries that crash, that do not come back, and that do not restore their state."""

import pytest

from tests.fmu.planted_faults import BINARY, SUFFIX, said, spoiled
from tests.fmu.standard import co_simulation_functions
from tests.fmu.zig import zig
from tests.tiers import needs_compilers

COUNTER = """
#include <stddef.h>
static int steps;
static int instance;
void *fmi2Instantiate(void) { return &instance; }
int fmi2DoStep(void *c, double time, double step, int last) { steps += 1; return 0; }
int fmi2GetReal(void *c, const unsigned vr[], size_t n, double values[]) {
    for (size_t i = 0; i < n; i++) values[i] = steps;
    return 0;
}
"""


@pytest.fixture
def found(native, tmp_path):
    """What is found in the FMU of a source; its other functions give a status."""

    def found(source, status, **options):
        others = (
            f"int {n}(void) {{ return {status}; }}\n"
            for n in co_simulation_functions()
            if f"{n}(" not in source
        )
        (tmp_path / "fmu.c").write_text(source + "".join(others))
        zig(tmp_path, "-shared", "-fPIC", "fmu.c", "-o", f"fmu{SUFFIX}")
        binary = (tmp_path / f"fmu{SUFFIX}").read_bytes()
        path = spoiled(native["rod_drop"], tmp_path / "x.fmu", lambda n, old: binary if n == BINARY else old)
        return said(path, **options)

    return found


@needs_compilers
@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        ("abort();", "fmi2Instantiate crashes the process: SIGABRT"),
        ("exit(7);", "fmi2Instantiate ends the process, exit code 7"),
        ("for (volatile int i = 0;; i = !i) {}", "fmi2Instantiate has not come back after 5 s"),
    ],
)
def test_a_binary_that_does_not_come_back_is_found(found, body, sentence):
    source = f"#include <stdlib.h>\nvoid *fmi2Instantiate(void) {{ {body} }}\n"
    assert found(source, 3, timeout=5.0 if "for" in body else 60.0) == [f"{BINARY}: {sentence}"]


@needs_compilers
def test_a_state_that_does_not_restore_is_found(found):
    """Each value is the number of steps, which no restored state changes."""
    restored = "is 2 after a step, and 3 after the same step from the restored state (SetFMUState)"
    lines = found(COUNTER, 0)
    assert any(line.endswith(restored) for line in lines), lines
