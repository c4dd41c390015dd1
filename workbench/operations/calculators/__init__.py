"""The calculators of `stagecad calc`, a class each: its fields are the options, its method `results` computes."""
