"""A test run of an FMU in a process of its own: ``python -m chain_impact.fmu.check_run FMU REPORT BINARY``.

With ``--references``, an FMU without findings is also compared with its reference results.

The report goes to a file, because an FMU may print any text. Before each call the program writes a line of
JSON to the report, so that a reader knows in which call the process ended. Further lines have the findings
and the verdict on the reference results.
"""

from __future__ import annotations

import json
import math
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar
from xml.etree import ElementTree

from chain_impact.fmu.check_variables import REALS, DescribedVariable, Value, variables_of
from chain_impact.fmu.findings import DESCRIPTION, END_MARK, Finding
from chain_impact.fmu.importer import collect_messages, instantiate, load_fmu
from chain_impact.fmu.references import REFERENCE_FILE, check_references
from chain_impact.fmu.versions import FMI_2, FMI_3, is_fmi_2

T = TypeVar("T")
# two values count as equal up to this relative difference, because a start value may be written with only
# seven significant digits
START_ROUND_OFF = 1e-6
# in the unit of the variable: two values also count as equal if they differ by at most this
ABSOLUTE_TOLERANCE = 1e-12
LONGEST_MESSAGE = 300  # a message of the FMU is cut to this number of characters in the report
SILENT_REASON = "it gives no reason; its binary may be made for another GUID or token, or for other resources"


class CallError(Exception):
    """Raised when a call of the FMU fails; it ends the test run, unless the call reads a variable."""


class DescriptionError(Exception):
    """Raised when FMPy cannot read the model description; the text says why."""


