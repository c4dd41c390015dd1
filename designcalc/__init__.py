"""Design calculators: pure functions on SI numbers, one file each; `checks` alone knows the design."""
