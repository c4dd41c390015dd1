"""What one can do with a design and with measurements, and the results. No module here knows of the command line."""
