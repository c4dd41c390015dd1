"""Checks of a machine of the user's own: those of the folder `checks`, which every machine may have."""

from designcalc.checks.run import Subjects

SUBJECTS = Subjects(checks={})
