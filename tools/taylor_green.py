#!/usr/bin/env python3
"""Writes the particles of config/scenes/taylor_green.toml as CSV to standard output."""
import math

SPACING = 0.05
CELLS = (20, 10, 20)

print("x,y,z,vx,vy,vz")
for k in range(CELLS[2]):
    for j in range(CELLS[1]):
        for i in range(CELLS[0]):
            x, y, z = ((n + 0.5) * SPACING for n in (i, j, k))
            u = -math.cos(2 * math.pi * x) * math.sin(2 * math.pi * z)
            w = math.sin(2 * math.pi * x) * math.cos(2 * math.pi * z)
            print(f"{x:.6g},{y:.6g},{z:.6g},{u:.7g},0,{w:.7g}")
