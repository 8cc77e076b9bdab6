"""Masters that co-simulate FMUs, all by one scheme: fmpy, libcosim and Ecos.

FMUs are connected where an output and an input have one name. At each communication point every output goes
to its input, then all FMUs take the next step: the order of the FMUs does not matter (Jacobi's scheme).

``build`` makes the FMUs of a scene and of a slave in Python; ``co_simulate`` runs them with a master; ``run``
does both for a script, with the options of its command line.
A master takes the paths of the FMUs and the communication points, equally spaced from 0, shape (T,) [s], and
returns all outputs that are numbers at these, real ones and integers: name → array of shape (T,).
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.metadata
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave


def references(path, causality, kind="Real"):
    """Return the value references of an FMU's variables of one causality and type: name → reference."""
    variables = fmpy.read_model_description(str(path)).modelVariables
    return {v.name: v.valueReference for v in variables if v.causality == causality and v.type == kind}


def connections(fmus):
    """Return the connections of FMUs: place of the output's FMU, place of the input's FMU, name."""
    outputs, inputs = ([references(path, which) for path in fmus] for which in ("output", "input"))
    return [
        (source, sink, name)
        for source, out in enumerate(outputs)
        for sink, into in enumerate(inputs)
        for name in out
        if name in into
    ]


# --- fmpy --------------------------------------------------------------------------------------------------


class Slave:
    """An initialized FMU that is ready to step."""

    def __init__(self, path, stop_time):
        """Unzip, instantiate and initialize."""
        description = fmpy.read_model_description(str(path))
        self.folder = fmpy.extract(str(path))
        self.inputs, self.outputs = references(path, "input"), references(path, "output")
        self.integers = references(path, "output", "Integer")
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=description.modelName,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0, stopTime=stop_time)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def read(self):
        """Return the outputs: name → value."""
        reals = self.fmu.getReal(list(self.outputs.values()))
        integers = self.fmu.getInteger(list(self.integers.values()))
        return dict(zip((*self.outputs, *self.integers), (*reals, *integers), strict=True))

    def write(self, signals):
        """Set those inputs that the signals, name → value, have."""
        names = [name for name in self.inputs if name in signals]
        self.fmu.setReal([self.inputs[name] for name in names], [signals[name] for name in names])

    def close(self):
        """Free the FMU and its folder."""
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def by_fmpy(fmus, time):
    """Co-simulate with a Python loop that calls the FMUs through fmpy."""
    slaves = [Slave(path, time[-1]) for path in fmus]
    rows = []
    for k, now in enumerate(time):
        for slave in slaves if k > 0 else ():
            # this difference has no round-off, so that the step ends exactly at the communication point
            slave.fmu.doStep(currentCommunicationPoint=time[k - 1], communicationStepSize=now - time[k - 1])
        signals = {name: value for slave in slaves for name, value in slave.read().items()}
        rows.append(list(signals.values()))
        for slave in slaves:
            slave.write(signals)
    for slave in slaves:
        slave.close()
    return dict(zip(signals, np.transpose(rows), strict=True))


# --- libcosim ----------------------------------------------------------------------------------------------


def by_libcosim(fmus, time):
    """Co-simulate with the fixed-step algorithm of libcosim, through libcosimpy."""
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)
    step = round(time[1] * 1e9)  # ns
    if not np.isclose(step * 1e-9, time[1], rtol=1e-12, atol=0.0):
        raise ValueError(
            f"libcosim counts time in nanoseconds: a step of {time[1]:.9g} s is not a whole number of them"
        )
    execution = CosimExecution.from_step_size(step)
    slaves = [CosimLocalSlave(str(path), Path(path).stem) for path in fmus]
    places = [execution.add_local_slave(slave) for slave in slaves]
    outputs, inputs = ([references(path, which) for path in fmus] for which in ("output", "input"))
    for source, sink, name in connections(fmus):
        execution.connect_real_variables(
            places[source], outputs[source][name], places[sink], inputs[sink][name]
        )
    observer = CosimObserver.create_time_series(len(time))
    execution.add_observer(observer)
    series = [
        (name, place, reference, kind)
        for place, path in zip(places, fmus, strict=True)
        for kind in ("Real", "Integer")
        for name, reference in references(path, "output", kind).items()
    ]
    for _, place, reference, kind in series:
        observer.start_time_series(place, reference, CosimVariableType[kind.upper()])
    if not execution.step(len(time) - 1):
        raise RuntimeError("libcosim could not finish the simulation; its log has the reason")

    read = {"Real": observer.time_series_real_samples, "Integer": observer.time_series_integer_samples}

    def samples(place, reference, kind):
        # libcosimpy reports no sample for step 0 and omits another for it, so step 0 is requested separately
        ranges = ((0, 2), (1, len(time) - 1))
        return np.concatenate([read[kind](place, reference, *r)[2] for r in ranges])

    return {name: samples(*where) for name, *where in series}


