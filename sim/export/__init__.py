"""A fitted model for use elsewhere: one step of its friction and forces, in several languages."""
