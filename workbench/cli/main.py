"""Entry point `stagecad`. Imports happen after Ctrl-C is caught, since they are most of a short run."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence


def run(arguments: Sequence[str]) -> int:
    """Run one command line (without the program's name) and return its exit status, see `workbench.cli.dispatch`.

    Ctrl-C at any moment: `stopped`, and 130.
    """
    try:
        from workbench.cli.dispatch import run_line

        return run_line(arguments)
    except KeyboardInterrupt:
        import sys

        sys.stderr.write("stopped\n")
        return 130


def main() -> None:
    """Entry point of the installed program."""
    import faulthandler
    import gc
    import os
    import sys

    # Nearly all objects of a run stay until its end: they are looked through rarely, and not again at the end.
    gc.set_threshold(100_000)
    from stagecad.blas_threads import use_one_thread

    # Processes started from here import nothing from the working folder, which may hold somebody else's files.
    os.environ.setdefault("PYTHONSAFEPATH", "1")
    use_one_thread(os.environ)
    if os.path.expanduser("~") == "~":
        # A user without a home folder, as in a container: a library that looks for its settings there would fail.
        os.environ.setdefault("XDG_CONFIG_HOME", os.devnull)
    # Closed streams (`>&-`) are None, and what is printed goes nowhere.
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115
    # Where the CAD kernel ends the process, the line of the user's script at which it does is printed.
    faulthandler.enable()
    status = run(sys.argv[1:])
    if status == 130:
        # A library in C that met the interrupt first may have told the interpreter to end itself by the signal.
        import atexit
        from contextlib import suppress

        atexit._run_exitfuncs()
        with suppress(OSError, AttributeError):
            sys.stdout.flush()
        os._exit(status)
    gc.freeze()
    sys.exit(status)
