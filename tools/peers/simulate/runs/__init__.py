"""Random runs of plans, judged: a world, a robot with faults and a person, written from the pages in docs/ alone.

docs/reference/execution.md says what a run promises. Nobody who wrote this read the execution of the Rust libraries. See docs/internals/peers.md.
"""
