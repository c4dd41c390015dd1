"""The thesis's simulations, each a function from numbers to data and features."""
