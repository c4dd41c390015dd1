"""The effects, one file each: a module here declares `effect`, and the library finds it."""
