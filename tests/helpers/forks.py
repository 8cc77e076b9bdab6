"""Imports a module and then waits for functions to run, each in a process that is forked for it.

Its arguments: the folder of the module, and its name. A line on its standard input is a list in JSON: the
source of a function, or nothing for one of the module, its name, its arguments, and the files for what it
prints and for errors. The line that it answers is the exit code, or minus the number of a signal.
"""

import gc
import json
import linecache
import os
import sys
import traceback
from importlib import import_module
from typing import Any

LONGEST = 300  # characters of a line that is printed


def redirect(printed: str, errors: str) -> None:
    """Give this process files in place of the pipes of its parent."""
    for descriptor, path, mode in ((0, os.devnull, os.O_RDONLY), (1, printed, None), (2, errors, None)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC if mode is None else mode)
        os.dup2(file, descriptor)
        os.close(file)


def with_values(*error: Any) -> None:
    """Print what was raised, with the values of each function's names, as pytest does."""
    for text in traceback.TracebackException(*error, capture_locals=True).format():
        print(*(line[:LONGEST] for line in text.splitlines()), sep="\n", file=sys.stderr)


def main() -> None:
    """Answer until there are no more lines; a process that was forked returns, and so ends as any program."""
    sys.path.insert(0, sys.argv[1])
    names = {**vars(import_module(sys.argv[2])), "__name__": "__main__"}
    gc.freeze()  # else a process that ends looks through all that is imported, for longer than most run
    for line in sys.stdin:
        source, function, arguments, printed, errors = json.loads(line)
        child = os.fork()
        if child == 0:
            redirect(printed, errors)
            if source:
                linecache.cache["test"] = (len(source), None, source.splitlines(keepends=True), "test")
                sys.excepthook = with_values
                exec(compile(source, "test", "exec"), names)
            result = names[function](*arguments)
            if source:  # the result is on a line of its own after whatever importer and FMU have printed
                print("\n" + json.dumps(result))
            return
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


if __name__ == "__main__":
    main()
