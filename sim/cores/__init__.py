"""Cores: the laws that turn the one friction level into a force. A core replaces the one before it."""
