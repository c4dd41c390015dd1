"""The Python interface: what `import stagecad` offers. Each name is loaded from its module when it is first used."""
