"""A plan of another program, verified and repaired."""

from pathlib import Path

import longstep

examples = Path(__file__).parent.parent
world = longstep.World(examples / "environments" / "flat.json", domain="virtualhome")
draft = examples / "plans" / "warm_cupcake.json"

for violation in longstep.verify(draft, world).violations:
    print(violation.message)
answer = longstep.repair(draft, world)
for edit in answer.edits:
    print(edit)
print(answer.verified())
assert longstep.verify(answer.verified(), world).is_verified
