"""Designations of the threads, by their name in the table of threads (`threads.m6_tap_drill`).

Threads are cosmetic: the solid has the tap drill's hole, the sheet this text.
"""

from __future__ import annotations

DESIGNATION = {
    "m3": "M3x0.5",
    "m4": "M4x0.7",
    "m5": "M5x0.8",
    "m6": "M6x1",
    "m10": "M10x1.5",
    "unc_3_8": "3/8-16 UNC",
    "unc_1": "1-8 UNC",
}
"""Metric: ISO 261 coarse; tap drills by ISO 2306. Unified: ASME B1.1, 2B; tap drills 5/16 and 7/8 inch."""
