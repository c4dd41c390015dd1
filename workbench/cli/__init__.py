"""The command line: `stagecad`."""

from workbench.cli.main import main as main
from workbench.cli.main import run as run
