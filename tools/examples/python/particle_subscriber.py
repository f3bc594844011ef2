#!/usr/bin/python3
"""A subscriber of particles: prints how high they are in each frame.

usage: particle_subscriber.py [FRAMES [DOMAIN]], beside palp-sim-server"""

import sys

import palp


def main():
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    bus = palp.Bus(domain=int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    while frames > 0:
        frame = bus.particles(timeout=1)
        if frame is None:
            continue
        height = frame["position"][:, 2]
        print(f"{frame['time']:.3f} s: {len(height)} particles, mean height {height.mean():.4f} m", flush=True)
        frames -= 1


main()
