"""Figures of the results of the Python interface, in one style for print."""
