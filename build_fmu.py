"""Build the FMU of a scene: the same as `chain-impact build`."""

import sys

from chain_impact.cli import main

if __name__ == "__main__":
    sys.exit(main(["build", *sys.argv[1:]]))
