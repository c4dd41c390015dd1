"""What a user would have instead: sparse regression over a library of features made by hand."""
