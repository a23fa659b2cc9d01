"""An independent simulator of plans, written from PDDL's semantics and the pages in docs/ alone.

It shares no line with the Rust libraries, and nobody who wrote it read them: where the two agree, both read the pages
in the same way. See docs/internals/peers.md.
"""
