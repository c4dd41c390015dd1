"""Design calculators: pure functions on SI numbers; `machine` and `checks` apply them to a design."""
