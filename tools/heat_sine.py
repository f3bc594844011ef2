#!/usr/bin/env python3
"""Writes the particles of config/scenes/heat_sine.toml as CSV to standard output."""
import math

SPACING = 0.05
CELLS = (20, 10, 10)

print("x,y,z,temperature")
for k in range(CELLS[2]):
    for j in range(CELLS[1]):
        for i in range(CELLS[0]):
            x, y, z = ((n + 0.5) * SPACING for n in (i, j, k))
            print(f"{x:.6g},{y:.6g},{z:.6g},{300 + 10 * math.sin(2 * math.pi * x):.8g}")
