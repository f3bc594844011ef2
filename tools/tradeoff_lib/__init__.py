"""The parts of tools/tradeoff: what is tried, how it is run, judged and shown."""
