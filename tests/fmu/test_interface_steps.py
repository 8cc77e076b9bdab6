"""The C interface of both kinds of FMU, held against the FMI standard 2.0.5: steps, and several instances."""

from collections import Counter
from ctypes import byref, c_char_p, c_double, c_int

from tests.fmu.interface import (
    DISCARD,
    DO_STEP_STATUS,
    ERROR,
    FATAL,
    LAST_SUCCESSFUL_TIME,
    OK,
    PENDING_STATUS,
    PHASES,
    TERMINATED_STATUS,
    Component,
    Library,
)

# The functions before each test run in the clean process, with all that interface.py has.


# --- 4.2.2 and 4.2.3: steps ------------------------------------------------------------------------------


def clocks(fmu):
    """Sums of steps that are no binary fractions, up to a stop time."""
    library, found = Library(fmu), []
    for size in (1e-3, 1e-2, 0.1, 0.3, 1.0 / 3.0):
        one, time = Component(library).start(7.7, 7.7 + 30 * size), 7.7
        statuses = set()
        for _ in range(30):
            statuses.add(one.step(time, size))
            time += size
        beyond = one.step(time, 1e-3 * size)
        found.append([sorted(statuses), beyond])
    return found


def test_clocks_may_differ_by_round_off_and_no_step_goes_beyond_the_stop_time(fmus, target, run):
    refusal = FATAL if target == "pythonfmu" else ERROR
    assert run(clocks, fmus["rod_drop"]) == [[[OK], refusal]] * 5


def failed_step(fmu):
    library = Library(fmu)
    one = Component(library).start(**{"solver.work_limit": 800.0})
    one.step(0.0, 0.125)
    state = one.state()
    failed = one.step(0.125, 1.0)
    said, cell, whole = library.messages[:], c_double(), c_int()
    reached = one.call("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(cell)), cell.value
    ended = one.call("fmi2GetBooleanStatus", TERMINATED_STATUS, byref(whole)), whole.value
    last = one.call("fmi2GetStatus", DO_STEP_STATUS, byref(whole)), whole.value
    none = one.call("fmi2GetStringStatus", PENDING_STATUS, byref(c_char_p()))
    code = one.integer("solver.status")
    back = one.call("fmi2SetFMUstate", state)
    again = [one.step(0.125, 0.125), one.call("fmi2Terminate"), one.integer("solver.status")]
    return [failed, said, reached, ended, last, none, code, back, again]


def test_a_step_that_cannot_be_finished_is_discarded_and_can_be_taken_back(native, run):
    failed, said, reached, ended, last, none, code, back, again = run(failed_step, native["four_link_box"])
    assert failed == DISCARD
    (message,) = said
    assert message[:3] == ["one", DISCARD, "logStatusDiscard"]
    assert message[3].startswith("the simulation stopped at t = ")
    assert reached[0] == OK
    assert 0.125 < reached[1] < 1.125
    assert ended == [OK, 0]
    assert last == [OK, DISCARD]
    assert none == DISCARD
    assert code == 9
    assert back == OK
    assert again == [OK, OK, 0]


def same_again(fmu, phases):
    """A run, and the same one after a reset, from each phase."""
    library, runs = Library(fmu), []
    one = Component(library)
    for phase in ("fresh", *phases):
        if phase != "fresh":
            one = Component(library)
            one.set_integer("contact.model", 3)
            one.bring_to(phase)
            one.call("fmi2Reset")
        start = one.serialized()
        one.start()
        rows = []
        for k in range(64):
            one.step(k * 2.0**-6, 2.0**-6)
            rows += one.outputs()
        runs.append([start.hex(), rows, one.serialized().hex()])
    return [run == runs[0] for run in runs]


def test_a_reset_instance_is_as_a_new_one_to_the_last_bit(fmus, target, run):
    phases = [phase for phase in PHASES if target != "pythonfmu" or phase != "step failed"]
    assert run(same_again, fmus["rod_drop"], phases) == [True] * (1 + len(phases))


# --- several instances -----------------------------------------------------------------------------------


def threads(fmu):
    """Instances in as many threads, at the same time: ctypes lets others run during a call."""
    from concurrent.futures import ThreadPoolExecutor

    library = Library(fmu)

    def run(number):
        one = Component(library, name=f"number {number}".encode()).start()
        rows = []
        for k in range(200):
            one.step(k * 2.0**-8, 2.0**-8)
            rows += one.outputs()
        one.step(0.0, -1.0)
        one.free()
        return rows

    alone = run(0)
    library.said()
    with ThreadPoolExecutor(8) as pool:
        runs = list(pool.map(run, range(16)))
    return [
        all(row == alone for row in runs),
        sorted(name for name, *_ in library.messages),
        len(library.blocks),
    ]


def test_instances_run_in_any_number_of_threads(strict, run):
    equal, names, blocks = run(threads, strict["four_link_box"])
    assert equal
    assert Counter(names) == Counter(f"number {n}" for n in range(16))
    assert blocks == 0


def global_symbols(first, second):
    """Two FMUs whose symbols are visible to all, and an instance of each."""
    import ctypes

    def run(library):
        one = Component(library).start()
        one.step(0.0, 0.5)
        return one.outputs()

    shared = [run(Library(fmu, mode=ctypes.RTLD_GLOBAL)) for fmu in (first, second)]
    return [shared == [run(Library(fmu)) for fmu in (first, second)], len(shared[0]) != len(shared[1])]


def test_fmus_do_not_mix_where_symbols_are_global(strict, run):
    assert run(global_symbols, strict["four_link_box"], strict["rod_drop"]) == [True, True]


def ten_thousand(fmu):
    """The growth of the process over many instances [kB]."""
    import resource

    library = Library(fmu)
    sizes = []
    for _ in range(3000):
        one = Component(library).start()
        one.step(0.0, 0.01)
        one.free()
        sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    return sizes[-1] - sizes[300]


def test_instances_leave_nothing_behind(strict, run):
    assert run(ten_thousand, strict["rod_drop"]) < 500
