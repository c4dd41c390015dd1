"""Write a set of cases.

python -m benchmarks.generators.hidden_effect FOLDER --seed 1 --count 100 [--hard 0.35] [--rows 20000] [--jobs 2]
"""

import argparse
from pathlib import Path

from .series import make_cases


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--hard", type=float, default=0.35)
    parser.add_argument("--rows", type=int, default=20000)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--levels", nargs="+", default=["strong", "moderate", "weak"])
    parser.add_argument("--effects", nargs="*", default=None)
    for kind, share in (("single", 0.5), ("none", 0.2), ("unexplained", 0.17), ("pair", 0.13)):
        parser.add_argument(f"--{kind}", type=float, default=share, help="share of the cases")
    a = parser.parse_args()
    shares = {kind: getattr(a, kind) for kind in ("single", "none", "unexplained", "pair")}
    make_cases(
        a.folder, a.seed, a.count, shares, hard=a.hard, levels=a.levels, rows=a.rows, effects=a.effects, jobs=a.jobs
    )


if __name__ == "__main__":
    main()
