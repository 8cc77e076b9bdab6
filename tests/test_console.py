"""The console; the tests run each system's code on any machine."""

import io
import sys

import pytest

from chain_impact import console


@pytest.mark.parametrize("errors", ["strict", "surrogateescape"])
def test_signs_that_the_console_does_not_have_do_not_end_the_program(monkeypatch, errors):
    for name in ("stdout", "stderr"):
        monkeypatch.setattr(sys, name, io.TextIOWrapper(io.BytesIO(), encoding="cp1252", errors=errors))
    console.prepare_console()
    print("λ = 3 …")
    sys.stdout.flush()
    assert sys.stdout.buffer.getvalue() == "? = 3 …\n".encode("cp1252")
    monkeypatch.setattr(sys, "stdout", io.StringIO())  # a notebook replaces the output stream
    console.prepare_console()


def test_words_are_quoted_as_the_shell_takes_them(monkeypatch):
    monkeypatch.setattr(console, "SYSTEM", "Linux")
    assert console.quoted_word("a b[c]") == "'a b[c]'"
    monkeypatch.setattr(console, "SYSTEM", "Windows")
    assert console.quoted_word(r"C:\a b\python.exe") == r'"C:\a b\python.exe"'