# --- Ecos --------------------------------------------------------------------------------------------------


def by_ecos(fmus, time):
    """Co-simulate with the fixed-step algorithm of Ecos, through ecospy."""
    load_tbb()
    from ecospy import EcosSimulation, EcosSimulationStructure

    names = [Path(path).stem for path in fmus]
    with EcosSimulationStructure() as structure:
        for name, path in zip(names, fmus, strict=True):
            structure.add_model(name, str(path))
        for source, sink, variable in connections(fmus):
            structure.make_real_connection(f"{names[source]}::{variable}", f"{names[sink]}::{variable}")
        series = {
            name: (kind, f"{fmu}::{name}")
            for fmu, path in zip(names, fmus, strict=True)
            for kind in ("Real", "Integer")
            for name in references(path, "output", kind)
        }
        rows = []
        with EcosSimulation(step_size=float(time[1]), structure=structure) as simulation:
            simulation.init()
            read = {"Real": simulation.get_real, "Integer": simulation.get_integer}
            for k in range(len(time)):
                if k > 0:
                    simulation.step()
                rows.append([read[kind](identifier) for kind, identifier in series.values()])
            simulation.terminate()
    return dict(zip(series, np.transpose(rows), strict=True))


def load_tbb():
    """Load the library libtbb of the package tbb, because Ecos would search only the system's libraries."""
    library = next(file for file in importlib.metadata.files("tbb") if file.name == "libtbb.so.12")
    ctypes.CDLL(str(library.locate()), mode=ctypes.RTLD_GLOBAL)


MASTERS = {"fmpy": by_fmpy, "libcosim": by_libcosim, "ecos": by_ecos}


def build(scene, script, slave, folder, target="native"):
    """Build the FMUs of a scene and of the slave, a class in a script, in a folder; return both paths."""
    from chain_impact import build_fmu

    folder = Path(folder).resolve()
    arm = build_fmu(scene, folder, target=target)
    # in a separate process, because pythonfmu imports the script and keeps the module
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", script, "-d", folder]
    subprocess.run([*command, "--no-external-tool"], check=True, stdout=subprocess.DEVNULL)
    return arm, folder / f"{slave}.fmu"


def co_simulate(fmus, stop_time, step, master="fmpy"):
    """Co-simulate FMUs with one of the masters.

    Returns:
        Time and all outputs that are numbers at the communication points: name → array of shape (T,).
    """
    time = np.arange(round(stop_time / step) + 1) * step
    return {"time": time, **MASTERS[master](fmus, time)}


def run(doc, scene, *, plant, slave, stop_time, step, plot):
    """Build the FMUs of a scene and of a slave, and co-simulate them, as the command line of a script asks.

    Args:
        doc: the docstring of the script, whose first line tells what it does.
        scene: the folder of the scene's model.
        plant: what the scene is of, as the command's help calls it.
        slave: the script of the slave and its class.
        stop_time: in s.
        step: the communication step by default [s].
        plot: what the option of this name is for.

    Returns:
        The arguments of the command line, the paths of both FMUs, and what ``co_simulate`` returns.
    """
    parser = argparse.ArgumentParser(description=doc.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("build"), help="folder; build by default")
    parser.add_argument(
        "--target", default="native", choices=("native", "pythonfmu"), help=f"kind of the {plant}"
    )
    parser.add_argument("--master", default="fmpy", choices=MASTERS, help="what runs both; fmpy by default")
    parser.add_argument(
        "--step", type=float, default=step, help=f"communication step [s]; {step:g} by default"
    )
    parser.add_argument("--plot", help=plot)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    fmus = build(scene, *slave, arguments.output, arguments.target)
    try:
        return arguments, fmus, co_simulate(fmus, stop_time, arguments.step, arguments.master)
    except ImportError as error:
        from chain_impact.extras import how_to_install

        parser.error(f"--master {arguments.master}: {error}; {how_to_install('masters')}")
    except ValueError as error:
        parser.error(f"--step: {error}")
