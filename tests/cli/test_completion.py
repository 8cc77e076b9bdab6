"""Shell completions: the answers of argcomplete, and a shell that loads the script."""

# Tests: cli/completers.py

import os
import shutil
import subprocess
import sys

import pytest

from chain_impact.cli import completion


def asked(line, folder):
    """Return the completions that argcomplete's scripts give a shell for an incomplete line."""
    answer_file = folder / "answer"
    settings = {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(answer_file),
    }
    settings |= {"COMP_LINE": line, "COMP_POINT": str(len(line)), "COMP_TYPE": "9"}
    command = [sys.executable, "-m", "chain_impact.cli"]
    process = subprocess.run(command, cwd=folder, env=os.environ | settings, capture_output=True, check=False)
    assert process.returncode == 0
    return [word.rstrip() for word in answer_file.read_text(encoding="utf-8").splitlines()]


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("chain-impact s", ["simulate", "sweep"]),
        ("chain-impact info rod_d", ["rod_drop"]),
        ("chain-impact info mine", ["mine.toml"]),
        ("chain-impact animate mine.csv --scene rod_d", ["rod_drop"]),
        ("chain-impact sweep --sampl", ["--samples", "--sampling"]),
        ("chain-impact simulate pinned_arm --set contact.re", ["contact.restitution="]),
        ("chain-impact simulate --set contact.model=newt", ["contact.model=newton_impact"]),
        ("chain-impact compare --laws flores,hert", ["flores,hertz"]),
        (
            "chain-impact simulate pinned_arm --curves energy.total,point[2].vx",
            [r"energy.total,point\[2\].vx"],
        ),
        ("chain-impact simulate pinned_arm --rank joint_f", ["joint_force"]),
        ("chain-impact sweep --vary contact.rad", ["contact.radius="]),
        ("chain-impact simulate nowhere.toml --set contact.re", []),
    ],
)
def test_the_shell_is_told_what_can_stand_there(line, words, tmp_path):
    (tmp_path / "mine.toml").touch()
    (tmp_path / "mine.txt").touch()
    assert asked(line, tmp_path) == words


@pytest.mark.full("more cases", but="bash")
@pytest.mark.parametrize("shell", completion.SHELLS)
def test_there_is_a_script_for_each_shell(shell, tmp_path):
    command = [sys.executable, "-m", "chain_impact.cli", "completion", shell]
    process = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "chain-impact" in process.stdout
    program = shutil.which(shell)
    if program:  # bash, the first shell, is always there on Debian
        script = tmp_path / "script"
        script.write_text(process.stdout, encoding="utf-8")
        subprocess.run([program, "-n", script], check=True)


def test_completion_is_imported_only_where_a_shell_asks():
    program = "import sys; from chain_impact import cli; cli.main(['info', 'rod_drop', '-q']);"
    program += "print('argcomplete' in sys.modules)"
    process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert process.stdout.splitlines()[-1] == "False"
