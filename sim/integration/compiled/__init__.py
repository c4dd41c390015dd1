"""Laws, arrays and functions as machine code: see docs/compiled_integrator.md."""
