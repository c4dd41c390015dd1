"""The installed packages that stagecad needs, as a software bill of materials (CycloneDX 1.5, JSON), and their size.

`make sbom` writes it to build/sbom.json; the last line on standard error has the number and the size on the disk.
"""

from __future__ import annotations

import json
import re
import sys
from importlib.metadata import Distribution, PackageNotFoundError, distribution

from packaging.requirements import Requirement


def needed(name: str) -> dict[str, Distribution]:
    """The installed distributions that a package needs, directly or not, itself first."""
    found: dict[str, Distribution] = {}
    seen, pending = {(name, "")}, [(name, "")]
    while pending:
        wanted, extra = pending.pop()
        try:
            one = distribution(wanted)
        except PackageNotFoundError:  # for another system
            continue
        found[re.sub(r"[-_.]+", "-", wanted).lower()] = one
        for requirement in map(Requirement, one.requires or ()):
            if requirement.marker is None or requirement.marker.evaluate({"extra": extra}):
                new = {(requirement.name, more) for more in ("", *requirement.extras)} - seen
                seen |= new
                pending += sorted(new)
    return found


def licence(one: Distribution) -> str:
    """The licence that a distribution states."""
    metadata = one.metadata
    classified = [text.rpartition(" :: ")[2] for text in metadata.get_all("Classifier") or () if "License" in text]
    stated = metadata.get("License-Expression") or " or ".join(classified) or metadata.get("License") or "not stated"
    return stated.strip().splitlines()[0][:80]


def size(one: Distribution) -> int:
    """Bytes of a distribution's files on the disk."""
    paths = (one.locate_file(file) for file in one.files or ())
    return sum(path.stat().st_size for path in paths if path.is_file())  # type: ignore[attr-defined]


def main() -> None:
    every = needed("stagecad")
    parts = [
        {
            "type": "library",
            "name": one.metadata["Name"],
            "version": one.version,
            "purl": f"pkg:pypi/{key}@{one.version}",
            "licenses": [{"license": {"name": licence(one)}}],
        }
        for key, one in sorted(every.items())
    ]
    document = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "components": parts}
    json.dump(document, sys.stdout, indent=1)
    total = sum(size(one) for one in every.values())
    sys.stderr.write(f"{len(parts)} packages, {total / 1e6:.0f} MB\n")


if __name__ == "__main__":
    main()
