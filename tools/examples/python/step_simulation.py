#!/usr/bin/python3
"""A simulation stepped without a bus: lowers the scene's tool and prints the force on it.

usage: step_simulation.py [SCENE [SECONDS]], a scene's file or bare name"""

import sys

import numpy
import palp


def main():
    scene = sys.argv[1] if len(sys.argv) > 1 else "tray_fluid"
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 0.2
    simulation = palp.Simulation(scene, accuracy="fast", backend="cpu")
    print(simulation.backend)
    position, velocity = simulation.tool()["position"], numpy.array([0, 0, -0.02])
    while simulation.time < seconds:
        simulation.move_tool(0, position, velocity)
        simulation.step(1)
        position = position + velocity / simulation.rate_hz
        if round(simulation.time * simulation.rate_hz) % 20 == 0:
            speed = numpy.linalg.norm(simulation.particles()["velocity"], axis=1).max()
            print(f"{simulation.time:.3f} s: force {simulation.tool()['force'][2]:.3f} N, fastest particle {speed:.3f} m/s")


main()
