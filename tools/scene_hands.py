#!/usr/bin/python3
"""Prints, for each device that a scene gives a tool to, its number, a tab and the file of the hand that moves it: the one
that the scene names, or 'still'.

usage: tools/scene_hands.py SCENE_FILE [--hand [DEVICE=]HAND]...
--hand: another hand for the device, by its name in config/hands or by its path; without a number for the first device"""

import argparse
import pathlib
import sys
import tomllib

HANDS = pathlib.Path(__file__).resolve().parent.parent / "config" / "hands"


def fail(text):
    sys.exit(f"tools/demo: {text}")


def hand_of_scene(scene, name):
    """The file that a scene means by a name or path (config/scenes/README.md tells the rule)."""
    if "/" in name or name.endswith(".toml"):
        candidates = [scene.parent / name]
    else:
        candidates = [scene.parent.parent / "hands" / f"{name}.toml", HANDS / f"{name}.toml"]
    for path in candidates:
        if path.is_file():
            return path
    fail(f"{scene}: there is no hand '{name}': {candidates[-1]} was expected")


def hand_of_user(name):
    for path in (HANDS / f"{name}.toml", pathlib.Path(name)):
        if path.is_file():
            return path
    fail(f"--hand {name}: no such file; config/hands has {' '.join(sorted(p.stem for p in HANDS.glob('*.toml')))}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--hand", action="append", default=[], metavar="[DEVICE=]HAND")
    options = parser.parse_args()
    try:
        proxies = tomllib.loads(options.scene.read_text(encoding="utf-8")).get("proxy", [])
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        fail(f"{options.scene}: {error}")
    hands = {}
    for proxy in proxies:
        hands[proxy.get("device", 0)] = hand_of_scene(options.scene, proxy.get("hand", "still"))
    for text in options.hand:
        device, _, name = text.rpartition("=")
        known = " ".join(map(str, sorted(hands))) or "none"
        if not hands or device and device not in map(str, hands):
            fail(f"--hand {text}: the scene has no tool for that device (it has: {known})")
        hands[int(device) if device else min(hands)] = hand_of_user(name)
    for device, path in sorted(hands.items()):
        print(f"{device}\t{path}")


if __name__ == "__main__":
    main()
