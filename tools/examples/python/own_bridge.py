#!/usr/bin/python3
"""A bridge of one's own: plays a device that moves up and down, and prints the force that a hand would feel.

usage: own_bridge.py [SECONDS [DOMAIN]], beside palp-sim-server"""

import math
import sys
import time

import palp


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10
    bus = palp.Bus(domain=int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    while not (scene := bus.scene()):
        time.sleep(0.1)
    tool = scene["tools"][0]
    x, y, z = tool["position"]
    amplitude, rate = 0.01, 2 * math.pi * 0.5  # m, rad/s
    proxy = None
    began = time.monotonic()
    for i in range(int(1000 * seconds)):
        t = i / 1000
        time.sleep(max(0, began + t - time.monotonic()))
        bus.send_device(tool["device"], [x, y, z - amplitude * (1 - math.cos(rate * t))], tool["orientation"],
                        velocity=[0, 0, -amplitude * rate * math.sin(rate * t)])
        proxy = bus.proxy() or proxy
        if proxy and i % 100 == 99:
            print(f"{t:.1f} s: force", *(f"{f:.3f}" for f in proxy["force"]), "N", flush=True)


main()
