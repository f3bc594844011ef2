#!/usr/bin/python3
"""Reads the JUnit files that ctest wrote into a folder; shows each failure with the end of its output, and what was
skipped or passed at a later trial only; ends with 'N passed, N failed'. Status 1 if any failed or none ran.

usage: tools/test_report.py DIR"""

import pathlib
import sys
import xml.etree.ElementTree as ET

SHOWN_LINES = 40
STOOD_STILL = "the machine stood still"  # so begins the line of tests/support/timed_main.cpp before another trial


def cases(folder):
    for path in sorted(folder.glob("*.xml")):
        yield from ET.parse(path).getroot().iter("testcase")


def main():
    passed, failed, skipped = [], [], []
    for case in cases(pathlib.Path(sys.argv[1])):
        why = case.find("skipped")
        if case.get("status") == "run":
            passed.append(case)
        elif why is not None and why.get("message") == "SKIP_REGULAR_EXPRESSION_MATCHED":
            skipped.append(case)
        else:  # failed, timed out, or could not be started
            failed.append(case)
    for case in skipped:
        print(f"skipped: {case.get('name')}")
    for case in passed:
        output = case.findtext("system-out") or ""
        for trial in [line for line in output.splitlines() if line.startswith(STOOD_STILL)][-1:]:
            print(f"passed at trial {output.count(STOOD_STILL) + 1}: {case.get('name')}: {trial}")
    for case in failed:
        lines = (case.findtext("system-out") or "").strip().splitlines()
        reason = case.find("failure")
        print(f"\nFAILED: {case.get('name')} ({float(case.get('time') or 0):.1f} s"
              f"{', ' + reason.get('message') if reason is not None and reason.get('message') else ''})")
        if len(lines) > SHOWN_LINES:
            print(f"  ... {len(lines) - SHOWN_LINES} lines left out")
        print("\n".join("  " + line for line in lines[-SHOWN_LINES:]))
    if failed:
        print("\nfailed tests:\n" + "\n".join("  " + case.get("name") for case in failed))
    if not passed and not failed:
        print("no test ran")
    print(f"{len(passed)} passed, {len(failed)} failed")
    return 0 if passed and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