class CheckRun:
    """A test run of an FMU, which makes the calls one after the other."""

    def __init__(self, path: Path, folder: str, binary: str, tell: Callable[..., None]) -> None:
        """Unpack the FMU to ``folder``, and read its model description.

        ``binary`` is the path of the binary in the FMU, for findings; ``tell`` writes a line of the report.

        Raises:
            DescriptionError: when FMPy cannot read the model description.
        """
        import fmpy

        fmpy.extract(str(path), folder)
        try:
            self.description = fmpy.read_model_description(folder, validate=False)
        except Exception as error:  # FMPy's reader raises any error on a wrong description
            fault = f"cannot be read by FMPy, so the binary is not run: {type(error).__name__}: {error}"
            raise DescriptionError(fault) from None
        self.variables = variables_of(ElementTree.parse(Path(folder, DESCRIPTION)).getroot())
        self.is_fmi_2 = is_fmi_2(self.description.fmiVersion)
        self.folder, self.binary, self.tell = folder, binary, tell

    def run(self, reasons: Callable[[], list[str]]) -> None:
        """Load the FMU, instantiate, compare start values, make steps and restore states, terminate and free.

        An FMU without co-simulation makes no steps, and is not terminated; its values are read once more.
        ``reasons`` returns the messages of the FMU so far.

        Raises:
            CallError: when a call fails; the error's text is a sentence.
        """
        self.reasons = reasons
        self.fmu = self.call("the loader", "", load_fmu, self.description, self.folder)
        self.call("Instantiate", "no instance", instantiate, self.fmu)
        experiment = self.description.defaultExperiment
        start = _number(experiment, "startTime", 0.0)
        if self.is_fmi_2:
            self.call("SetupExperiment", "", self.fmu.setupExperiment, None, start)
            self.call("EnterInitializationMode", "", self.fmu.enterInitializationMode)
        else:
            self.call("EnterInitializationMode", "", self.fmu.enterInitializationMode, None, start)
        self.compare_starts()
        self.call("ExitInitializationMode", "", self.fmu.exitInitializationMode)
        if self.description.coSimulation:
            self.steps(start, self.step_size())
            self.call("Terminate", "", self.fmu.terminate)
        else:
            self.values()
        self.call("FreeInstance", "", self.fmu.freeInstance)

    def call(self, name: str, missing_text: str, function: Callable[..., T], *arguments: Any) -> T:
        """Call a function of the FMU and return its result; the report names the call before it begins.

        If the call fails, the error's sentence begins with "<name> gives <missing_text>", such as
        "fmi2Instantiate gives no instance", or with "<name> fails" if ``missing_text`` is "".
        """
        name = name if " " in name else f"fmi{FMI_2 if self.is_fmi_2 else FMI_3}{name}"
        self.tell(call=name)
        reason_count = len(self.reasons())
        try:
            return function(*arguments)
        except Exception as error:  # fmpy's errors have no common class
            reason = SILENT_REASON if missing_text else str(error).replace(self.folder + os.sep, "")
            reasons = self.reasons()[reason_count:] or [reason]
            result_text = f"gives {missing_text}" if missing_text else "fails"
            raise CallError(
                f"{name} {result_text}: {' '.join(reasons[0].split())[:LONGEST_MESSAGE]}"
            ) from None

    def step_size(self) -> float:
        """Return a communication step [s] that the FMU should accept.

        The step is the fixed internal step of the FMU, else the step of its default experiment, else 1/500 of
        the duration of this experiment, whose stop time is 1 s if none is given; 1 ms if the duration is not
        above 0.
        """
        experiment, stepper = self.description.defaultExperiment, self.description.coSimulation
        fixed = _number(stepper, "fixedInternalStepSize", 0.0)
        length = _number(experiment, "stopTime", 1.0) - _number(experiment, "startTime", 0.0)
        return fixed or _number(experiment, "stepSize", 0.0) or max(length, 0.0) / 500 or 1e-3

    def report_finding(
        self, text: str, variable: DescribedVariable | None = None, attribute: str = ""
    ) -> None:
        """Write a finding to the report: a fault of a variable or, without ``variable``, of the binary."""
        if variable:
            self.tell(finding=asdict(Finding(text, DESCRIPTION, variable.name, attribute)))
        else:
            self.tell(finding=asdict(Finding(text, self.binary)))

    def values(self) -> dict[str, list[Value]]:
        """Return the values of the variables, by name; report and leave out those that cannot be read.

        Clocks, variables with clocks, binaries and arrays of unknown size are left out without a report.
        """
        by_name: dict[str, list[Value]] = {}
        for variable in self.variables:
            size = variable.size
            if variable.type in ("Clock", "Binary") or "clocks" in variable.attributes or size is None:
                continue
            integer_name = "Integer" if self.is_fmi_2 else "Int64"
            kind = integer_name if variable.type == "Enumeration" else variable.type
            get, arguments = getattr(self.fmu, f"get{kind}"), [[int(variable.reference)]]
            try:
                values = self.call(f"Get{kind}", "", get, *arguments, *([] if self.is_fmi_2 else [size]))
            except CallError as error:
                self.report_finding(f"cannot be read as {size} {kind}: {error}", variable)
                continue
            texts = [
                value.decode(errors="replace") if isinstance(value, bytes) else value for value in values
            ]
            by_name[variable.name] = [bool(value) for value in texts] if kind == "Boolean" else texts
        return by_name

    def compare_starts(self) -> None:
        """Report each variable whose start value in the FMU is not that of the model description.

        Start values that are only guesses for a computation are not compared.
        """
        values = self.values()
        for variable in self.variables:
            if variable.is_exact and variable.start and variable.name in values:
                start_values = values[variable.name]
                expected_values = [variable.value(text) for text in variable.start]
                expected_values = (
                    expected_values * len(start_values) if len(expected_values) == 1 else expected_values
                )
                if len(expected_values) == len(start_values) and not _are_close(
                    expected_values, start_values
                ):
                    first = next(
                        i
                        for i in range(len(start_values))
                        if not _is_close(expected_values[i], start_values[i])
                    )
                    index_text = f"[{first}]" if len(start_values) > 1 else ""
                    self.report_finding(
                        f"start{index_text} = {_text(expected_values[first])}, and the FMU itself starts "
                        f"with {_text(start_values[first])}",
                        variable,
                        "start",
                    )

    def steps(self, start: float, step: float) -> None:
        """Take a step, and report values beyond their limits; then test whether states are restored.

        The limits are those of real numbers, enumerations and the integers of FMI 2.0. States are
        tested only if the FMU can save its state.
        """
        self.step(start, step)
        values = self.values()
        for variable in self.variables:
            for value in (
                values.get(variable.name, []) if variable.type in (*REALS, "Integer", "Enumeration") else ()
            ):
                if side := variable.passed_limit(float(value)):
                    self.report_finding(f"is {_text(value)} after a step of {step:.9g} s, {side}", variable)
        if not self.description.coSimulation.canGetAndSetFMUstate:
            return
        state = self.call("GetFMUState", "", self.fmu.getFMUState)
        self.check_restored_state("SetFMUState", state, start + step, step)
        if self.description.coSimulation.canSerializeFMUstate:
            self.call("SetFMUState", "", self.fmu.setFMUState, state)
            content = self.call("SerializeFMUState", "", self.fmu.serializeFMUState, state)
            second_state = self.call("DeserializeFMUState", "", self.fmu.deserializeFMUState, content)
            self.call("SetFMUState", "", self.fmu.setFMUState, state)
            self.check_restored_state("DeserializeFMUState", second_state, start + step, step)
            self.call("FreeFMUState", "", self.fmu.freeFMUState, second_state)
        self.call("FreeFMUState", "", self.fmu.freeFMUState, state)

    def check_restored_state(self, method: str, state: Any, time: float, step: float) -> None:
        """Take a step, restore the state, repeat the step; report the first variable that differs then.

        ``state`` is the state before the step, at ``time`` [s]; ``step`` is the step size [s].
        ``method`` is the name of the call that is tested, for the finding: SetFMUState, or
        DeserializeFMUState if this call made the ``state``.
        """
        self.step(time, step)
        first = self.values()
        self.call("SetFMUState", "", self.fmu.setFMUState, state)
        self.step(time, step)
        values_again = self.values()
        for variable in self.variables:
            known_values = first.get(variable.name, [])
            pairs = zip(
                known_values, values_again.get(variable.name, [math.nan] * len(known_values)), strict=True
            )
            if differing_pair := next((pair for pair in pairs if not _is_close(*pair)), None):
                first_text, second_text = map(_text, differing_pair)
                self.report_finding(
                    f"is {first_text} after a step, and {second_text} after the same step from the restored "
                    f"state ({method})",
                    variable,
                )
                return  # one finding is enough: others probably differ for the same reason

    def step(self, time: float, step: float) -> None:
        """Let the FMU make a step of the size ``step`` [s], from the time ``time`` [s]."""
        self.call("DoStep", "", self.fmu.doStep, time, step, False)


