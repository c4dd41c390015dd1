"""Figures of results: one function a figure, which returns a matplotlib `Figure`."""
