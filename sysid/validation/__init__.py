"""Validation of a fitted model in the terms of system identification: residual correlations, information criteria."""