def _number(holder: Any, name: str, default: float) -> float:
    """Return the attribute ``name`` as a number; ``default`` if it is missing, 0 or no finite number."""
    try:
        number = float(getattr(holder, name, None) or default)
    except ValueError:
        return default
    return number if math.isfinite(number) else default


def _is_close(value: Value, other_value: Value) -> bool:
    if isinstance(value, str) or isinstance(other_value, str):
        return value == other_value
    are_nan = math.isnan(value) and math.isnan(other_value)
    return are_nan or math.isclose(value, other_value, rel_tol=START_ROUND_OFF, abs_tol=ABSOLUTE_TOLERANCE)


def _are_close(first_values: Sequence[Value], second_values: Sequence[Value]) -> bool:
    return len(first_values) == len(second_values) and all(map(_is_close, first_values, second_values))


def _text(value: Value) -> str:
    return f"{value:.9g}" if isinstance(value, float) else repr(value)


def main() -> None:
    """Test the FMU that the arguments of the command line name, write the report, and end the process."""
    path, binary = Path(sys.argv[1]), sys.argv[3]
    with Path(sys.argv[2]).open("w", encoding="utf-8") as report:
        findings = 0

        def tell(**what: Any) -> None:
            nonlocal findings
            findings += "finding" in what
            print(json.dumps(what), file=report, flush=True)

        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder, collect_messages() as reasons:
            try:
                CheckRun(path, folder, binary, tell).run(reasons)
            except DescriptionError as error:
                tell(finding=asdict(Finding(str(error), DESCRIPTION)))
            except CallError as error:
                tell(finding=asdict(Finding(str(error), binary)))
        # an FMU with a finding has failed already, so that the longer run with the reference results is
        # skipped
        if not findings and "--references" in sys.argv:
            tell(call="the run with the reference results")
            result, text = check_references(path) or (None, "")
            if result:
                tell(passed=f"reference results: {text}")
            elif text:
                tell(finding=asdict(Finding(text, REFERENCE_FILE)))
        tell(call=END_MARK)
    # ends the process at once, because what the FMU does at the regular end of a process is not tested
    os._exit(0)


if __name__ == "__main__":
    main()
