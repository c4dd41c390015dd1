"""Model meets measurement: records, comparison, diagnosis, and the ladder of effects."""
