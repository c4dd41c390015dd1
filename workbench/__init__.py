"""User interface: command line, reports, demonstration records."""
