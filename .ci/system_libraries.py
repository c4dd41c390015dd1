"""Install the system libraries the CAD kernel loads (libGL, libexpat, libX11), or name the command that does."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys

NEEDED = {
    "libGL.so.1": "libgl1",
    "libexpat.so.1": "libexpat1",
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
}


def missing() -> list[str]:
    """Debian packages whose library cannot be loaded."""
    packages = []
    for library, package in NEEDED.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            packages.append(package)
    return packages


def main() -> int:
    """Exit status 0 when every library loads, after installing what is missing where that is allowed."""
    if not sys.platform.startswith("linux"):
        return 0
    packages = missing()
    if not packages:
        return 0
    command = ["apt-get", "install", "-y", "-qq", *packages]
    prefix: list[str] | None = None
    if shutil.which("apt-get"):
        if os.geteuid() == 0:
            prefix = []
        elif shutil.which("sudo") and subprocess.run(["sudo", "-n", "true"], capture_output=True).returncode == 0:
            prefix = ["sudo", "-n"]
    if prefix is not None:
        sys.stderr.write(f"installing system libraries: {' '.join(packages)}\n")
        subprocess.run([*prefix, "apt-get", "update", "-qq"], stdout=subprocess.DEVNULL)
        subprocess.run([*prefix, *command], stdout=subprocess.DEVNULL)
        packages = missing()
        if not packages:
            return 0
    sys.stderr.write(
        f"The CAD kernel needs system libraries that are not here ({', '.join(packages)}).\n"
        f"Install them with: sudo apt-get install -y {' '.join(packages)}\n"
    )
    return 1


if __name__ == "__main__":
    sys.exit(main())
