"""``python -m chain_impact.cli``, the same as ``chain-impact``."""

import sys

from chain_impact.cli import main

sys.exit(main())
