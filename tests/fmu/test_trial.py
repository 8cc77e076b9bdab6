"""Binaries that crash, that do not come back, and that do not restore their state."""

import re

import pytest

from tests.fmu.planted_faults import BINARY, SUFFIX, said, spoiled
from tests.fmu.zig import zig
from tests.tiers import needs_compilers

SOURCE = """
#include <stdlib.h>
void *fmi2Instantiate(void) { %s }
"""
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
COUNTED = ("fmi2DoStep", "fmi2GetReal")
NAMES = re.findall(
    r"\w+",
    """
    fmi2GetTypesPlatform fmi2GetVersion fmi2SetDebugLogging fmi2FreeInstance fmi2SetupExperiment
    fmi2EnterInitializationMode fmi2ExitInitializationMode fmi2Terminate fmi2Reset fmi2GetReal
    fmi2GetInteger fmi2GetBoolean fmi2GetString fmi2SetReal fmi2SetInteger fmi2SetBoolean
    fmi2SetString fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate fmi2SerializedFMUstateSize
    fmi2SerializeFMUstate fmi2DeSerializeFMUstate fmi2GetDirectionalDerivative
    fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives fmi2DoStep fmi2CancelStep fmi2GetStatus
    fmi2GetRealStatus fmi2GetIntegerStatus fmi2GetBooleanStatus fmi2GetStringStatus
    """,
)


@needs_compilers
@pytest.mark.parametrize(
    ("body", "timeout", "sentence"),
    [
        ("abort();", 60.0, "fmi2Instantiate crashes the process: SIGABRT"),
        ("exit(7);", 60.0, "fmi2Instantiate ends the process, exit code 7"),
        ("for (volatile int i = 0;; i = !i) {}", 5.0, "fmi2Instantiate has not come back after 5 s"),
    ],
)
def test_a_binary_that_does_not_come_back_is_found(native, tmp_path, body, timeout, sentence):
    functions = "".join(f"int {name}(void) {{ return 3; }}\n" for name in NAMES)
    (tmp_path / "fmu.c").write_text(SOURCE % body + functions)
    zig(tmp_path, "-shared", "-fPIC", "fmu.c", "-o", f"fmu{SUFFIX}")
    binary = (tmp_path / f"fmu{SUFFIX}").read_bytes()
    path = spoiled(
        native["rod_drop"], tmp_path / "x.fmu", lambda name, content: binary if name == BINARY else content
    )
    assert said(path, timeout=timeout) == [f"{BINARY}: {sentence}"]


@needs_compilers
def test_a_state_that_does_not_restore_is_found(native, tmp_path):
    """Each value is the number of steps, which no restored state changes."""
    functions = "".join(f"int {name}(void) {{ return 0; }}\n" for name in NAMES if name not in COUNTED)
    (tmp_path / "fmu.c").write_text(COUNTER + functions)
    zig(tmp_path, "-shared", "-fPIC", "fmu.c", "-o", f"fmu{SUFFIX}")
    binary = (tmp_path / f"fmu{SUFFIX}").read_bytes()
    path = spoiled(
        native["rod_drop"], tmp_path / "x.fmu", lambda name, content: binary if name == BINARY else content
    )
    lines = said(path)
    restored = "is 2 after a step, and 3 after the same step from the restored state (SetFMUState)"
    assert any(line.endswith(restored) for line in lines), lines
