"""A program that imports a module and then waits for functions to run, each in a forked process.

The arguments of the program are the folder and the name of the module. A line on standard input is a list in
JSON: the source of a function, or "" for a function of the module, the function's name and arguments, and the
files for output and for errors. The program answers with a line: the exit code, or minus the number of a
signal.
"""

import gc
import json
import linecache
import os
import sys
import traceback
from importlib import import_module
from typing import Any

LONGEST = 300  # largest number of characters of a value that is printed


def redirect(printed: str, errors: str) -> None:
    """Redirect the output of this process from its parent's pipes to files; its input is empty."""
    for descriptor, path, mode in ((0, os.devnull, os.O_RDONLY), (1, printed, None), (2, errors, None)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC if mode is None else mode)
        os.dup2(file, descriptor)
        os.close(file)


def with_values(*error: Any) -> None:
    """Print an exception with the values of each function's names, as pytest does."""
    for text in traceback.TracebackException(*error, capture_locals=True).format():
        print(*(line[:LONGEST] for line in text.splitlines()), sep="\n", file=sys.stderr)


def main() -> None:
    """Answer until there are no more lines; a forked process returns, and so ends like any program."""
    sys.path.insert(0, sys.argv[1])
    names = {**vars(import_module(sys.argv[2])), "__name__": "__main__"}
    # otherwise a process that ends would examine all imported objects, which takes longer than most runs
    gc.freeze()
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
            if source:  # the result is on a separate line after the output of importer and FMU
                print("\n" + json.dumps(result))
            return
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


if __name__ == "__main__":
    main()
