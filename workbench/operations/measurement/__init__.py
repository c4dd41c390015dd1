"""What one can do with measurements and their models."""
