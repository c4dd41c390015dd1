"""One parameter file describes a piezo friction-drive stage; solids, checks and simulations are read off it."""

__version__ = "0.1.0"
