"""Design checks: the values of the parameter file compared with what the calculators require."""
